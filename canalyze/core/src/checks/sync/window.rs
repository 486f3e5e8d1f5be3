//! Synchronous PDOs in their SYNC cycles (CiA 301, 7.2.2.2 and 7.2.5): place, number per cycle, and synchronous window.
//!
//! A TPDO of type n is judged against its own frames once it has come n cycles apart. The SYNCs and the time between
//! two frames must both contradict the type, because one alone may be an artefact of the recording (a SYNC listed late
//! or lost). Without stamps, a frame near a SYNC may belong to either cycle. RPDOs are placed and not judged: they take
//! effect with the next SYNC.

use super::period::SyncPeriod;
use crate::bytes::frame::{CanId, FrameRef};
use crate::bytes::ns::Ns;
use crate::checks::pdo::series::Series;
use crate::evidence::circumstance::Rules;
use crate::evidence::recording::Recording;
use crate::evidence::when::When;
use crate::rules::finding::{Code, Finding};
use crate::rules::pdo::Pdo023;
use crate::rules::sync::{Syn004, Syn008, Syn009, Syn010, Syn011};
use crate::sdo::wire::Mux;
use crate::wire::pdo::communication_parameter;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::event::Placement;
use crate::world::node::{Node, Pdo, PerNode};

/// Maximum number of synchronous TPDOs followed (invariant 6).
const TRACKS: usize = 512;
/// Number of consecutive correct distances after which a PDO is judged; more for a transmission type from an EDS, which
/// the device need not have kept.
const ESTABLISHED: u8 = 1;
const ESTABLISHED_BY_EDS: u8 = 8;
/// Number of distances in a row that are the same and not those of the transmission type.
const OTHER_TYPE: u32 = 3;
/// Number of frames in a row outside the window that no chance of the listing explains: if that is known to be in time, or,
/// where they are as late each time but for this part of the window, if a few exchanges are.
const OUTSIDE: u32 = 20;
const AS_LATE_PART: i64 = 8;
/// Number of measured gaps before a large tolerance is reported.
const MEASURED: u64 = 9;
/// Number of cycles for which a finding waits for the SYNC, or the transmission type, that explains it.
const EXPLAINED: i64 = 8;
/// Number of times in a row that a PDO has come after the same wrong number of SYNCs before that is its interval.
const OTHER: u32 = 8;

/// Returns true if a transmission type is synchronous: 0, 1..=240, 252 (CiA 301, table 71).
pub fn synchronous(kind: u8) -> bool {
    kind <= 240 || kind == 252
}

/// The synchronous TPDOs of a bus.
#[derive(Debug, Default)]
pub struct SyncWindow {
    nodes: PerNode<Vec<TpdoTrack>>,
    count: usize,
    /// It was reported that times cannot be judged.
    reported: bool,
    /// Number of cycles in a row, including the current one, without any synchronous TPDO.
    empty: u8,
}

/// A received PDO.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    when: When,
    /// The current cycle when it was listed.
    cycle: u64,
}

/// One synchronous TPDO.
#[derive(Debug)]
struct TpdoTrack {
    number: u16,
    configured: Configured,
    last: Option<Arrival>,
    /// A cycle in which it was due and came.
    phase: u64,
    /// Number of correct times in a row.
    steady: u8,
    open: Open,
    /// Its configuration was changed since the last frame, so its absence may be intended.
    touched: bool,
    /// It was requested by a remote frame.
    asked: bool,
    /// Number of frames before any SYNC.
    before: u8,
    /// It comes too often, or in wrong cycles.
    wrong: Series,
    /// The number of SYNCs between its last frames, if that is not its type, how often in a row it was that, and the frame
    /// before them.
    other: (u64, u32, FrameRef),
    /// A finding about a frame so late that its own SYNC may be the next one, which is listed later still. The next
    /// frame of the PDO decides.
    late: Option<Box<Finding>>,
    /// Number of frames in a row that are outside the window of the SYNC listed before them, and their shortest and longest
    /// delay, in ns.
    outside: u32,
    delays_ns: (Ns, Ns),
}

