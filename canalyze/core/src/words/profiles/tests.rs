//! The tables: right where it is known from devices.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use super::*;

#[test]
fn tables_are_complete() {
    for profile in Profile::KNOWN {
        let known = (0x6000..=0x9FFF).filter(|index| profile.name(*index, 0).is_some()).count();
        assert!(known >= 8, "{profile:?}");
    }
    for table in [CIA401, CIA402, CIA404, CIA406, CIA410, CIA418, CIA419] {
        for (index, shape, .., parts) in table {
            assert!((0x6000..=0x9FFF).contains(index), "{index:04X}");
            assert_eq!(matches!(shape, Record), !parts.is_empty(), "{index:04X}");
            assert!(parts.iter().all(|part| part.0 > 0), "{index:04X}");
        }
    }
}

#[test]
fn every_type_has_a_name() {
    for profile in Profile::KNOWN.into_iter().chain([Profile::UNKNOWN]) {
        for index in 0x6000..=0x9FFF {
            for sub in [0, 1, 2, 8, 0xFE] {
                let typed = profile.data_type(index, sub).is_some();
                assert!(!typed || profile.name(index, sub).is_some(), "{profile:?}: {index:04X}:{sub}");
            }
        }
    }
}

/// Types and sizes as in the descriptions of devices with these profiles.
#[test]
fn types_as_devices_have_them() {
    let rows = [
        (401, 0x6000, 0, Some(Unsigned8)),
        (401, 0x6000, 1, Some(Unsigned8)),
        (401, 0x6005, 0, Some(Boolean)),
        (401, 0x6005, 1, None),
        (401, 0x6020, 1, Some(Boolean)),
        (401, 0x6100, 1, Some(Unsigned16)),
        (401, 0x6120, 1, Some(Unsigned32)),
        (401, 0x6200, 8, Some(Unsigned8)),
        (401, 0x6400, 1, Some(Integer8)),
        (401, 0x6401, 1, Some(Integer16)),
        (401, 0x6402, 1, Some(Integer32)),
        (401, 0x6403, 1, Some(Real32)),
        (401, 0x6411, 12, Some(Integer16)),
        (401, 0x6421, 1, Some(Unsigned8)),
        (401, 0x6423, 0, Some(Boolean)),
        (401, 0x6424, 1, Some(Integer32)),
        (401, 0x6426, 1, Some(Unsigned32)),
        (401, 0x6041, 0, None),
        (401, 0x6064, 0, None),
        (402, 0x6041, 0, Some(Unsigned16)),
        (402, 0x6841, 0, Some(Unsigned16)),
        (402, 0x60C4, 3, Some(Unsigned8)),
        (402, 0x60C4, 4, Some(Unsigned16)),
        (402, 0x60C4, 7, None),
        (402, 0x6402, 0, Some(Unsigned16)),
        (402, 0x6403, 0, Some(VisibleString)),
        (402, 0x6401, 1, None),
        (404, 0x6130, 1, Some(Real32)),
        (404, 0x7130, 1, Some(Integer16)),
        (404, 0x9130, 1, Some(Integer32)),
        (406, 0x6000, 0, Some(Unsigned16)),
        (406, 0x6004, 0, Some(Unsigned32)),
        (406, 0x6030, 1, Some(Integer16)),
        (406, 0x6030, 0, Some(Unsigned8)),
        (406, 0x6509, 0, Some(Integer32)),
        (410, 0x6010, 0, Some(Integer16)),
        (410, 0x6011, 0, Some(Unsigned8)),
        (410, 0x6110, 0, Some(Integer32)),
        (418, 0x6010, 0, Some(Integer16)),
        (418, 0x6020, 2, Some(Unsigned16)),
        (418, 0x6060, 0, Some(Unsigned32)),
        (418, 0x6054, 0, None),
        (419, 0x6081, 0, Some(Unsigned8)),
        (419, 0x6040, 0, None),
        (0, 0x6041, 0, Some(Unsigned16)),
        (0, 0x6860, 0, Some(Integer8)),
        (0, 0x98FF, 0, Some(Integer32)),
        (0, 0xA040, 0, None),
        (0, 0x2000, 0, None),
        (0, 0x6401, 1, None),
        (0, 0x6402, 0, None),
        (408, 0x6041, 0, None),
        (408, 0x1018, 1, Some(Unsigned32)),
    ];
    for (profile, index, sub, expected) in rows {
        assert_eq!(Profile(profile).data_type(index, sub), expected, "CiA {profile} {index:04X}:{sub}");
    }
}

