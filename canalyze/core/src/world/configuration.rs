//! The values of one node's communication objects, and their sources.
//!
//! Values come from acknowledged SDO writes and successful reads, from options, from a DCF, from an EDS, in this order
//! of trust. Values that were only requested, by writes without a response in the capture, are kept apart from them. A
//! written value does not survive a reset unless it was stored (1010h); a value that was read before any write is the
//! stored one and does; restored defaults (1011h) are in force from the next reset on (CiA 301, 7.5.2.13 and .14). The
//! meaning of the values to a service is not known here.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::sdo::transfer::Direction;
use crate::sdo::wire::Mux;
use crate::world::dictionary::{Dictionary, Form, Object};

/// Maximum number of objects of one node that are kept (invariant 6): more than any real device has in the ranges
/// below.
const KEPT: usize = 4096;
/// "save" and "load" in the byte order of 1010h and 1011h.
const SAVE: u64 = 0x6576_6173;
const LOAD: u64 = 0x6461_6F6C;

/// The source of a value, in the order of trust.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Provenance {
    /// The standard's default: the pre-defined connection set.
    Default,
    /// A write in the capture, with this frame, to which the capture shows no response. Matching frames are decoded by
    /// it, but no check uses it.
    Unconfirmed(u64),
    /// The capture, with this frame; but the value may have changed: frames were lost since, or it was written with a
    /// transfer whose result is unknown. Frames are still decoded by it, but no check uses it.
    Doubted(u64),
    /// The default mapping of a profile that the user has named.
    Profile,
    /// An EDS.
    Eds,
    /// A DCF, or a concise DCF seen in the capture.
    Dcf,
    /// An option of the command line or of canalyze.toml.
    Option,
    /// The capture itself: the frame that showed it.
    Observed(u64),
}

impl Provenance {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Profile => "profile",
            Self::Eds => "eds",
            Self::Dcf => "dcf",
            Self::Option => "option",
            Self::Observed(_) | Self::Doubted(_) => "observed",
            Self::Unconfirmed(_) => "unconfirmed",
        }
    }

    /// Returns the frame with which the capture has shown it, whether or not it is in doubt since.
    pub fn frame(self) -> Option<u64> {
        match self {
            Self::Observed(frame) | Self::Doubted(frame) | Self::Unconfirmed(frame) => Some(frame),
            _ => None,
        }
    }

    /// Returns true if it may be outdated, so that no check uses it.
    pub fn is_doubted(self) -> bool {
        matches!(self, Self::Doubted(_) | Self::Unconfirmed(_))
    }

    /// Returns true if no response has confirmed it.
    pub fn is_unconfirmed(self) -> bool {
        matches!(self, Self::Unconfirmed(_))
    }

    /// Returns true if it is about this very node, and not only about its kind of device.
    pub fn is_told(self) -> bool {
        self > Self::Eds || self.is_doubted()
    }
}

/// A value and its source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownValue {
    /// The number, at most 64 bits.
    pub value: u64,
    /// Its provenance.
    pub from: Provenance,
}

type Address = (u16, u8);

/// The value requested by a write.
#[derive(Clone, Copy, Debug)]
struct Requested {
    value: u64,
    /// The frame of its request.
    frame: u64,
    /// The capture is known to lack a response; until then one may come.
    unanswered: bool,
}

/// The configuration of one node.
#[derive(Debug, Default)]
pub struct Configuration {
    description: Option<Arc<Dictionary>>,
    /// By option.
    options: BTreeMap<Address, u64>,
    /// The defaults of a profile that the user has named, for a node without a description.
    profile: BTreeMap<Address, u64>,
    /// From a concise DCF (1F22h) that a configuration manager received for this node.
    concise: BTreeMap<Address, u64>,
    /// Values shown by the capture, with their frames.
    observed: BTreeMap<Address, (u64, u64)>,
    /// Values after a reset, as far as the capture shows them.
    stored: BTreeMap<Address, (u64, u64)>,
    /// Objects written since the last reset or store.
    written: BTreeSet<Address>,
    restored: bool,
    /// The last frame before frames were lost: values observed up to it may have changed.
    doubted_to: Option<u64>,
    /// Objects written without a valid response, with the frame that showed it: the old or the new value may be in
    /// force.
    unsure: BTreeMap<Address, u64>,
    /// Likewise for stored values.
    unsure_stored: BTreeMap<Address, u64>,
    /// Values requested by writes that were neither confirmed nor refused.
    requested: BTreeMap<Address, Requested>,
    /// Objects whose value may differ from the stored one.
    unstored: BTreeSet<Address>,
    /// Objects observed since frames were lost.
    undoubted: BTreeSet<Address>,
    /// Objects that have changed since the node's PDOs were compiled.
    uncompiled: BTreeSet<u16>,
    /// Objects that have changed since identifiers were assigned to roles.
    unassigned: BTreeSet<u16>,
    /// Objects, except those of PDOs, that have changed since checks were notified.
    untold: BTreeSet<u16>,
}