/// The configuration of a PDO.
#[derive(Clone, Copy, Debug)]
struct Configured {
    kind: u8,
    id: CanId,
    /// Number of correct times before it is judged.
    needed: u8,
    /// The capture shows its type, so its beginning is not cut.
    shown: bool,
}

/// Questions that the next frame of a PDO decides.
#[derive(Clone, Copy, Debug, Default)]
struct Open {
    /// The cycle in which it is missing while it may come late.
    absent: Option<u64>,
    /// It came again in its cycle, and no time shows if the next SYNC came before.
    doubled: bool,
    /// Its absence was reported.
    reported: bool,
}

/// The context of a verdict.
struct Judged<'a> {
    period: &'a SyncPeriod,
    window_ns: Option<Ns>,
    node: u8,
}

impl SyncWindow {
    /// Returns the place of a PDO as far as known on its arrival.
    pub fn place(&self, period: &SyncPeriod, node: u8, pdo: &Pdo, at: FrameRef, lag_ns: Ns) -> Option<Placement> {
        let cycle = period.cycle();
        if cycle == 0 {
            return None;
        }
        let delay_ns = period.delay_ns(at);
        if let (Some(delay), Some(period), true) = (delay_ns, period.period_ns(), pdo.transmit)
            && (period - lag_ns.min(period * 2 / 5)..=period).contains(&delay)
            && self.track(node, pdo.number).is_some_and(|track| track.came(cycle))
        {
            return Some(Placement { cycle: cycle + 1, delay_ns: Some(delay - period) });
        }
        Some(Placement { cycle, delay_ns })
    }

    /// Takes a synchronous TPDO. `window_ns`: its window if any.
    pub fn arrived(&mut self, period: &SyncPeriod, node: u8, pdo: &Pdo, window_ns: Option<Ns>, cx: &mut Context<'_>) {
        let Some((kind, from)) = pdo.transmission.filter(|(_, from)| !from.is_doubted()) else { return };
        self.report_unjudged(period, window_ns, cx);
        self.empty = 0;
        let tracks = self.nodes.entry(node);
        let place = match tracks.iter().position(|track| track.number == pdo.number) {
            Some(place) => place,
            None if self.count >= TRACKS => return,
            None => {
                self.count += 1;
                tracks.push(TpdoTrack::new(pdo.number));
                tracks.len() - 1
            }
        };
        let Some(track) = tracks.get_mut(place) else { return };
        if (track.configured.kind, track.configured.id) != (kind, pdo.cob.0.id) {
            track.restart();
            (track.configured.kind, track.configured.id) = (kind, pdo.cob.0.id);
        }
        track.configured.needed = if from > Provenance::Eds { ESTABLISHED } else { ESTABLISHED_BY_EDS };
        track.configured.shown = matches!(from, Provenance::Observed(_));
        track.take(&Judged { period, window_ns, node }, cx);
        self.alive(node, period, cx);
    }

    /// Reports a node's missing TPDOs when it shows that it is Operational.
    pub fn alive(&mut self, node: u8, period: &SyncPeriod, cx: &mut Context<'_>) {
        let Some(tracks) = self.nodes.get_mut(node) else { return };
        for track in tracks {
            let n = u64::from(track.configured.kind);
            let n = if track.is_of_other_type() { track.other.0 } else { n };
            let Some(last) =
                track.last.filter(|_| track.cyclic() && track.established() && !(track.open.reported || track.touched))
            else {
                continue;
            };
            // It should have come twice since; a single missing frame is reported on the next arrival.
            let judged = period.cycle() > last.cycle.max(track.phase) + 2 * n && last.cycle >= period.calm_from();
            let is_late = |period: Ns| {
                let limit = period * (2 * n as i64);
                cx.evidence.recording.certainly_later(cx.when, last.when, limit)
            };
            if judged && period.period_ns().is_none_or(is_late) {
                track.open.reported = true;
                let due = track.phase + n;
                let what = Syn008::Since { cycle: due, since: period.cycle() - due };
                let finding = cx.verdict(what, Some(node), Some(track.object()), period.frame(due));
                cx.report_timed(cx.excused(Rules::SynchronousPdo, cx.when, finding));
            }
        }
    }