#[test]
fn a_device_type_names_the_profile() {
    for (device_type, number) in
        [(0x000F_0191, 401), (0x0002_0192, 402), (0, 0), (0x0001_0000, 0), (0xFFFF_FFFF, 0), (0x0008_0196, 406)]
    {
        assert_eq!(Profile::of(device_type).number(), number, "{device_type:08X}");
    }
    assert!(Profile::of(0).may_be_drive() && Profile::DRIVE.may_be_drive() && !Profile::IO.may_be_drive());
}

/// A node that is not a drive has no names of one, and a drive none of an input module.
#[test]
fn profiles_do_not_mix() {
    assert_eq!(Profile::IO.name(0x6041, 0), None);
    assert_eq!(Profile::IO.name(0x6007, 1).map(|words| words.1), Some("interrupt mask low to high 8-bit"));
    assert_eq!(Profile::DRIVE.name(0x6007, 0).map(|words| words.1), Some("abort connection option code"));
    assert_eq!(Profile::UNKNOWN.name(0x6007, 0), Profile::DRIVE.name(0x6007, 0));
    assert_eq!(Profile::DRIVE.name(0x6401, 1), None);
    assert_eq!(Profile::DRIVE.name(0x6402, 0).map(|words| words.1), Some("motor type"));
    assert_eq!(Profile::UNKNOWN.name(0x6402, 0), None);
    assert_eq!(Profile(408).name(0x6041, 0), None);
    assert_eq!(Profile::DRIVE.name(0x6841, 0), Profile::DRIVE.name(0x6041, 0));
    assert_eq!(Profile::IO.name(0x6801, 0), None);
}

#[test]
fn emergencies() {
    let words = |number, code| Profile(number).emergency(code).map(|words| words.1);
    assert_eq!(words(402, 0x3210), Some("DC link over-voltage"));
    assert_eq!(words(402, 0x3219), Some("DC link over-voltage"), "a case of it");
    assert_eq!(words(402, 0x7305), Some("incremental sensor 1 fault"));
    assert_eq!(words(402, 0x8611), Some("following error"));
    assert_eq!(words(401, 0x3210), Some("internal voltage too high"));
    assert_eq!(words(401, 0x8611), None);
    assert_eq!(words(402, 0x8130), None, "CiA 301's own");
    assert_eq!(words(0, 0x3210), None);
}

/// Kinds separate plots: a position is not a velocity, an input is not an output.
#[test]
fn kinds_of_quantities() {
    let rows = [
        (402, 0x6064, Some("position")),
        (402, 0x607A, Some("position")),
        (402, 0x686C, Some("velocity")),
        (402, 0x6077, Some("torque")),
        (402, 0x6041, None),
        (0, 0x6064, Some("position")),
        (401, 0x6064, None),
        (401, 0x6000, Some("digital input")),
        (401, 0x6300, Some("digital output")),
        (401, 0x6401, Some("analogue input")),
        (401, 0x6411, Some("analogue output")),
        (406, 0x6004, Some("position value")),
        (408, 0x6041, None),
    ];
    for (profile, index, expected) in rows {
        assert_eq!(Profile(profile).kind(index), expected, "CiA {profile} {index:04X}");
    }
}
