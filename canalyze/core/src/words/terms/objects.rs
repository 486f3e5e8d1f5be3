//! Names of the standard objects: the communication profile area (CiA 301, 302, 304). Those of 6000h-9FFFh are the
//! device profile's. A name from an EDS takes precedence, which is the caller's part.

use crate::words::Lang;
use crate::words::profiles::Profile;

/// Objects with one name: first and last index, zh, en, the sub-indices with names of their own.
type ObjectRange = (u16, u16, &'static str, &'static str, &'static [Sub]);
/// A sub-index with a name of its own: zh, en.
type Sub = (u8, &'static str, &'static str);

static OBJECTS: &[ObjectRange] = words!("objects");

/// Returns the name of an object or of one of its sub-indices. A sub-index without a name of its own has the object's.
pub fn object_name(lang: Lang, profile: Profile, index: u16, sub: u8) -> Option<&'static str> {
    if index >= 0x6000 {
        return profile.name(index, sub).map(|(zh, en)| lang.pick(zh, en));
    }
    let after = OBJECTS.partition_point(|row| row.0 <= index);
    let (_, _, zh, en, subs) = OBJECTS.get(after.checked_sub(1)?).filter(|row| index <= row.1)?;
    let own = subs.iter().find(|row| row.0 == sub);
    Some(own.map_or(lang.pick(zh, en), |(_, zh, en)| lang.pick(zh, en)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::words::lang::tests::sound;

    #[test]
    fn tables_are_sound() {
        sound(&OBJECTS.iter().map(|row| (row.0, row.2, row.3)).collect::<Vec<_>>());
        for (first, last, .., subs) in OBJECTS {
            sound(subs);
            for (sub, ..) in *subs {
                // A sub-index with a name has a type.
                for index in [*first, *last] {
                    assert!(crate::world::od::communication(index, *sub).is_some(), "{index:04X}:{sub}");
                }
            }
        }
    }

    #[test]
    fn names() {
        assert_eq!(object_name(Lang::Zh, Profile::UNKNOWN, 0x1008, 0), Some("设备名称"));
        assert_eq!(object_name(Lang::En, Profile::UNKNOWN, 0x1008, 0), Some("manufacturer device name"));
        assert_eq!(object_name(Lang::Zh, Profile::UNKNOWN, 0x1018, 1), Some("制造商ID"));
        assert_eq!(object_name(Lang::En, Profile::UNKNOWN, 0x1018, 0), Some("identity object"));
        assert_eq!(object_name(Lang::En, Profile::UNKNOWN, 0x1805, 1), Some("COB-ID used by TPDO"));
        assert_eq!(object_name(Lang::En, Profile::UNKNOWN, 0x1A05, 3), Some("TPDO mapping parameter"));
        assert_eq!(object_name(Lang::Zh, Profile::UNKNOWN, 0x6841, 0), Some("状态字"));
        for unknown in [0x0000, 0x0FFF, 0x1004, 0x1341, 0x1C00, 0x2000, 0x6000, 0xA040, 0xFFFF] {
            assert_eq!(object_name(Lang::Zh, Profile::UNKNOWN, unknown, 0), None, "{unknown:04X}");
        }
    }

    #[test]
    fn every_standard_type_has_a_name() {
        for index in 0x1000..=0x1FFF {
            for sub in 0..=8 {
                if crate::world::od::communication(index, sub).is_some() {
                    assert!(object_name(Lang::Zh, Profile::UNKNOWN, index, sub).is_some(), "{index:04X}:{sub}");
                }
            }
        }
    }
}
