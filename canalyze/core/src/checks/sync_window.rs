//! Synchronous PDOs in their SYNC cycles (CiA 301, 7.2.2.2 and 7.2.5): where each stands, and whether it came once, in
//! its cycle, within the synchronous window.
//!
//! Where a PDO stands is said at once; it is judged when its cycle is over, since only the next SYNC shows whether it
//! belongs to that one (whose echo came late), and whether the machine stood still. What is due is learnt from the
//! traffic: a TPDO of type n is judged once it has come every n-th cycle. RPDOs are placed and not judged: they are
//! actuated with the next SYNC, whenever they come. It must not judge the SYNCs themselves.

use crate::checks::beat::Beat;
use crate::checks::jitter::Spread;
use crate::checks::sync_doubts::{Doubtful, Doubts};
use crate::configuration::Provenance;
use crate::context::Context;
use crate::event::Placement;
use crate::finding::{Code, Facts, Quantity};
use crate::frame::{CanId, FrameRef};
use crate::node::{Pdo, PerNode};
use crate::services::pdo::communication_parameter;
use crate::services::sdo::wire::Mux;

/// Synchronous TPDOs followed at most (invariant 6).
const TRACKS: usize = 512;
/// Times in a row that a PDO must have come n cycles after the last before its absence is remarkable; more where its transmission type is
/// only preset by an EDS, which the device need not have kept to.
const ESTABLISHED: u8 = 1;
const ESTABLISHED_BY_EDS: u8 = 8;
/// Gaps measured before the tolerance is said to be too large.
const MEASURED: u32 = 8;

/// Whether a transmission type is synchronous: 0, 1..=240, 252 (CiA 301, table 71).
pub fn synchronous(kind: u8) -> bool {
    kind <= 240 || kind == 252
}

/// The synchronous TPDOs of a bus.
#[derive(Debug, Default)]
pub struct SyncWindow {
    nodes: PerNode<Tracks>,
    count: usize,
    /// TPDOs that wait for the next SYNC: of each at most once.
    waiting: Vec<(u8, u16)>,
    /// What may follow from a SYNC that is missing.
    doubts: Doubts,
    /// It was said that windows cannot be judged.
    told: bool,
    /// Cycles in a row, up to the running one, in which no synchronous TPDO of any node came.
    empty: u8,
}

/// The synchronous TPDOs of a node.
#[derive(Debug, Default)]
struct Tracks {
    list: Vec<Track>,
    /// The cycle in which the node was last seen to be Operational.
    alive: u64,
}

/// A PDO that came.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    at: FrameRef,
    cycle: u64,
    delay_ns: Option<i64>,
    /// It stood before the SYNC to whose cycle it belongs.
    early: bool,
}

/// One synchronous TPDO.
#[derive(Debug)]
struct Track {
    number: u16,
    kind: u8,
    id: CanId,
    /// Times it must have come before it is judged.
    needed: u8,
    /// It always came about as long after its SYNC.
    keeps_place: bool,
    /// Its type was shown by the capture, whose beginning is no cut then.
    shown: bool,
    /// What came last and is settled: its cycle, its frame, and whether it stood before its SYNC.
    last: Option<(u64, FrameRef)>,
    early: bool,
    /// A cycle in which it was due and came.
    phase: u64,
    /// Times that it came as it should, in a row.
    steady: u8,
    /// It came and waits for the next SYNC.
    open: Option<Arrival>,
    /// It did not come in this cycle, nor in so many; held while it may come late.
    absent: Option<(u64, u64)>,
    /// Its absence, or one too many, has been said: what follows from it is not said again.
    said: bool,
    /// A remote frame asked for it.
    asked: bool,
    /// It came before any SYNC.
    before: u8,
    listed: bool,
    delays: Spread,
}