/// Returns true if decoding depends on an object.
pub fn concerns(index: u16) -> bool {
    matches!(
        index,
        0x1000 | 0x1005..=0x1007 | 0x100C | 0x100D | 0x1012 | 0x1014..=0x1019 | 0x1200..=0x12FF | 0x1301..=0x13C0 | 0x1400..=0x1BFF
    )
}

/// Returns true if a requested value of an object is used: it is a COB-ID of SYNC, EMCY or a PDO, or a part of a
/// mapping.
fn is_decoded_by(Mux { index, sub }: Mux) -> bool {
    match index {
        0x1005 | 0x1014 => sub == 0,
        0x1400..=0x15FF | 0x1800..=0x19FF => sub == 1,
        0x1600..=0x17FF | 0x1A00..=0x1BFF => true,
        _ => false,
    }
}

/// Returns true if an object is a communication or mapping parameter of a PDO.
fn is_of_pdo(index: u16) -> bool {
    matches!(index, 0x1400..=0x1BFF)
}

impl Configuration {
    /// Returns the node's description, if there is one.
    pub fn description(&self) -> Option<&Arc<Dictionary>> {
        self.description.as_ref()
    }

    /// Sets the node's description.
    pub fn describe(&mut self, dictionary: Arc<Dictionary>) {
        self.description = Some(dictionary);
    }

    /// Sets a value by option.
    pub fn set_option(&mut self, index: u16, sub: u8, value: u64) {
        self.options.insert((index, sub), value);
    }

    /// Sets a value that holds by the node's profile, unless it has a description.
    pub fn assume(&mut self, index: u16, sub: u8, value: u64) {
        if self.description.is_none() {
            self.profile.insert((index, sub), value);
        }
    }

    /// An object of the description.
    pub fn object(&self, index: u16, sub: u8) -> Option<&Arc<Object>> {
        self.description.as_ref()?.get(index, sub)
    }

    /// Returns the value of an object on node `node` from the most trusted source.
    pub fn get(&self, node: u8, index: u16, sub: u8) -> Option<KnownValue> {
        let known = self.before_writing(node, index, sub)?;
        let unsure = self.unsure.get(&(index, sub)).map(|frame| Provenance::Doubted(*frame));
        Some(KnownValue { from: unsure.unwrap_or(known.from), ..known })
    }

    /// Likewise, but ignores pending writes.
    pub fn before_writing(&self, node: u8, index: u16, sub: u8) -> Option<KnownValue> {
        let address = (index, sub);
        if let Some((value, frame)) = self.observed.get(&address) {
            let doubted = self.doubted_to.is_some_and(|lost| *frame <= lost);
            let from = if doubted { Provenance::Doubted(*frame) } else { Provenance::Observed(*frame) };
            return Some(KnownValue { value: *value, from });
        }
        if let Some(value) = self.options.get(&address) {
            return Some(KnownValue { value: *value, from: Provenance::Option });
        }
        if let Some(value) = self.concise.get(&address) {
            return Some(KnownValue { value: *value, from: Provenance::Dcf });
        }
        let of_profile =
            || self.profile.get(&address).map(|value| KnownValue { value: *value, from: Provenance::Profile });
        self.described(node, index, sub).or_else(of_profile)
    }

    /// Returns the description's value of an object.
    pub fn described(&self, node: u8, index: u16, sub: u8) -> Option<KnownValue> {
        let description = self.description.as_ref()?;
        let object = description.get(index, sub)?;
        let dcf = object.preset?.configured || description.form == Form::Dcf;
        Some(KnownValue { value: object.preset_at(node)?, from: if dcf { Provenance::Dcf } else { Provenance::Eds } })
    }

    /// Returns true if something of an object is known from another source than an EDS.
    pub fn is_beyond_eds(&self, index: u16) -> bool {
        let filed = |description: &Arc<Dictionary>| {
            let dcf = description.form == Form::Dcf;
            description.of(index).iter().any(|object| object.preset.is_some_and(|preset| dcf || preset.configured))
        };
        has(&self.observed, index)
            || has(&self.options, index)
            || has(&self.concise, index)
            || self.description.as_ref().is_some_and(|description| description.configures && filed(description))
    }