    /// Reports at the end of the capture the TPDOs that come after another number of SYNCs than their type says.
    pub fn finish(&self, nodes: &PerNode<Node>, configured: impl Fn(u8, &Pdo) -> bool, cx: &mut Context<'_>) {
        for (node, track) in self.nodes.iter().flat_map(|(node, tracks)| tracks.iter().map(move |track| (node, track)))
        {
            let (found, times, since) = track.other;
            let pdo = nodes.get(node).and_then(|known| known.pdo(true, track.number));
            if let Some(last) = track.last
                && times >= OTHER
                && track.cyclic()
                && pdo.is_some_and(|pdo| configured(node, pdo))
            {
                let what = Pdo023::WithSync { found, expected: track.configured.kind.into() };
                let finding = cx.verdict(what, Some(node), Some(track.object()), Some(since));
                cx.report(cx.excused(Rules::SynchronousPdo, last.when, finding));
            } else if let Some(last) = track.last.filter(|_| track.is_of_other_type() && track.established()) {
                let what = Syn010::TransmissionType { found, expected: u64::from(track.configured.kind.max(1)) };
                let finding = cx.verdict(what, Some(node), Some(track.object()), Some(since));
                cx.report(cx.excused(Rules::SynchronousPdo, last.when, Finding { at: last.when.at, ..finding }));
            }
        }
    }

    /// Takes a SYNC; returns true if nothing came since the one before although several TPDOs were due, or for longer.
    /// Without stamps only that shows that the recorder paused.
    pub fn stood_still(&mut self) -> bool {
        let due = |track: &&TpdoTrack| track.configured.kind == 1 && track.established();
        let tracks = || self.nodes.iter().flat_map(|(_, tracks)| tracks);
        let still = self.empty > 1 || (self.empty == 1 && tracks().filter(due).count() >= 2);
        self.empty = self.empty.saturating_add(1);
        still
    }

    /// Takes the first SYNC; reports a TPDO before it whose type the capture shows.
    pub fn first_sync(&mut self, cx: &mut Context<'_>) {
        for (node, tracks) in self.nodes.iter_mut() {
            for track in tracks.iter_mut().filter(|track| track.before == 1 && track.configured.shown) {
                let Some(last) = track.last else { continue };
                if last.when.at.t_ns.is_some() {
                    track.before = 2;
                    cx.raise(Code::Syn005, Some(node), Some(track.object()), Some(last.when.at));
                }
            }
        }
    }

    /// Forgets the schedule of a node (or of all) after a reset.
    pub fn restart(&mut self, node: Option<u8>) {
        self.each(node, TpdoTrack::restart);
    }

    /// Interrupts the schedule of a node (or of all) after a command or lost frames.
    pub fn pause(&mut self, node: Option<u8>) {
        self.each(node, TpdoTrack::pause);
    }

    fn each(&mut self, node: Option<u8>, act: impl Fn(&mut TpdoTrack)) {
        for (_, tracks) in self.nodes.iter_mut().filter(|(id, _)| node.is_none_or(|node| node == *id)) {
            tracks.iter_mut().for_each(&act);
        }
    }

    /// Takes a change of a TPDO's configuration; a new type or identifier restarts it.
    pub fn reconfigured(&mut self, node: u8, number: u16, pdo: Option<&Pdo>) {
        let Some(track) = self.track_mut(node, number) else { return };
        let same = pdo.is_some_and(|pdo| {
            let kind = pdo.transmission.map(|(kind, _)| kind);
            pdo.cob.0.valid
                && pdo.cob.0.id == track.configured.id
                && kind.is_none_or(|kind| kind == track.configured.kind)
        });
        track.touched = true;
        if !same {
            track.restart();
        }
    }