impl SyncWindow {
    /// Where a PDO stands, as far as that can be said when it comes.
    pub fn place(&self, beat: &Beat, node: u8, pdo: &Pdo, at: FrameRef) -> Option<Placement> {
        let cycle = beat.cycle();
        if cycle == 0 {
            return None;
        }
        let delay_ns = beat.delay_ns(at);
        if let (Some(delay), Some(period), true) = (delay_ns, beat.period_ns(), pdo.transmit)
            && (period - beat.early_ns()..=period).contains(&delay)
            && self.track(node, pdo.number).is_some_and(|track| track.early || track.came(cycle))
        {
            return Some(Placement { cycle: cycle + 1, delay_ns: Some(delay - period) });
        }
        Some(Placement { cycle, delay_ns })
    }

    /// Takes a synchronous TPDO. `window_ns`: its window, where there is one.
    pub fn arrived(
        &mut self,
        beat: &Beat,
        node: u8,
        (pdo, at): (&Pdo, FrameRef),
        window_ns: Option<i64>,
        cx: &mut Context<'_>,
    ) {
        let Some((kind, from)) = pdo.transmission.filter(|(_, from)| !from.is_doubted()) else { return };
        self.tell_unjudged(beat, at, window_ns, cx);
        self.empty = 0;
        let tracks = self.nodes.entry(node);
        let place = match tracks.list.iter().position(|track| track.number == pdo.number) {
            Some(place) => place,
            None if self.count >= TRACKS => return,
            None => {
                self.count += 1;
                tracks.list.push(Track::new(pdo.number));
                tracks.list.len() - 1
            }
        };
        let Some(track) = tracks.list.get_mut(place) else { return };
        if (track.kind, track.id) != (kind, pdo.cob.0.id) {
            track.restart();
            (track.kind, track.id) = (kind, pdo.cob.0.id);
        }
        track.needed = if from > Provenance::Eds { ESTABLISHED } else { ESTABLISHED_BY_EDS };
        track.shown = matches!(from, Provenance::Observed(_));
        if let Some(open) = track.open.take() {
            track.settle(open, beat, window_ns, node, &mut self.doubts, cx);
        }
        let arrival = Arrival { at, cycle: beat.cycle(), delay_ns: beat.delay_ns(at), early: false };
        if arrival.cycle == 0 {
            track.before = track.before.saturating_add(1);
            if track.before == 2 {
                cx.find(Code::Syn005, Some(node), Some(track.object()), None, Facts::None);
            }
        }
        if track.waits(arrival, beat, window_ns) {
            track.open = Some(arrival);
        } else {
            track.settle(arrival, beat, window_ns, node, &mut self.doubts, cx);
        }
        if (track.open.is_some() || track.absent.is_some()) && !std::mem::replace(&mut track.listed, true) {
            self.waiting.push((node, pdo.number));
        }
        self.alive(node, beat, cx);
    }

    /// Whether a TPDO follows itself by no more than `within_ns`.
    pub fn repeats(&self, node: u8, number: u16, at: FrameRef, within_ns: i64) -> bool {
        let last =
            self.track(node, number).and_then(|track| track.open.map(|open| open.at).or(track.last.map(|it| it.1)));
        let gap = last.and_then(|last| last.t_ns).zip(at.t_ns).map(|(last, at)| at.saturating_sub(last));
        gap.is_some_and(|gap| (0..=within_ns).contains(&gap))
    }

    /// A node has shown that it is Operational: what it should have sent is missing.
    pub fn alive(&mut self, node: u8, beat: &Beat, cx: &mut Context<'_>) {
        let Some(tracks) = self.nodes.get_mut(node) else { return };
        if std::mem::replace(&mut tracks.alive, beat.cycle()) == beat.cycle() {
            return;
        }
        for track in &mut tracks.list {
            let due = track.phase + u64::from(track.kind);
            let judged = track.cyclic() && track.established() && !track.said && track.absent.is_none();
            // It should have come once more since: what is missing once is told when it comes again.
            let twice_due = beat.cycle() > due + u64::from(track.kind);
            if judged && track.open.is_none() && twice_due && track.phase >= beat.calm_from() {
                track.said = true;
                let facts = [("cycle", Quantity::Count(due)), ("since", Quantity::Count(beat.cycle() - due))];
                let facts = Facts::told(1, &facts);
                cx.find(Code::Syn008, Some(node), Some(track.object()), beat.sync(due), facts);
            }
        }
    }