    /// Returns true if something is known of an object.
    pub fn holds(&self, index: u16) -> bool {
        has(&self.observed, index)
            || [&self.options, &self.concise, &self.profile].into_iter().any(|values| has(values, index))
            || self.description.as_ref().is_some_and(|description| description.has(index))
    }

    /// Returns the objects that have changed since the last call, for the node's PDOs.
    pub fn uncompiled(&mut self) -> BTreeSet<u16> {
        std::mem::take(&mut self.uncompiled)
    }

    /// Likewise for the roles of identifiers. PDOs that are not yet compiled again follow later.
    pub fn unassigned(&mut self) -> BTreeSet<u16> {
        let (later, now) = std::mem::take(&mut self.unassigned)
            .into_iter()
            .partition(|index| is_of_pdo(*index) && self.uncompiled.contains(index));
        self.unassigned = later;
        now
    }

    /// Likewise for checks, without the objects of PDOs.
    pub fn untold(&mut self) -> BTreeSet<u16> {
        std::mem::take(&mut self.untold)
    }

    /// Marks all values as changed for checks.
    pub fn all_untold(&mut self) {
        self.untold.extend(self.indices(0x1000..=0x13FF));
    }

    fn changed(&mut self, index: u16) {
        self.unassigned.insert(index);
        if is_of_pdo(index) || index == 0x1000 {
            self.uncompiled.insert(index);
        } else {
            self.untold.insert(index);
        }
    }

    /// Returns every index of `range` with a known value, ascending.
    pub fn indices(&self, range: std::ops::RangeInclusive<u16>) -> BTreeSet<u16> {
        let span = (*range.start(), 0)..=(*range.end(), u8::MAX);
        let mut found: BTreeSet<u16> = self.observed.range(span.clone()).map(|((index, _), _)| *index).collect();
        found.extend(self.options.range(span.clone()).map(|((index, _), _)| *index));
        found.extend(self.concise.range(span.clone()).map(|((index, _), _)| *index));
        found.extend(self.profile.range(span).map(|((index, _), _)| *index));
        if let Some(description) = &self.description {
            found.extend(description.within(range).iter().map(|object| object.index));
        }
        found
    }

    /// Takes the value that an SDO transfer has shown. Returns true if a value on which decoding depends has changed.
    pub fn learn(&mut self, direction: Direction, mux: Mux, bytes: &[u8], frame: u64) -> bool {
        let Some(value) = number(bytes) else { return false };
        let address = (mux.index, mux.sub);
        match (direction, mux.index, value) {
            // Sub-index 1 stores all parameters, 2 the communication parameters.
            (Direction::Download, 0x1010, SAVE) if matches!(mux.sub, 1 | 2) => {
                for address in std::mem::take(&mut self.unstored) {
                    take_over(&mut self.stored, &self.observed, address);
                    take_over(&mut self.unsure_stored, &self.unsure, address);
                }
                self.written.clear();
                self.restored = false;
                return false;
            }
            (Direction::Download, 0x1011, LOAD) if matches!(mux.sub, 1 | 2) => {
                self.restored = true;
                return false;
            }
            _ => {}
        }
        if !concerns(mux.index) || (self.observed.len() >= KEPT && !self.observed.contains_key(&address)) {
            return false;
        }
        match direction {
            Direction::Download => {
                self.written.insert(address);
            }
            Direction::Upload if !self.written.contains(&address) => {
                self.stored.insert(address, (value, frame));
            }
            Direction::Upload => {}
        }
        self.unstored.insert(address);
        self.undoubted.insert(address);
        self.changed(mux.index);
        let unsure = self.unsure.remove(&address).is_some();
        let unsure = self.requested.remove(&address).is_some_and(|it| it.unanswered) || unsure;
        self.observed.insert(address, (value, frame)).is_none_or(|(before, _)| before != value) || unsure
    }

    /// Notes that the frame `frame` writes an object, with an unknown result. Returns true if a value on which decoding
    /// depends is in doubt now.
    pub fn attempted(&mut self, mux: Mux, frame: u64) -> bool {
        let address = (mux.index, mux.sub);
        let room = self.unsure.len() < KEPT && !self.unsure.contains_key(&address);
        if !concerns(mux.index) || !room {
            return false;
        }
        self.unsure.insert(address, frame);
        self.unstored.insert(address);
        self.changed(mux.index);
        true
    }