    /// Takes a remote frame for a TPDO.
    pub fn asked(&mut self, node: u8, number: u16) {
        if let Some(track) = self.track_mut(node, number) {
            track.asked = true;
        }
    }

    fn track_mut(&mut self, node: u8, number: u16) -> Option<&mut TpdoTrack> {
        self.nodes.get_mut(node)?.iter_mut().find(|track| track.number == number)
    }

    fn track(&self, node: u8, number: u16) -> Option<&TpdoTrack> {
        self.nodes.get(node)?.iter().find(|track| track.number == number)
    }

    /// Reports once that times cannot be judged: no stamps, or a tolerance larger than `limit_ns`.
    pub fn report_unjudged(&mut self, period: &SyncPeriod, limit_ns: Option<Ns>, cx: &mut Context<'_>) {
        let Some(window) = limit_ns.filter(|_| !self.reported && period.cycle() > 0) else { return };
        let what = match period.tolerance_ns(&cx.evidence.recording) {
            _ if cx.at.t_ns.is_none() => Syn011::NoStamps,
            Some(tolerance) if tolerance >= window && period.cycle() > MEASURED => {
                Syn011::Tolerance { tolerance, window }
            }
            _ => return,
        };
        self.reported = true;
        cx.raise(what, None, None, None);
    }
}

/// The minimum and maximum number of cycles between two frames of a PDO, by listed SYNCs and by the time in periods.
#[derive(Clone, Copy, Debug)]
struct Passed {
    syncs: u64,
    least: u64,
    most: u64,
}

impl Passed {
    fn between(last: Arrival, now: Arrival, period: &SyncPeriod, recording: &Recording) -> Self {
        let count = |gap: Ns, period: Ns| u64::try_from((gap + period / 2) / period.max(Ns(1))).unwrap_or(0);
        let syncs = now.cycle.saturating_sub(last.cycle);
        let (least, most) = match (recording.between(last.when, now.when), period.scale_ns(recording)) {
            (Some(gap), Some((least, most))) => (count(gap, most), count(gap, least)),
            (Some(_), None) => (0, u64::MAX),
            (None, _) => (syncs, syncs),
        };
        Self { syncs, least: least.min(syncs), most: most.max(syncs) }
    }

    fn is(self, n: u64) -> bool {
        (self.least..=self.most).contains(&n)
    }
}

impl TpdoTrack {
    fn new(number: u16) -> Self {
        Self {
            number,
            configured: Configured { kind: u8::MAX, id: CanId::standard(0), needed: ESTABLISHED, shown: false },
            last: None,
            phase: 0,
            steady: 0,
            open: Open::default(),
            touched: false,
            asked: false,
            before: 0,
            wrong: Series::default(),
            other: (0, 0, FrameRef::default()),
            late: None,
            outside: 0,
            delays_ns: (Ns::ZERO, Ns::ZERO),
        }
    }

    /// Restarts learning; keeps the configuration.
    fn restart(&mut self) {
        self.pause();
        (self.steady, self.other.1) = (0, 0);
    }

    /// Interrupts it; keeps the configuration.
    fn pause(&mut self) {
        (self.last, self.open, self.asked, self.late) = (None, Open::default(), false, None);
    }

    fn object(&self) -> Mux {
        Mux { index: communication_parameter(true, self.number), sub: 2 }
    }

    fn cyclic(&self) -> bool {
        (1..=240).contains(&self.configured.kind)
    }

    fn established(&self) -> bool {
        self.steady >= self.configured.needed
    }

    /// Returns true if its frame of this cycle has not come yet.
    fn is_due(&self, cycle: u64) -> bool {
        let turns = cycle.abs_diff(self.phase).checked_rem(u64::from(self.configured.kind));
        self.cyclic() && !self.came(cycle) && turns == Some(0)
    }

    fn came(&self, cycle: u64) -> bool {
        self.last.is_some_and(|last| last.cycle >= cycle)
    }