    /// A SYNC came, and nothing since the one before, though several TPDOs were due, or nothing for longer: without
    /// stamps the only sign that the machine stood still.
    pub fn stood_still(&mut self) -> bool {
        let due = |track: &&Track| track.kind == 1 && track.established();
        let tracks = || self.nodes.iter().flat_map(|(_, tracks)| &tracks.list);
        let still = self.empty > 1 || (self.empty == 1 && tracks().filter(due).count() >= 2);
        self.empty = self.empty.saturating_add(1);
        still
    }

    /// A SYNC came: `beat` has taken it. What waited for it is judged.
    pub fn cycle_over(&mut self, beat: &Beat, windows: &[Option<i64>], cx: &mut Context<'_>) {
        let mut waiting = std::mem::take(&mut self.waiting);
        waiting.retain(|(node, number)| {
            let window_ns = windows.get(usize::from(*node)).copied().flatten();
            let Some(track) = self.nodes.get_mut(*node).and_then(|tracks| tracks.find(*number)) else { return false };
            let open = track.open.take();
            if let Some(open) = open.filter(|open| open.cycle == 0 || !track.undecided(*open, beat)) {
                let settled = track.before_sync(open, beat);
                track.settle(settled, beat, window_ns, *node, &mut self.doubts, cx);
                if settled.cycle == 0 && settled.at.t_ns.is_some() && track.shown && track.before == 1 {
                    track.before = 2;
                    cx.find(Code::Syn005, Some(*node), Some(track.object()), Some(settled.at), Facts::None);
                }
            }
            if !track.came(beat.cycle()) {
                track.miss(beat, *node, cx);
            }
            track.listed = track.absent.is_some();
            track.listed
        });
        self.waiting = waiting;
        self.doubts.cycle_over(beat, cx);
    }

    /// The SYNC that began a cycle was late, or others are missing before it.
    pub fn explained(&mut self, cycle: u64) {
        self.doubts.explained(cycle);
    }

    /// A node (or all) was started, stopped or reset, or frames were lost: what it sends is learnt anew.
    pub fn restart(&mut self, node: Option<u8>) {
        for (id, tracks) in self.nodes.iter_mut() {
            if node.is_none_or(|node| node == id) {
                tracks.list.iter_mut().for_each(Track::restart);
            }
        }
    }

    /// One TPDO of a node is another one by configuration.
    pub fn reconfigured(&mut self, node: u8, number: u16) {
        if let Some(track) = self.nodes.get_mut(node).and_then(|tracks| tracks.find(number)) {
            track.restart();
        }
    }

    /// A remote frame asks for a TPDO.
    pub fn asked(&mut self, node: u8, number: u16) {
        if let Some(track) = self.nodes.get_mut(node).and_then(|tracks| tracks.find(number)) {
            track.asked = true;
        }
    }

    /// The capture is over: what was open, as far as it needs no further SYNC.
    pub fn finish(&mut self, beat: &Beat, windows: &[Option<i64>], cx: &mut Context<'_>) {
        for (node, number) in std::mem::take(&mut self.waiting) {
            let window_ns = windows.get(usize::from(node)).copied().flatten();
            let Some(track) = self.nodes.get_mut(node).and_then(|tracks| tracks.find(number)) else { continue };
            let due = |delay: i64| beat.period_ns().is_none_or(|period| delay > period - beat.early_ns());
            if let Some(open) = track.open.take()
                && !open.delay_ns.is_none_or(due)
            {
                track.settle(open, beat, window_ns, node, &mut self.doubts, cx);
            }
            track.miss(beat, node, cx);
        }
        self.doubts.finish(cx);
    }