    /// Takes the value requested by a write with the frame `frame`. Returns true if it replaces a previous unanswered
    /// write.
    pub fn request(&mut self, mux: Mux, bytes: &[u8], frame: u64) -> bool {
        let address = (mux.index, mux.sub);
        let before = self.requested.remove(&address).is_some_and(|it| it.unanswered);
        if before {
            self.changed(mux.index);
        }
        if let Some(value) = number(bytes).filter(|_| is_decoded_by(mux) && self.requested.len() < KEPT) {
            self.requested.insert(address, Requested { value, frame, unanswered: false });
        }
        before
    }

    /// Notes that the last write of an object has no response in the capture. Returns true if frames may be decoded by
    /// it now.
    pub fn unanswered(&mut self, mux: Mux) -> bool {
        let requested = self.requested.get_mut(&(mux.index, mux.sub));
        let changed = requested.is_some_and(|it| !std::mem::replace(&mut it.unanswered, true));
        if changed {
            self.changed(mux.index);
        }
        changed
    }

    /// Drops the requested values of an object: they were refused, or frames contradict them. Returns true if frames
    /// were decoded by them.
    pub fn withdraw(&mut self, index: u16, sub: Option<u8>) -> bool {
        let (first, last) = sub.map_or((0, u8::MAX), |sub| (sub, sub));
        let concerned: Vec<Address> =
            self.requested.range((index, first)..=(index, last)).map(|(address, _)| *address).collect();
        for address in &concerned {
            self.requested.remove(address);
            self.changed(index);
        }
        !concerned.is_empty()
    }

    /// Returns the value requested by an unanswered write.
    pub fn requested(&self, index: u16, sub: u8) -> Option<KnownValue> {
        let it = self.requested.get(&(index, sub)).filter(|it| it.unanswered)?;
        Some(KnownValue { value: it.value, from: Provenance::Unconfirmed(it.frame) })
    }

    /// Returns true if unanswered writes requested a value of an object.
    pub fn is_requested(&self, index: u16) -> bool {
        self.requested.range((index, 0)..=(index, u8::MAX)).any(|(_, it)| it.unanswered)
    }

    /// Returns every index of `range` with a value that unanswered writes requested, ascending.
    pub fn requested_indices(&self, range: std::ops::RangeInclusive<u16>) -> BTreeSet<u16> {
        let span = (*range.start(), 0)..=(*range.end(), u8::MAX);
        self.requested.range(span).filter(|(_, it)| it.unanswered).map(|((index, _), _)| *index).collect()
    }

    /// Notes that the attempt with the frame `first` was refused. Returns true if a value is known again.
    pub fn refused(&mut self, mux: Mux, first: u64) -> bool {
        let address = (mux.index, mux.sub);
        self.withdraw(mux.index, Some(mux.sub));
        if self.unsure.get(&address).is_none_or(|since| *since < first) {
            return false;
        }
        self.unsure.remove(&address);
        self.unstored.insert(address);
        self.changed(mux.index);
        true
    }

    /// Takes a value of a concise DCF.
    pub fn configure(&mut self, index: u16, sub: u8, bytes: &[u8]) {
        if let Some(value) = number(bytes)
            && concerns(index)
            && self.concise.len() < KEPT
        {
            self.concise.insert((index, sub), value);
            self.changed(index);
        }
    }

    /// Notes that the node is no longer `node`: COB-IDs of the pre-defined connection set follow its new node-ID, so
    /// those that were seen with the old one are dropped.
    pub fn leave(&mut self, node: u8) {
        let follows = |(index, sub): &Address, (value, _): &mut (u64, u64)| {
            let cob = matches!((index, sub), (0x1014, 0) | (0x1200, 1 | 2) | (0x1400..=0x15FF | 0x1800..=0x19FF, 1));
            !(cob && *value & 0x7F == u64::from(node))
        };
        self.observed.retain(follows);
        self.stored.retain(follows);
        self.requested.clear();
    }

    /// Notes that frames were lost behind the frame `last`. Returns true if any observed value is in doubt now.
    pub fn doubt(&mut self, last: u64) -> bool {
        let before = self.doubted_to.replace(last);
        let mut doubted = false;
        for address in std::mem::take(&mut self.undoubted) {
            let since = self.observed.get(&address).map(|(_, frame)| *frame);
            if since.is_some_and(|frame| before.is_none_or(|before| frame > before)) {
                self.changed(address.0);
                doubted = true;
            }
        }
        doubted
    }