    fn take(&mut self, known: &Judged<'_>, cx: &mut Context<'_>) {
        let now = Arrival { when: cx.when, cycle: known.period.cycle() };
        let asked = std::mem::take(&mut self.asked);
        let late = self.late.take();
        self.touched = false;
        if now.cycle == 0 {
            self.last = Some(now);
            self.before = self.before.saturating_add(1);
            if self.before == 2 {
                cx.raise(Code::Syn005, Some(known.node), Some(self.object()), None);
            }
            return;
        }
        // The frame that is due in this cycle comes beside the answer.
        let due = self.is_due(now.cycle);
        self.asked = asked && due;
        if self.configured.kind == 252 || asked && !due {
            return;
        }
        let last = self.last.replace(now).filter(|last| last.cycle > 0);
        let Some(last) = last.filter(|last| comparable(*last, now, known.period, &cx.evidence.recording)) else {
            (self.phase, self.open.absent, self.open.doubled, self.open.reported) = (now.cycle, None, false, false);
            return self.judge_delay(now, None, known, cx);
        };
        let passed = Passed::between(last, now, known.period, &cx.evidence.recording);
        if let Some(late) = late {
            self.judge_late(*late, last, now, known, cx);
        }
        self.judge_delay(now, Some(last), known, cx);
        self.judge_cycle(last, now, passed, known, cx);
    }

    /// Judges the delay against the window, unless its own SYNC is not listed before it.
    fn judge_delay(&mut self, now: Arrival, last: Option<Arrival>, known: &Judged<'_>, cx: &mut Context<'_>) {
        let recording = &cx.evidence.recording;
        let Some(sync) = known.period.sync(now.cycle) else { return };
        let Some(delay) = recording.between(sync, now.when) else { return };
        let period = known.period.period_ns().filter(|period| delay < *period);
        let (Some(window), Some(tolerance), Some(period)) =
            (known.window_ns, known.period.tolerance_ns(recording), period)
        else {
            return;
        };
        let mut delayed = false;
        // It belongs to this SYNC if the next cannot have been sent yet, or its own frames show it to be late.
        let late = last.is_some_and(|last| {
            let cycles = i64::try_from(now.cycle.saturating_sub(last.cycle)).unwrap_or(0);
            // With uneven listing the period is as uncertain, and the window may begin anywhere within that.
            let room = if tolerance > window / 8 { window } else { window / 4 };
            let limit = cycles * (period + tolerance) + room;
            let next = recording.between(last.when, now.when).map(|gap| (cycles + 1) * period - gap);
            let before_next = next.is_some_and(|before| before > period / 4);
            delayed = cycles > 0 && recording.certainly_later(now.when, last.when, limit);
            before_next && delayed
        });
        let outside = recording.certainly_later(now.when, sync, window + tolerance);
        self.outside = if outside { self.outside.saturating_add(1) } else { 0 };
        let (least, most) = self.delays_ns;
        self.delays_ns = if self.outside > 1 { (least.min(delay), most.max(delay)) } else { (delay, delay) };
        let as_late = self.delays_ns.1 - self.delays_ns.0 <= window / AS_LATE_PART;
        // SYNCs that are listed late by chance are not so one after the other.
        let in_step = as_late && recording.is_closer_than(delay - window);
        let always = self.outside >= OUTSIDE && (in_step || recording.lists_promptly());
        let lag_ns = if sync.own && !late && !always { recording.lag_ns() } else { Ns::ZERO };
        let judged =
            (self.configured.needed == ESTABLISHED || self.established()) && now.cycle >= known.period.calm_from();
        if !judged
            || tolerance >= window
            || delay >= period - lag_ns && !delayed
            || !recording.teaches(sync)
            || !outside
        {
            return;
        }
        let since = last.map_or(sync, |last| last.when);
        let what = Syn004::Late { delay, window, tolerance, cycle: now.cycle };
        let finding = cx.verdict(what, Some(known.node), Some(self.object()), None);
        if delay >= period - lag_ns {
            self.late = Some(Box::new(finding));
        } else {
            self.report(finding, since, known, cx);
        }
    }