    fn track(&self, node: u8, number: u16) -> Option<&Track> {
        self.nodes.get(node)?.list.iter().find(|track| track.number == number)
    }

    /// Says once that windows cannot be judged: without stamps, or because the tolerance is larger than they are.
    fn tell_unjudged(&mut self, beat: &Beat, at: FrameRef, window_ns: Option<i64>, cx: &mut Context<'_>) {
        let Some(window) = window_ns.filter(|_| !self.told && beat.cycle() > 0) else { return };
        let facts = match beat.tolerance_ns() {
            _ if at.t_ns.is_none() => Facts::told(0, &[]),
            Some(tolerance) if tolerance >= window && beat.steady() >= MEASURED => {
                Facts::told(1, &[("tolerance", Quantity::Ns(tolerance)), ("window", Quantity::Ns(window))])
            }
            _ => return,
        };
        self.told = true;
        cx.find(Code::Syn011, None, None, None, facts);
    }

    /// It was said elsewhere that times cannot be judged.
    pub fn set_told(&mut self) -> bool {
        std::mem::replace(&mut self.told, true)
    }
}

impl Tracks {
    fn find(&mut self, number: u16) -> Option<&mut Track> {
        self.list.iter_mut().find(|track| track.number == number)
    }
}

impl Track {
    fn new(number: u16) -> Self {
        Self {
            number,
            kind: u8::MAX,
            id: CanId::standard(0),
            needed: ESTABLISHED,
            keeps_place: false,
            shown: false,
            last: None,
            early: false,
            phase: 0,
            steady: 0,
            open: None,
            absent: None,
            said: false,
            asked: false,
            before: 0,
            listed: false,
            delays: Spread::default(),
        }
    }

    /// What it does is learnt anew; its figures stay.
    fn restart(&mut self) {
        (self.last, self.open, self.absent) = (None, None, None);
        (self.early, self.steady, self.said, self.asked) = (false, 0, false, false);
    }

    fn object(&self) -> Mux {
        Mux { index: communication_parameter(true, self.number), sub: 2 }
    }

    fn cyclic(&self) -> bool {
        (1..=240).contains(&self.kind)
    }

    /// By an EDS alone only what also comes at the same place of the cycle: a device that was configured to an event timer
    /// as long as the period comes in every cycle too, for a while.
    fn established(&self) -> bool {
        self.steady >= self.needed && (self.needed == ESTABLISHED || self.keeps_place)
    }

    fn came(&self, cycle: u64) -> bool {
        self.last.is_some_and(|(last, _)| last >= cycle)
    }

    fn due(&self, cycle: u64) -> bool {
        cycle > self.phase && (cycle - self.phase).is_multiple_of(u64::from(self.kind.max(1)))
    }

    /// Whether a PDO may be the next SYNC's, or is to be judged with its cycle.
    fn waits(&self, arrival: Arrival, beat: &Beat, window_ns: Option<i64>) -> bool {
        let (Some(delay), Some(period)) = (arrival.delay_ns, beat.period_ns()) else { return true };
        delay > period / 2 || window_ns.is_some_and(|window| delay > window)
    }

    /// The SYNC after a PDO came: whose it is. Without stamps nothing tells how far before the SYNC it stood, so it is
    /// that one's wherever it is one too many otherwise.
    fn before_sync(&self, open: Arrival, beat: &Beat) -> Arrival {
        let next = open.cycle + 1;
        let ahead = self.ahead(open, beat);
        let nexts = match self.last {
            _ if ahead.is_some_and(|ahead| !within_echo(ahead, open.cycle, beat)) => false,
            None => ahead.is_some(),
            Some(_) if self.came(open.cycle) => true,
            Some(_) if self.cyclic() && self.due(open.cycle) != self.due(next) => self.due(next),
            Some(_) => self.early && ahead.is_some(),
        };
        if !nexts {
            return open;
        }
        Arrival { cycle: next, delay_ns: ahead.map(|ahead| -ahead), early: true, ..open }
    }

