//! The communication objects of all buses: a line for each identifier, with its last frame.
//!
//! Data frames and remote frames of an identifier are two lines, all error frames of a bus are one. Nothing is judged,
//! and no words are written here.

use std::collections::{BTreeMap, BTreeSet};

use super::recent::Recent;
use crate::bytes::frame::{BusId, CanId, Frame, FrameRef, Kind};
use crate::bytes::ns::Ns;
use crate::evidence::period::Gaps;
use crate::evidence::period::recent::RecentGaps;
use crate::rules::finding::Severity;
use crate::sdo::wire::Side;
use crate::wire::message::Message;
use crate::world::event::{Event, What};

/// Maximum number of lines; further identifiers are only counted.
pub(super) const OBJECTS: usize = 4096;
/// Maximum number of lines of 29-bit identifiers without a meaning.
const FOREIGN: usize = 1024;
/// Maximum number of further identifiers that are counted apart.
const FURTHER: usize = 65_536;
/// Length of the time window of a rate, in ns.
const RATE_NS: Ns = Ns::from_s(2);
/// Time for which a byte counts as changed, in ns.
const CHANGED_NS: Ns = Ns::from_s(1);
/// Time for which a finding marks the line, in ns.
const MARKED_NS: Ns = Ns::from_s(10);
/// 11-bit identifiers.
const IDS: usize = 2048;

/// The key of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct LineKey {
    /// The bus.
    pub(super) bus: BusId,
    /// The identifier; the greatest one for error frames.
    pub(super) id: CanId,
    /// Data, remote or error.
    pub(super) form: LineForm,
}

/// The type of the frames of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum LineForm {
    Data,
    Remote,
    Error,
}

impl LineKey {
    fn of(frame: &Frame) -> Self {
        let form = match frame.kind {
            Kind::Data | Kind::Fd { .. } => LineForm::Data,
            Kind::Remote => LineForm::Remote,
            Kind::Error => return Self { bus: frame.bus, id: CanId::extended(u32::MAX), form: LineForm::Error },
        };
        Self { bus: frame.bus, id: frame.id, form }
    }
}

/// The label of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Label {
    /// A PDO: transmit, number.
    Pdo(bool, u16),
    /// An SRDO: number, inverted.
    Srdo(u8, bool),
    /// An SDO channel, by its sender.
    Sdo(Side),
    /// By its service.
    Service(&'static str),
}

impl Label {
    fn of(what: &What) -> Self {
        match what {
            What::Pdo(data) => Self::Pdo(data.transmit, data.number),
            What::Mpdo(data) => Self::Pdo(data.transmit, data.number),
            What::Sdo(step) => Self::Sdo(step.side),
            What::Message(message) => match *message {
                Message::Pdo { transmit, number, .. }
                | Message::PdoRequest { transmit, number, .. }
                | Message::Mpdo { transmit, number, .. } => Self::Pdo(transmit, number),
                Message::Srdo { number, inverted, .. } => Self::Srdo(number, inverted),
                _ => Self::Service(message.service()),
            },
            What::Transfer(_) | What::Note(_) | What::Change(_) | What::Finding(_) => Self::Service("foreign"),
        }
    }
}

/// One line.
#[derive(Clone, Debug)]
pub(super) struct ObjectLine {
    pub(super) label: Label,
    pub(super) service: &'static str,
    pub(super) node: Option<u8>,
    pub(super) count: u64,
    pub(super) last: FrameRef,
    pub(super) rate: Recent,
    /// The identifier of the last frame; for error frames the class.
    pub(super) id: CanId,
    pub(super) len: u8,
    data: [u8; 64],
    /// The annotation of the last frame, without line end.
    pub(super) text: Vec<u8>,
    gaps: Gaps,
    recent: RecentGaps,
    /// The time of the last change of each byte; `i64::MAX` without timestamps.
    changed: Vec<Option<Ns>>,
    /// The last finding of each severity.
    marks: [Option<FrameRef>; 3],
}

impl ObjectLine {
    fn new() -> Self {
        Self {
            label: Label::Service("foreign"),
            service: "foreign",
            node: None,
            count: 0,
            last: FrameRef::default(),
            rate: Recent::new(RATE_NS),
            id: CanId::standard(0),
            len: 0,
            data: [0; 64],
            text: Vec::new(),
            gaps: Gaps::default(),
            recent: RecentGaps::default(),
            changed: Vec::new(),
            marks: [None; 3],
        }
    }

    fn take(&mut self, frame: &Frame) {
        let payload = frame.payload();
        let before = self.data.get(..usize::from(self.len)).unwrap_or(&[]);
        if self.count == 0 {
            self.changed = vec![None; payload.len()];
        } else if frame.t_ns.is_none() {
            self.changed.fill(None);
        }
        if self.changed.len() < payload.len() {
            self.changed.resize(payload.len(), None);
        }
        if self.count > 0 && payload != before {
            for (place, (slot, byte)) in self.changed.iter_mut().zip(payload).enumerate() {
                if before.get(place) != Some(byte) {
                    *slot = Some(frame.t_ns.unwrap_or(Ns::MAX));
                }
            }
        }
        if let Some(now) = frame.t_ns {
            self.rate.add(now, 1);
        }
        if let Some(gap) = self.gaps.take(frame.t_ns) {
            self.recent.add(gap);
        }
        self.count += 1;
        self.last = frame.reference();
        self.id = frame.id;
        self.len = payload.len() as u8;
        self.data = frame.data;
    }