    /// Reports a frame outside the window once the next one is in its cycle and back in time: so it was this PDO that
    /// was late, and not the listing of SYNC.
    #[cold]
    fn judge_late(&mut self, late: Finding, last: Arrival, now: Arrival, known: &Judged<'_>, cx: &mut Context<'_>) {
        let n = u64::from(self.configured.kind.max(1));
        let (Some(window), Some(period)) = (known.window_ns, known.period.period_ns()) else { return };
        let cycles = i64::try_from(now.cycle.saturating_sub(last.cycle)).unwrap_or(0);
        let limit = cycles * period - window / 4;
        let as_due = now.cycle == last.cycle + n && cx.evidence.recording.certainly_within(now.when, last.when, limit);
        if as_due {
            self.report(late, last.when, known, cx);
        }
    }

    /// Judges the cycle in which it came.
    fn judge_cycle(&mut self, last: Arrival, now: Arrival, passed: Passed, known: &Judged<'_>, cx: &mut Context<'_>) {
        let n = u64::from(self.configured.kind.max(1));
        let absent = self.open.absent.take();
        let doubled = std::mem::take(&mut self.open.doubled);
        let reported = std::mem::take(&mut self.open.reported);
        if passed.most < 1 {
            return self.second(last, now, (absent, doubled), known, cx);
        }
        if self.configured.kind == 0 {
            return self.wrong.keep();
        }
        let judged = self.established() && !reported;
        if passed.is(n) && self.is_of_other_type() && self.established() {
            let what = Syn010::TransmissionType { found: self.other.0, expected: n };
            let finding = Finding { at: last.when.at, ..cx.verdict(what, Some(known.node), Some(self.object()), None) };
            self.report(finding, last.when, known, cx);
        }
        if passed.is(n) || (passed.syncs + self.phase_of(last)).is_multiple_of(n) && last.cycle != self.phase {
            self.steady = self.steady.saturating_add(u8::from(passed.is(n)));
            (self.phase, self.other.1) = (now.cycle, 0);
            return self.wrong.keep();
        }
        if !judged {
            (self.steady, self.phase) = (0, now.cycle);
            return self.compare(last, passed);
        }
        self.out_of_cycle(last, now, passed, known, cx);
    }

    /// Counts how often in a row it has come after the same number of SYNCs, which is not its type.
    fn compare(&mut self, last: Arrival, passed: Passed) {
        let (syncs, times, since) = self.other;
        let exact = passed.least == passed.most;
        self.other = match times {
            1.. if syncs == passed.syncs && exact => (syncs, times.saturating_add(1), since),
            _ => (passed.syncs, u32::from(exact), last.when.at),
        };
    }

    /// Returns true if it has come after the same number of SYNCs several times in a row, and not after that of its type: that
    /// is reported at the end of the capture, or once it comes as configured.
    fn is_of_other_type(&self) -> bool {
        self.other.1 >= OTHER_TYPE && self.other.0 > u64::from(self.configured.kind.max(1))
    }

    /// Reports a frame that came in another cycle than was due.
    #[cold]
    fn out_of_cycle(&mut self, last: Arrival, now: Arrival, passed: Passed, known: &Judged<'_>, cx: &mut Context<'_>) {
        let n = u64::from(self.configured.kind.max(1));
        let multiple = passed.syncs.is_multiple_of(n) || passed.least.is_multiple_of(n);
        self.compare(last, passed);
        if self.is_of_other_type() {
            let (node, object) = (known.node, self.object());
            let about = |one: &Finding| one.object == Some(object) && one.node == Some(node);
            cx.evidence.pending.withdraw(|one| one.code == Code::Syn008 && about(one));
            self.phase = now.cycle;
            return;
        }
        if passed.least > n && multiple {
            let count = passed.least / n;
            let due = last.cycle + n;
            self.phase = now.cycle;
            self.open.absent = Some(due);
            let what = Syn008::Missing { cycle: due, count: count.max(2) - 1 };
            let finding = cx.verdict(what, Some(known.node), Some(self.object()), known.period.frame(due));
            self.report(finding, last.when, known, cx);
        } else if now.when.at.t_ns.is_none() {
            // One cycle to either side may be a late echo, or a paused recorder.
            self.phase = now.cycle;
        } else {
            let what = Syn010::TransmissionType { found: passed.syncs, expected: n };
            let finding = cx.verdict(what, Some(known.node), Some(self.object()), Some(last.when.at));
            self.report(finding, last.when, known, cx);
        }
    }