    /// How long a PDO stood before the SYNC that came after it.
    fn ahead(&self, open: Arrival, beat: &Beat) -> Option<i64> {
        let sync = beat.sync(open.cycle + 1).and_then(|sync| sync.t_ns);
        sync.zip(open.at.t_ns).map(|(sync, at)| sync.saturating_sub(at))
    }

    /// What comes with any SYNC, and stood just before one: nothing tells whose it was.
    fn undecided(&self, open: Arrival, beat: &Beat) -> bool {
        self.kind == 0 && self.ahead(open, beat).is_some_and(|ahead| within_echo(ahead, open.cycle, beat))
    }

    /// Judges a PDO whose cycle is known.
    fn settle(
        &mut self,
        it: Arrival,
        beat: &Beat,
        window_ns: Option<i64>,
        node: u8,
        doubts: &mut Doubts,
        cx: &mut Context<'_>,
    ) {
        let asked = std::mem::take(&mut self.asked);
        if let Some(delay) = it.delay_ns.filter(|_| it.cycle > 0) {
            self.delays.record(delay);
        }
        let width = beat.period_ns().filter(|_| self.delays.count() > 0).map(|period| period / 4);
        self.keeps_place = width.is_some_and(|width| self.delays.width_ns() <= width);
        let before = self.last.replace((it.cycle, it.at));
        let early = std::mem::replace(&mut self.early, it.early);
        if self.kind == 252 || it.cycle == 0 || asked {
            self.last = before.or(self.last);
            return;
        }
        self.judge_delay(it, beat, window_ns, node, cx);
        let Some((last, last_at)) = before.filter(|(last, _)| *last > 0) else {
            self.phase = it.cycle;
            return;
        };
        if last < beat.calm_from() || it.cycle < last {
            (self.phase, self.absent, self.said) = (it.cycle, None, false);
            return;
        }
        if it.cycle == last {
            self.judge_second(it, (last_at, early), beat, node, doubts, cx);
        } else {
            self.judge_cycle(it, last, beat, node, doubts, cx);
        }
    }

    fn judge_delay(&self, it: Arrival, beat: &Beat, window_ns: Option<i64>, node: u8, cx: &mut Context<'_>) {
        let known = self.needed == ESTABLISHED || self.established();
        if let (Some(delay), Some(window), Some(tolerance)) = (it.delay_ns, window_ns, beat.tolerance_ns())
            && known
            && tolerance < window
            && delay > window.saturating_add(tolerance)
            && it.cycle >= beat.calm_from()
        {
            let facts = [
                ("delay", Quantity::Ns(delay)),
                ("window", Quantity::Ns(window)),
                ("tolerance", Quantity::Ns(tolerance)),
                ("cycle", Quantity::Count(it.cycle)),
            ];
            cx.find(Code::Syn004, Some(node), Some(self.object()), earlier(it.at, cx), Facts::told(0, &facts));
        }
    }

    /// It came in the cycle in which it had come.
    fn judge_second(
        &mut self,
        it: Arrival,
        (last_at, early): (FrameRef, bool),
        beat: &Beat,
        node: u8,
        doubts: &mut Doubts,
        cx: &mut Context<'_>,
    ) {
        let object = self.object();
        if let Some((missing, _)) = self.absent.take() {
            // The one of the cycle before came late, and now the one of this cycle.
            self.phase = it.cycle;
            // Without stamps the SYNC between may as well have come early; and what always comes near the next SYNC
            // comes after it now and then.
            let usual = self.delays.p99_ns();
            // A machine that stands still for a little longer than a cycle holds up the SYNC as well.
            let near = |period: i64| usual > period / 2 || beat.lag_ns(it.cycle) > period / 8;
            if it.at.t_ns.is_none() || beat.period_ns().is_some_and(near) {
                return;
            }
            let facts = [("expected", Quantity::Count(missing)), ("found", Quantity::Count(it.cycle))];
            let facts = Facts::told(1, &facts);
            let what = Doubtful { code: Code::Syn010, node, object, cause: Some(last_at), facts };
            doubts.find(what, (missing, it.cycle), beat, cx);
        } else if self.established() || (self.kind == 0 && self.needed == ESTABLISHED) {
            // What stood before the SYNC was one too many of the cycle before.
            let cycle = if early { it.cycle - 1 } else { it.cycle };
            self.said = true;
            let facts = Facts::told(0, &[("cycle", Quantity::Count(cycle))]);
            let cause = if early || it.at.no == cx.at.no { Some(last_at) } else { Some(it.at) };
            doubts.find(Doubtful { code: Code::Syn009, node, object, cause, facts }, (cycle, it.cycle), beat, cx);
        }
    }