    /// The data of the last frame.
    pub(super) fn data(&self) -> &[u8] {
        self.data.get(..usize::from(self.len)).unwrap_or(&self.data)
    }

    /// Returns true for each byte that has changed recently.
    pub(super) fn changed(&self, now_ns: Option<Ns>) -> impl Iterator<Item = bool> {
        self.changed.iter().take(usize::from(self.len)).map(move |at| match (*at, now_ns) {
            (None, _) => false,
            (Some(Ns::MAX), _) => true,
            (Some(at), Some(now)) => (Ns::ZERO..CHANGED_NS).contains(&(now - at)),
            (Some(_), None) => false,
        })
    }

    /// Returns the mean of the last intervals in ns, and the greatest deviation from it if there are several.
    pub(super) fn period(&self) -> Option<(Ns, Option<Ns>)> {
        self.recent.period()
    }

    /// Returns the worst recent finding about it.
    pub(super) fn severity(&self, now_ns: Option<Ns>) -> Option<Severity> {
        let lately = |mark: &Option<FrameRef>| {
            mark.is_some_and(|at| match (at.t_ns, now_ns) {
                (Some(at), Some(now)) => (Ns::ZERO..MARKED_NS).contains(&(now - at)),
                _ => at.no == self.last.no,
            })
        };
        let worst = [Severity::Info, Severity::Warning, Severity::Error].into_iter().zip(&self.marks);
        worst.filter(|(_, mark)| lately(mark)).map(|(severity, _)| severity).max()
    }

    /// Records a finding about its frame `at`.
    pub(super) fn mark(&mut self, severity: Severity, at: FrameRef) {
        if let Some(mark) = self.marks.get_mut(severity as usize) {
            *mark = Some(at);
        }
    }
}

/// All lines.
#[derive(Debug, Default)]
pub(super) struct ObjectLines {
    all: Vec<ObjectLine>,
    places: BTreeMap<LineKey, usize>,
    /// The index of the data frames of each 11-bit identifier, by bus: the fast path of nearly every frame.
    by_id: Vec<Vec<u16>>,
    /// The number of lines of 29-bit identifiers without a meaning.
    foreign: usize,
    further: BTreeSet<LineKey>,
}

impl ObjectLines {
    /// Takes a frame with its own event. Returns its line, if there is one.
    pub(super) fn take(
        &mut self,
        frame: &Frame,
        own: Option<&Event>,
        service: &'static str,
    ) -> Option<&mut ObjectLine> {
        let place = self.place(LineKey::of(frame), service)?;
        let object = self.all.get_mut(place)?;
        object.take(frame);
        object.service = service;
        object.node = own.and_then(|event| event.node);
        object.label = own.map_or(Label::Service(service), |event| Label::of(&event.what));
        Some(object)
    }

    fn place(&mut self, key: LineKey, service: &'static str) -> Option<usize> {
        let quick = !key.id.is_extended() && key.form == LineForm::Data;
        let bus = usize::from(key.bus.0);
        if quick {
            while self.by_id.len() <= bus {
                self.by_id.push(vec![u16::MAX; IDS]);
            }
            let known = self.by_id.get(bus).and_then(|ids| ids.get(key.id.raw() as usize));
            if let Some(place) = known.filter(|place| **place != u16::MAX) {
                return Some(usize::from(*place));
            }
        } else if let Some(place) = self.places.get(&key) {
            return Some(*place);
        }
        let foreign = service == "foreign" && key.id.is_extended();
        if self.all.len() >= OBJECTS || foreign && self.foreign >= FOREIGN {
            if self.further.len() < FURTHER {
                self.further.insert(key);
            }
            return None;
        }
        let place = self.all.len();
        self.foreign += usize::from(foreign);
        self.all.push(ObjectLine::new());
        self.places.insert(key, place);
        // It may have come without a meaning before, and been counted.
        self.further.remove(&key);
        if quick && let Some(slot) = self.by_id.get_mut(bus).and_then(|ids| ids.get_mut(key.id.raw() as usize)) {
            *slot = place as u16;
        }
        Some(place)
    }

    /// Stops the measurement of times, since frames of a bus were lost.
    pub(super) fn lost(&mut self, bus: BusId) {
        for (_, place) in self.places.iter().filter(|(key, _)| key.bus == bus) {
            if let Some(object) = self.all.get_mut(*place) {
                object.gaps.interrupt();
            }
        }
    }

    /// Returns all lines by bus, 11-bit identifiers before 29-bit ones.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&LineKey, &ObjectLine)> {
        self.places.iter().filter_map(|(key, place)| Some((key, self.all.get(*place)?)))
    }

    /// Returns the number of identifiers without a line, at most [`FURTHER`].
    pub(super) fn more(&self) -> usize {
        self.further.len()
    }
}