    /// Returns the distance of the last frame from its phase, in cycles.
    fn phase_of(&self, last: Arrival) -> u64 {
        last.cycle.saturating_sub(self.phase)
    }

    /// Takes a second frame in the same cycle.
    #[cold]
    fn second(
        &mut self,
        last: Arrival,
        now: Arrival,
        (absent, doubled): (Option<u64>, bool),
        known: &Judged<'_>,
        cx: &mut Context<'_>,
    ) {
        let (node, object) = (known.node, self.object());
        if let Some(missing) = absent {
            // The frame of the previous cycle was late, and this is the one of the current cycle.
            self.phase = now.cycle;
            let about = |finding: &Finding| finding.code == Code::Syn008 && finding.object == Some(object);
            cx.evidence.pending.withdraw(|finding| about(finding) && finding.node == Some(node));
            // Without stamps the SYNC between may have been early; and frames most of a period apart belong to two
            // cycles whose SYNCs are not listed in time.
            let apart = cx.evidence.recording.between(last.when, now.when);
            if apart.is_none_or(|apart| known.period.period_ns().is_some_and(|period| apart > period / 2)) {
                return;
            }
            let what = Syn010::OtherCycle { expected: missing, found: now.cycle };
            // The earlier frame is the late one.
            let finding = cx.verdict(what, Some(node), Some(object), None);
            return self.report(Finding { at: last.when.at, ..finding }, last.when, known, cx);
        }
        if !(self.established() || (self.configured.kind == 0 && self.configured.needed == ESTABLISHED)) {
            return;
        }
        if now.when.at.t_ns.is_none() && !doubled {
            // It may belong to the next cycle, whose SYNC is listed late; then none comes there.
            self.open.doubled = true;
            self.last = Some(Arrival { cycle: now.cycle + 1, ..now });
            return;
        }
        self.open.reported = true;
        let finding = cx.verdict(Syn009::Twice { cycle: now.cycle }, Some(node), Some(object), Some(last.when.at));
        self.report(finding, last.when, known, cx);
        // The cycles count from the one that was due.
        self.last = Some(last);
    }

    /// Reports a fault since a frame, as a consequence if SYNC was irregular since then.
    fn report(&mut self, finding: Finding, since: When, known: &Judged<'_>, cx: &mut Context<'_>) {
        let mut finding = cx.excused(Rules::SynchronousPdo, since, finding);
        if finding.because_of.is_none() && matches!(finding.code, Code::Syn009 | Code::Syn010) {
            // Another sender, or a wrong type, shows in every frame.
            finding.because_of = self.wrong.fault(finding.at);
        }
        let period_ns = known.period.scale_ns(&cx.evidence.recording).map_or(Ns::ZERO, |(_, most)| most);
        cx.report_later(finding, period_ns * EXPLAINED);
    }
}

/// Returns true if the number of cycles between two frames of a PDO is known, without disturbance.
fn comparable(last: Arrival, now: Arrival, period: &SyncPeriod, recording: &Recording) -> bool {
    let timed = |when: When| when.at.t_ns.is_none() || recording.teaches(when);
    let ordered = now.cycle >= last.cycle && last.when.epoch == now.when.epoch;
    // The time is enough if SYNCs were disturbed.
    ordered && timed(last.when) && timed(now.when) && (period.period_ns().is_some() || last.cycle >= period.calm_from())
}