    /// It came in a cycle of its own: whether in the one in which it was due.
    fn judge_cycle(
        &mut self,
        it: Arrival,
        last: u64,
        beat: &Beat,
        node: u8,
        doubts: &mut Doubts,
        cx: &mut Context<'_>,
    ) {
        let n = u64::from(self.kind);
        let said = std::mem::take(&mut self.said);
        if n == 0 {
            return;
        }
        let passed = it.cycle - last;
        let on_phase = (it.cycle - self.phase.min(it.cycle)).is_multiple_of(n);
        if passed == n || (on_phase && last != self.phase) {
            self.steady = self.steady.saturating_add(u8::from(passed == n));
            self.phase = it.cycle;
            return;
        }
        // Of every second SYNC or less, a multiple of its type is proof enough that it follows the type.
        let known = self.established() || (n > 1 && on_phase && it.at.t_ns.is_some() && self.needed == ESTABLISHED);
        if !known {
            self.steady = 0;
            self.phase = it.cycle;
            return;
        }
        if on_phase {
            let first = self.phase + n;
            self.absent = (!said).then_some((first, (it.cycle - first) / n));
            self.phase = it.cycle;
            if n > 1 {
                // One that is late would not have come n cycles after.
                self.miss(beat, node, cx);
            }
        } else if it.at.t_ns.is_none() && (self.due(it.cycle - 1) || self.due(it.cycle + 1)) {
            // Without stamps one cycle to either side may be a late echo, or a machine that stood still.
            self.phase = it.cycle;
        } else if !said {
            let facts = [("found", Quantity::Count(passed)), ("expected", Quantity::Count(n))];
            let (object, cause) = (self.object(), earlier(it.at, cx));
            let what = Doubtful { code: Code::Syn010, node, object, cause, facts: Facts::told(0, &facts) };
            doubts.find(what, (last, it.cycle), beat, cx);
        }
    }

    /// The cycle is over, and what was missing has not come late.
    fn miss(&mut self, beat: &Beat, node: u8, cx: &mut Context<'_>) {
        let Some((cycle, count)) = self.absent.take() else { return };
        if cycle < beat.calm_from() {
            return;
        }
        let facts = Facts::told(0, &[("cycle", Quantity::Count(cycle)), ("count", Quantity::Count(count))]);
        cx.find(Code::Syn008, Some(node), Some(self.object()), beat.sync(cycle), facts);
    }
}

/// Whether what stood so long before the SYNC after `cycle` may be that one's, whose echo came late: two fifths of
/// the gap at most, whether or not a period is known yet.
fn within_echo(ahead: i64, cycle: u64, beat: &Beat) -> bool {
    let at = |cycle| beat.sync(cycle).and_then(|sync| sync.t_ns);
    let gap = at(cycle + 1).zip(at(cycle)).map(|(next, sync)| next.saturating_sub(sync));
    let most = gap.map_or(beat.early_ns(), |gap| beat.early_ns().min(gap / 5 * 2));
    if gap.is_some_and(|gap| beat.resolution_ns() > gap / 2) {
        return false;
    }
    (0..=most).contains(&ahead)
}

/// A frame, where it is not the one at hand.
fn earlier(at: FrameRef, cx: &Context<'_>) -> Option<FrameRef> {
    (at.no != cx.at.no).then_some(at)
}