    /// Resets the node to its stored values. Returns true if any value has changed.
    pub fn reset(&mut self) -> bool {
        if std::mem::take(&mut self.restored) {
            self.stored.clear();
            self.unsure_stored.clear();
            self.unstored.extend(self.observed.keys().chain(self.unsure.keys()));
        }
        self.written.clear();
        let requested = std::mem::take(&mut self.requested);
        let mut changed = !requested.is_empty();
        requested.keys().for_each(|(index, _)| self.changed(*index));
        for address in std::mem::take(&mut self.unstored) {
            let observed = take_over(&mut self.observed, &self.stored, address);
            if take_over(&mut self.unsure, &self.unsure_stored, address) || observed {
                self.changed(address.0);
                changed = true;
            }
        }
        changed
    }
}

/// Returns true if there is a value of any sub-index of an object.
fn has<V>(values: &BTreeMap<Address, V>, index: u16) -> bool {
    values.range((index, 0)..).next().is_some_and(|((first, _), _)| *first == index)
}

/// Copies one entry of `from` to `of`. Returns true if it has changed.
fn take_over<T: Copy + PartialEq>(
    of: &mut BTreeMap<Address, T>,
    from: &BTreeMap<Address, T>,
    address: Address,
) -> bool {
    match from.get(&address) {
        Some(value) => of.insert(address, *value) != Some(*value),
        None => of.remove(&address).is_some(),
    }
}

/// Returns a value of one to eight bytes as a number.
pub fn number(bytes: &[u8]) -> Option<u64> {
    if !(1..=8).contains(&bytes.len()) {
        return None;
    }
    Some(bytes.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;

    fn write(configuration: &mut Configuration, index: u16, sub: u8, value: u32) -> bool {
        configuration.learn(Direction::Download, Mux { index, sub }, &value.to_le_bytes(), 7)
    }

    fn value(configuration: &Configuration, index: u16, sub: u8) -> Option<u64> {
        configuration.get(5, index, sub).map(|known| known.value)
    }

    #[test]
    fn what_was_written_does_not_survive_a_reset() {
        let mut configuration = Configuration::default();
        assert!(write(&mut configuration, 0x1800, 1, 0x185));
        assert!(!write(&mut configuration, 0x1800, 1, 0x185), "the same again");
        assert_eq!(value(&configuration, 0x1800, 1), Some(0x185));
        assert!(configuration.reset());
        assert_eq!(value(&configuration, 0x1800, 1), None);
    }

    #[test]
    fn what_was_stored_or_read_does() {
        let mut configuration = Configuration::default();
        configuration.learn(Direction::Upload, Mux { index: 0x1017, sub: 0 }, &[0xE8, 3], 3);
        write(&mut configuration, 0x1800, 1, 0x1A5);
        write(&mut configuration, 0x1010, 1, SAVE as u32);
        write(&mut configuration, 0x1006, 0, 10_000);
        configuration.learn(Direction::Upload, Mux { index: 0x1006, sub: 0 }, &[0x10, 0x27, 0, 0], 9);
        configuration.reset();
        assert_eq!(value(&configuration, 0x1017, 0), Some(1000));
        assert_eq!(value(&configuration, 0x1800, 1), Some(0x1A5));
        assert_eq!(value(&configuration, 0x1006, 0), None, "read after it was written: not stored");
        write(&mut configuration, 0x1011, 1, LOAD as u32);
        configuration.reset();
        assert_eq!(value(&configuration, 0x1800, 1), None);
    }

    #[test]
    fn order_of_trust() {
        let object = |value, configured| Object {
            index: 0x1017,
            sub: 0,
            name: "Producer heartbeat time".into(),
            data_type: 6,
            access: Access::Rw,
            preset: Some(Preset { value, relative: false, configured }),
            mappable: false,
            unit: None,
            factor: 1.0,
        };
        let dictionary = |object| Arc::new(Dictionary::new(String::new(), Form::Eds, String::new(), vec![object]));
        let mut configuration = Configuration::default();
        configuration.describe(dictionary(object(100, false)));
        assert_eq!(configuration.get(5, 0x1017, 0), Some(KnownValue { value: 100, from: Provenance::Eds }));
        configuration.describe(dictionary(object(200, true)));
        assert_eq!(configuration.get(5, 0x1017, 0), Some(KnownValue { value: 200, from: Provenance::Dcf }));
        configuration.set_option(0x1017, 0, 300);
        assert_eq!(configuration.get(5, 0x1017, 0), Some(KnownValue { value: 300, from: Provenance::Option }));
        write(&mut configuration, 0x1017, 0, 400);
        assert_eq!(configuration.get(5, 0x1017, 0), Some(KnownValue { value: 400, from: Provenance::Observed(7) }));
    }

    use crate::world::dictionary::{Access, Preset};
}
