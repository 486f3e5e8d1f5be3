//! The buses of a capture, each with its state: frames in, events out.
//!
//! Must not: know a format, or count what is shown.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crate::bytes::frame::{BusId, Buses, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::duplicates::Sighting;
use crate::evidence::recording::RecordedFrame;
use crate::evidence::services::Nature;
use crate::evidence::{Evidence, Recording, When};
use crate::problems::problem::ProblemId;
use crate::problems::{Diagnosis, Phase};
use crate::rules::finding::{Finding, Verdict};
use crate::sdo::transfer::{Hole, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::tables::jsonl;
use crate::views::expectation::{Expectations, Verification};
use crate::views::lines::Clocked;
use crate::world::bus::Bus;
use crate::world::context::{Chunk, Context};
use crate::world::event::{Event, What};
use crate::world::network::Network;
use crate::world::repeats::Repeats;

/// Bytes of a transfer for a file of its own.
#[derive(Clone, Debug)]
pub struct Extracted {
    /// A safe file name: letters, digits, `.`, `_`, `-`.
    pub name: String,
    /// The next bytes.
    pub bytes: Vec<u8>,
    /// The status of the transfer at its end; `None` while it runs.
    pub status: Option<Status>,
    /// The bytes missing within the data or behind them, at the end of the transfer.
    pub holes: Vec<Hole>,
    /// The JSON line of the transfer, where it has ended.
    pub about: Vec<u8>,
}

/// Frames whose stamps are kept where those are of no use to verdicts (invariant 6).
const STAMPS: usize = 4096;

/// Digits of the times of a transfer that is handed out.
const DECIMALS: u8 = 6;

/// The state of all buses.
#[derive(Debug)]
pub(super) struct Decoding {
    network: Arc<Network>,
    /// True if the bytes of SDO transfers are returned.
    pub(super) extract: bool,
    /// Nobody asks what frames mean, so no state is kept.
    blind: bool,
    /// Repeats of findings are counted instead of shown.
    folds: bool,
    /// They are counted where they are found, without events, since nothing takes them before.
    counts_at_once: bool,
    /// Nobody asks how often a state was shown.
    news_only: bool,
    state: Vec<Bus>,
    /// The evidence about the recording of each bus.
    evidence: Vec<Evidence>,
    /// The events of the frame at hand.
    pub(super) events: Vec<Event>,
    chunks: Vec<Chunk>,
    next_transfer: u64,
    repeats: Repeats,
    /// The check of expectations.
    verification: Option<Box<Verification>>,
    /// The diagnosis.
    diagnosis: Option<Box<Diagnosis>>,
    /// The nodes that had a frame, a bit each, by bus.
    seen: Vec<u128>,
    /// The stamps of the last frames that verdicts saw without, by their numbers.
    stamps: VecDeque<(u64, Option<Ns>)>,
    /// True once a frame was judged at another place or time than its own in the capture.
    moves: bool,
    pub(super) extracted: Vec<Extracted>,
}

impl Decoding {
    pub(super) fn new(network: Arc<Network>, extract: bool, blind: bool, folds: bool) -> Self {
        Self {
            network,
            extract,
            blind,
            folds,
            counts_at_once: false,
            news_only: false,
            state: Vec::new(),
            evidence: Vec::new(),
            events: Vec::new(),
            chunks: Vec::new(),
            next_transfer: 0,
            repeats: Repeats::default(),
            verification: None,
            diagnosis: None,
            seen: Vec::new(),
            stamps: VecDeque::new(),
            moves: false,
            extracted: Vec::new(),
        }
    }

    /// The capture is held against what is expected of it.
    pub(super) fn expect(&mut self, expected: &Expectations) {
        self.verification = Some(Box::new(Verification::new(expected, self.network.bit_rate)));
        if expected.diagnoses() {
            self.diagnose();
        }
    }

    /// Turns on the diagnosis.
    pub(super) fn diagnose(&mut self) {
        self.diagnosis = Some(Box::new(Diagnosis::new(self.network.bit_rate)));
    }

    /// Repeats of findings are counted where they are found, if neither expectations, a diagnosis nor others (`alone`: there
    /// are none) take them before.
    pub(super) fn count_at_once(&mut self, alone: bool) {
        self.counts_at_once = alone && self.folds && self.verification.is_none() && self.diagnosis.is_none();
    }

    /// States are published where they change, if neither expectations, a diagnosis nor others (`later`: there are none but
    /// those that may be called later) take them.
    pub(super) fn publish_news(&mut self, later: bool) {
        self.news_only = later && self.verification.is_none() && self.diagnosis.is_none();
    }

    /// A frame with all that follows from it goes to the diagnosis.
    #[inline]
    pub(super) fn diagnosed(&mut self, frame: &Frame) {
        if let Some(diagnosis) = &mut self.diagnosis
            && let Some(bus) = self.state.get(usize::from(frame.bus.0))
        {
            diagnosis.frame(frame, &self.events, bus);
        }
    }

    /// So does what belongs to no frame at hand.
    pub(super) fn diagnosed_aside(&mut self) {
        if let Some(diagnosis) = &mut self.diagnosis {
            diagnosis.asides(&self.events, &self.state);
        }
    }

    /// And a finding about the capture.
    pub(super) fn diagnosed_finding(&mut self, finding: &Finding) {
        if let Some(diagnosis) = &mut self.diagnosis {
            diagnosis.finding(finding, &self.state);
        }
    }

    /// Returns the changes of problems since the last call.
    #[inline]
    pub(super) fn changes(&mut self) -> Vec<(Phase, ProblemId)> {
        self.diagnosis.as_mut().map_or_else(Vec::new, |diagnosis| diagnosis.changes())
    }

    /// Returns the diagnosis so far.
    pub(super) fn diagnosis(&self) -> Option<&Diagnosis> {
        self.diagnosis.as_deref()
    }

    /// The same as it would be if the capture were over now; `None` where it is, or where nothing went wrong. What this
    /// shows keeps its number.
    pub(super) fn diagnosis_by_now(&mut self) -> Option<Diagnosis> {
        let nature = self.nature();
        let diagnosis = self.diagnosis.as_deref_mut().filter(|one| !one.is_empty() && !one.is_over())?;
        Some(diagnosis.by_now(&self.state, nature))
    }

    /// The capture is over at its frame `last`: what went wrong in it, which is held against what is expected of that.
    /// Returns true if there is a diagnosis that was not over before.
    pub(super) fn finish_diagnosis(&mut self, last: FrameRef, buses: &Buses) -> bool {
        let nature = self.nature();
        let Some(diagnosis) = self.diagnosis.as_deref_mut().filter(|diagnosis| !diagnosis.is_over()) else {
            return false;
        };
        diagnosis.finish(&self.state, nature);
        if let Some(verification) = self.verification.as_ref().filter(|_| last.no > 0) {
            verification.diagnosed(diagnosis, last, &mut self.events, buses);
        }
        true
    }

    /// Returns true if the capture is checked against expectations.
    pub(super) fn expects(&self) -> bool {
        self.verification.is_some()
    }

    /// Gives a frame its place in the recording of its bus.
    pub(super) fn observe(&mut self, frame: &Frame, buses: &Buses) -> Option<RecordedFrame> {
        if self.blind {
            return None;
        }
        self.know(frame.bus, buses);
        Some(self.evidence.get_mut(usize::from(frame.bus.0))?.recording.observe(frame))
    }

    /// Returns true if a frame not yet observed ends a silence of its bus that is longer than the recent ones.
    pub(super) fn is_unusual_silence(&self, frame: &Frame) -> bool {
        let evidence = self.evidence.get(usize::from(frame.bus.0));
        evidence.is_some_and(|evidence| evidence.recording.is_unusual_silence(frame.t_ns))
    }

    /// Returns true if the effect of the recordings on every frame so far is known.
    #[inline]
    pub(super) fn is_decided(&self) -> bool {
        self.evidence.iter().all(|evidence| evidence.recording.is_decided())
    }

    /// The number of the first frame of which it is not known yet what the recording did with it.
    pub(super) fn undecided_since(&self) -> Option<u64> {
        self.evidence.iter().filter_map(|evidence| evidence.recording.undecided_since()).min()
    }

    /// No further frame tells what the recordings did. `over`: none will follow.
    pub(super) fn settle(&mut self, over: bool) {
        self.evidence.iter_mut().for_each(|evidence| evidence.recording.settle(over));
    }

    /// It is `now_ns`, and the recordings go on.
    pub(super) fn pass(&mut self, now_ns: Ns) {
        self.evidence.iter_mut().for_each(|evidence| evidence.recording.advance(now_ns));
    }

    /// Returns true if the meaning of an SDO frame may depend on the next one of its channel.
    #[inline]
    pub(super) fn is_ambiguous(&self, frame: &Frame) -> bool {
        !self.blind && self.state.get(usize::from(frame.bus.0)).is_some_and(|bus| bus.is_ambiguous(frame))
    }

    /// Returns true if both frames belong to one SDO channel.
    pub(super) fn is_of_channel(&self, one: &Frame, other: &Frame) -> bool {
        one.bus == other.bus && self.state.get(usize::from(one.bus.0)).is_some_and(|bus| bus.is_of_channel(one, other))
    }

    /// A frame as verdicts see it, where that is another one: without its time, as its stamp says nothing of that. What is
    /// printed has the stamp all the same ([`Self::restore`]).
    #[inline]
    pub(super) fn judged(&mut self, frame: &Frame, seen: Option<&RecordedFrame>) -> Option<Frame> {
        let RecordedFrame { when, .. } = seen?;
        if when.at.t_ns == frame.t_ns {
            return None;
        }
        if self.stamps.len() >= STAMPS {
            self.stamps.pop_front();
        }
        self.stamps.push_back((frame.no, frame.t_ns));
        Some(Frame { t_ns: when.at.t_ns, ..*frame })
    }

    /// Restores the stamps of events that were judged without times, and the numbers of frames that were judged in
    /// another place, for printing.
    #[inline]
    pub(super) fn restore(&mut self) {
        if !self.stamps.is_empty() || self.moves {
            self.restore_all();
        }
    }

    #[cold]
    fn restore_all(&mut self) {
        let (stamps, events) = (&self.stamps, &mut self.events);
        let restore = |at: &mut FrameRef| {
            if let (None, Ok(place)) = (at.t_ns, stamps.binary_search_by_key(&at.no, |(no, _)| *no)) {
                at.t_ns = stamps.get(place).and_then(|(_, t_ns)| *t_ns);
            }
            *at = at.listed();
        };
        let restore_transfer = |transfer: &mut Arc<Transfer>| {
            let transfer = Arc::make_mut(transfer);
            restore(&mut transfer.first);
            restore(&mut transfer.last);
        };
        for event in events {
            restore(&mut event.at);
            event.about.as_deref_mut().into_iter().for_each(restore);
            match &mut event.what {
                What::Finding(finding) => {
                    restore(&mut finding.at);
                    finding.cause.iter_mut().chain(&mut finding.because_of).for_each(restore);
                }
                What::Transfer(transfer) => restore_transfer(transfer),
                What::Sdo(step) => {
                    step.answered_by.as_deref_mut().into_iter().for_each(restore);
                    step.result.iter_mut().for_each(restore_transfer);
                }
                _ => {}
            }
        }
    }

    /// Takes a frame that was observed. `next`: the next one of its SDO channel, where it was read ahead.
    pub(super) fn step(&mut self, frame: &Frame, seen: Option<&RecordedFrame>, next: Option<&Frame>, buses: &Buses) {
        let Some(RecordedFrame { when, happened }) = seen else { return };
        self.moves |= frame.is_relisted();
        self.on_bus(frame.bus, buses, next, |_| *when, |bus, cx| bus.step(frame, happened.as_deref(), cx));
        if let Some(verification) = &mut self.verification {
            verification.frame(frame, &mut self.events, buses);
        }
        if let Some(node) = self.events.first().and_then(|event| event.node) {
            self.see(frame.bus, node);
        }
    }

    /// Returns true if a frame is the first behind a hole of the recording.
    pub(super) fn is_behind_hole(&self, frame: &Frame) -> bool {
        let evidence = self.evidence.get(usize::from(frame.bus.0));
        evidence.is_some_and(|evidence| evidence.recording.is_behind_hole(frame.no))
    }

    /// Returns the number of missing frames and of those that were due, if a frame is the first by which it is shown that
    /// its recording loses frames one by one.
    #[inline]
    pub(super) fn losses_shown_at(&self, frame: &Frame) -> Option<(u64, u64)> {
        self.evidence.get(usize::from(frame.bus.0))?.recording.losses_shown_at(frame.no)
    }

    /// Something was found about the frame at hand and the one before it on its bus that needs no decoding.
    pub(super) fn find(&mut self, frame: &Frame, what: Verdict, before: Option<FrameRef>) {
        if !self.blind {
            let (at, cause, bus, Verdict { code, facts }) = (frame.reference(), before, frame.bus, what);
            let finding = Finding { code, at, cause, bus, node: None, object: None, facts, because_of: None };
            let what = What::Finding(Box::new(finding));
            self.events.push(Event { at, about: cause.map(Box::new), bus, node: None, transfer: None, what });
        }
    }

    /// Frames of a bus are missing here, behind the frame `last`. `goes_on`: the recording is the same on both sides.
    pub(super) fn lost(&mut self, (bus, goes_on): (BusId, bool), last: FrameRef, buses: &Buses) {
        let from = self.events.len();
        self.on_bus(bus, buses, None, |recording| recording.at(last), |bus, cx| bus.lost_frames(goes_on, cx));
        if let Some(verification) = &mut self.verification {
            verification.asides(&mut self.events, from, buses);
            verification.lost(bus, buses);
        }
    }

    /// An error frame of which the capture shows no content, behind the frame `last`.
    pub(super) fn bare_error(&mut self, bus: BusId, last: FrameRef, buses: &Buses) {
        self.on_bus(bus, buses, None, |recording| recording.at(last), Bus::bare_error);
    }

    /// Frames of any bus are missing here.
    pub(super) fn all_lost(&mut self, last: FrameRef, buses: &Buses) {
        for index in 0..self.state.len() {
            self.lost((BusId(index as u8), false), last, buses);
        }
    }

    /// It is `now_ns` on the clock of the frames.
    pub(super) fn advance(&mut self, now_ns: Ns, last: FrameRef, buses: &Buses) {
        for index in 0..self.state.len() {
            let at = |recording: &Recording| recording.at(last);
            self.on_bus(BusId(index as u8), buses, None, at, |bus, cx| bus.advance(now_ns, cx));
        }
        if let Some(verification) = &mut self.verification {
            verification.advance(now_ns, last, &mut self.events, buses);
        }
    }

    /// The capture is over, but for what was only counted.
    pub(super) fn finish(&mut self, last: FrameRef, buses: &Buses) {
        for index in 0..self.state.len() {
            self.on_bus(BusId(index as u8), buses, None, |recording| recording.at(last), Bus::finish);
        }
        if let Some(verification) = self.verification.as_mut().filter(|_| last.no > 0) {
            verification.asides(&mut self.events, 0, buses);
            verification.finish(last, &mut self.events, buses);
        }
    }

    /// Returns the nature of the buses at the end of the capture: CANopen if one of them is.
    pub(super) fn nature(&self) -> Nature {
        self.evidence.iter().map(|evidence| evidence.services.nature()).max().unwrap_or(Nature::Silent)
    }

    /// Appends the findings that were only counted, at the end of the capture.
    pub(super) fn counted(&mut self, last: FrameRef) {
        self.repeats.finish(last, &mut self.events);
    }

    /// The events were written: keeps of them what is handed out, and forgets them.
    #[inline]
    pub(super) fn clear(&mut self, buses: &Buses) {
        if self.extract {
            self.hand_out(buses);
        }
        self.events.clear();
    }

    /// Returns the state of each bus.
    pub(super) fn buses(&self) -> &[Bus] {
        &self.state
    }

    /// The SYNC cycle that runs on a bus, 0 before the first, and the least synchronous window there, in ns.
    pub(super) fn sync(&self, bus: BusId) -> (u64, Option<Ns>) {
        self.state.get(usize::from(bus.0)).map_or((0, None), |bus| (bus.sync_cycle(), bus.sync_window_ns()))
    }

    /// Descriptions of nodes that are not in the capture, by file: a number was mistyped, or the capture is another
    /// one.
    pub(super) fn absent(&self, buses: &Buses) -> BTreeMap<&str, Vec<u8>> {
        let mut absent: BTreeMap<&str, Vec<u8>> = BTreeMap::new();
        for one in self.network.descriptions.iter().filter(|_| !self.blind) {
            let on = |index: usize| Network::holds(one.bus.as_ref(), buses.name(BusId(index as u8)));
            let mut seen = self.seen.iter().enumerate().filter(|(index, _)| on(*index));
            if !seen.any(|(_, nodes)| nodes & 1 << (one.node & 0x7F) != 0) {
                absent.entry(&one.dictionary.file).or_default().push(one.node);
            }
        }
        absent
    }

    /// Hands a bus what concerns it, at a place in its recording. `next`: see [`Self::step`].
    #[inline]
    fn on_bus(
        &mut self,
        id: BusId,
        buses: &Buses,
        next: Option<&Frame>,
        when: impl FnOnce(&Recording) -> When,
        act: impl FnOnce(&mut Bus, &mut Context<'_>),
    ) {
        if self.blind {
            return;
        }
        self.know(id, buses);
        let index = usize::from(id.0);
        let (Some(bus), Some(evidence)) = (self.state.get_mut(index), self.evidence.get_mut(index)) else { return };
        let when = when(&evidence.recording);
        let mut cx = Context {
            events: &mut self.events,
            next_transfer: &mut self.next_transfer,
            extract: self.extract,
            chunks: &mut self.chunks,
            bus: id,
            at: when.at,
            evidence,
            when,
            sighting: Sighting::Original,
            next,
            // The numbers of frames that were judged in another place are restored before repeats are counted.
            repeats: (self.counts_at_once && !self.moves).then_some(&mut self.repeats),
            news_only: self.news_only,
        };
        act(bus, &mut cx);
    }

    /// Keeps the state of a bus.
    #[inline]
    fn know(&mut self, id: BusId, buses: &Buses) {
        if self.state.len() <= usize::from(id.0) {
            self.meet(id, buses);
        }
    }

    #[cold]
    fn meet(&mut self, id: BusId, buses: &Buses) {
        while self.state.len() <= usize::from(id.0) {
            let name = buses.name(BusId(self.state.len() as u8));
            self.state.push(Bus::new(Arc::clone(&self.network), name));
            let described = self.network.describes(name);
            self.evidence.push(Evidence::new(self.network.jitter_ns, described));
        }
    }

    /// Returns true if nobody asks what frames mean.
    #[inline]
    pub(super) fn is_blind(&self) -> bool {
        self.blind
    }

    /// Takes out what is only counted.
    #[inline]
    pub(super) fn fold(&mut self) {
        if self.folds {
            self.repeats.fold(&mut self.events);
        }
    }

    fn see(&mut self, bus: BusId, node: u8) {
        let index = usize::from(bus.0);
        if self.seen.len() <= index {
            self.seen.resize(index + 1, 0);
        }
        if let Some(nodes) = self.seen.get_mut(index) {
            *nodes |= 1 << (node & 0x7F);
        }
    }

    fn hand_out(&mut self, buses: &Buses) {
        for Chunk { id, bus, node, mux, bytes } in self.chunks.drain(..) {
            self.extracted.push(Extracted {
                name: file_name(id.0, buses.name(bus), node, mux),
                bytes,
                status: None,
                holes: Vec::new(),
                about: Vec::new(),
            });
        }
        let setting =
            jsonl::Setting { lang: jsonl::NAMES, file: b"", buses, decimals: DECIMALS, clock: Clocked::default() };
        for event in &self.events {
            if let What::Transfer(transfer) = &event.what {
                let name = file_name(transfer.id.0, buses.name(transfer.bus), transfer.node, transfer.mux);
                let (status, holes) = (Some(transfer.outcome.status), transfer.data.holes.list().to_vec());
                let mut about = Vec::new();
                jsonl::transfer(&mut about, setting, transfer, jsonl::NAMES);
                self.extracted.push(Extracted { name, bytes: Vec::new(), status, holes, about });
            }
        }
    }
}

/// `00001_can1_node10_1008h_00.bin`: what a bus is called comes from the capture, so anything odd becomes `_`.
fn file_name(id: u64, bus: &[u8], node: u8, mux: Option<Mux>) -> String {
    let safe = |byte: &u8| if byte.is_ascii_alphanumeric() || *byte == b'-' { char::from(*byte) } else { '_' };
    let bus: String = bus.iter().map(safe).collect();
    let bus = if bus.is_empty() { "can".to_owned() } else { bus };
    match mux {
        Some(mux) => format!("{id:05}_{bus}_node{node}_{:04X}h_{:02X}.bin", mux.index, mux.sub),
        None => format!("{id:05}_{bus}_node{node}.bin"),
    }
}
