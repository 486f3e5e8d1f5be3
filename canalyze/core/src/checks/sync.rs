//! SYNC (CiA 301, 7.2.5): its length and counter, its period, and how many producers there are.
//!
//! The gaps between SYNCs are `beat`'s, the counter's values `sync_counter`'s, synchronous PDOs `sync_window`'s, what
//! is configured `sync_settings`'; here frames are handed on to them, and what they say is told. It must not change
//! what a frame means.

use crate::checks::beat::{Beat, Lateness, Pace, Restart};
use crate::checks::sync_counter::{Counter, Miscount};
use crate::checks::sync_settings::{Settings, ns};
use crate::checks::sync_window::{SyncWindow, synchronous};
use crate::cob_id::Role;
use crate::configuration::Provenance;
use crate::context::Context;
use crate::event::Placement;
use crate::finding::{Code, Facts, Quantity};
use crate::frame::{CanId, Frame, FrameRef};
use crate::message::{Flaw, Message};
use crate::network::Network;
use crate::node::{Node, Pdo, PerNode};
use crate::services::sdo::wire::Mux;

/// SYNCs of one length before it is taken for theirs.
const LENGTHS: u8 = 3;
/// Steady gaps before a configured period is held against them.
const AGREED: u32 = 8;
/// The longest that a frame captured twice follows itself.
const COPIED_NS: i64 = 250_000;
/// SYNCs that stood twice before every frame is taken to do so.
const COPIED: u8 = 2;
/// The coarsest resolution that is taken for one, in ns.
const COARSEST: i64 = 10_000_000;
/// The slowest that frames follow each other which a machine that stood still takes from its buffer, and the longest
/// that it stood still.
const DRAINED_NS: i64 = 1_000_000;
const STALL_NS: i64 = 1_000_000_000;
/// SYNCs after which the configuration is taken as complete: a configurator writes one object after the other.
const SETTLED: u64 = 2;
/// How long at least SYNC is missed before it is taken to have stopped, and how many periods.
const SILENT_NS: i64 = 1_000_000_000;
const SILENT_PERIODS: i64 = 10;
/// The NMT commands there are, and the nodes they may be sent to.
const COMMANDS: [u8; 5] = [0x01, 0x02, 0x80, 0x81, 0x82];
const LAST_NODE: u8 = 127;
/// Start; and stop, after which, as after a reset, a producer sends no SYNC for a while.
const START: u8 = 0x01;
const STOP: u8 = 0x02;
/// NMT command for all nodes where a master may stop the SYNC for longer than so many periods, to configure them.
const PRE_OPERATIONAL: u8 = 0x80;
const CONFIGURED: i64 = 3;
/// Heartbeat state Operational.
const OPERATIONAL: u8 = 5;

/// SYNC on one bus.
#[derive(Debug, Default)]
pub struct Sync {
    settings: Settings,
    beat: Beat,
    counter: Counter,
    window: SyncWindow,
    /// The identifier of the SYNCs that are followed: the first one seen.
    id: Option<CanId>,
    length: Option<Length>,
    /// The last SYNC whose counter had a gap before it.
    miscounted: Option<u64>,
    /// The last SYNC's length was against 1019h, and that was said.
    against_1019: bool,
    /// The producer may have begun anew since the last SYNC.
    restarted: bool,
    /// It may have been stopped since the last SYNC.
    stopped: Restart,
    /// All nodes were sent to Pre-operational since then.
    configuring: bool,
    /// SYNCs that stood twice in the capture: the own echo, and what came back from the bus.
    copies: Copies,
    /// The multiple of which all stamps were, in ns: their resolution, whatever their number of decimals.
    grain: Option<i64>,
    /// SYNC is missed, and a node was Operational then.
    silence: Silence,
    /// Two producers were told of.
    two: bool,
    /// Configured periods were held against the traffic.
    compared: bool,
    /// Nodes whose 1005h, 1006h or 1007h is another one, by which frame, in which cycle.
    written: Vec<(u8, FrameRef, u64)>,
}

/// The number of bytes that SYNCs have.
#[derive(Clone, Copy, Debug)]
struct Length {
    bytes: u8,
    /// SYNCs that had it, counted up to [`LENGTHS`].
    had: u8,
    /// SYNCs in a row since that had another.
    others: u8,
}

/// What is known of the time since the last SYNC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Silence {
    /// Nothing worth a word.
    #[default]
    Short,
    /// It is long, and at this time a node was Operational. A machine that stood still may have SYNCs in its buffer, so
    /// the next one is waited for.
    Long(i64),
    /// It was told.
    Told,
}

/// SYNCs that stood twice, as every frame does in some captures.
#[derive(Debug, Default)]
struct Copies {
    /// How many did so.
    count: u8,
    /// The cycle of the last one.
    cycle: u64,
    /// The only one so far, with the time since its original: one too many, unless the next stands twice too.
    only: Option<(FrameRef, i64)>,
    /// The counter value of the last SYNC that was no copy.
    value: Option<u8>,
}

impl Sync {
    /// SYNC on a bus of which nothing was seen.
    pub fn new(network: &Network, nodes: &PerNode<Node>) -> Self {
        let settings = Settings::compile(network, nodes);
        Self { settings, beat: Beat::new(network.jitter_ns), ..Self::default() }
    }

    /// The least synchronous window in force on the bus, in ns; `None` where there is none or none is known.
    pub fn least_window_ns(&self) -> Option<i64> {
        self.settings.least_window_ns
    }

    /// The cycle that runs; 0 before the first.
    pub fn cycle(&self) -> u64 {
        self.beat.cycle()
    }

    /// Where a PDO stands in its SYNC cycle, if it is a synchronous one.
    pub fn place(&self, node: u8, pdo: Option<&Pdo>, frame: &Frame) -> Option<Placement> {
        let pdo = pdo.filter(|pdo| pdo.transmission.is_some_and(|(kind, _)| synchronous(kind)))?;
        self.window.place(&self.beat, node, pdo, frame.reference())
    }

    /// Takes a PDO of a node, known to be configured as `pdo`.
    pub fn process_data(&mut self, node: u8, pdo: Option<&Pdo>, frame: &Frame, cx: &mut Context<'_>) {
        let followed = |pdo: &&Pdo| pdo.transmit && pdo.transmission.is_some_and(|(kind, _)| synchronous(kind));
        if let Some(pdo) = pdo.filter(followed) {
            let window_ns = self.settings.windows.get(usize::from(node)).copied().flatten();
            let copied = self.copies.count > 0 && self.copies.cycle + 1 >= self.beat.cycle();
            if copied && self.window.repeats(node, pdo.number, frame.reference(), COPIED_NS) {
                return;
            }
            self.window.arrived(&self.beat, node, (pdo, frame.reference()), window_ns, cx);
        }
    }

    /// Takes a frame of any other service than SDO.
    pub fn message(&mut self, message: &Message, frame: &Frame, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        match *message {
            Message::Sync { counter } => self.sync(counter, frame, nodes, cx),
            Message::Malformed { role: Role::Sync, flaw: Flaw::Length { .. } } => {
                cx.find(
                    Code::Syn001,
                    None,
                    None,
                    None,
                    Facts::told(2, &[("found", Quantity::Count(frame.len.into()))]),
                );
                self.sync(None, frame, nodes, cx);
            }
            Message::Nmt { command, node } => {
                self.configuring |= command == PRE_OPERATIONAL && node == 0;
                // What cannot be read may have been any command to any node.
                let unread = node > LAST_NODE || !COMMANDS.contains(&command);
                let stops = match command {
                    _ if unread => Restart::Likely,
                    STOP => Restart::Hardly,
                    START | PRE_OPERATIONAL => Restart::None,
                    _ => Restart::Perhaps,
                };
                self.restart(Some(node).filter(|node| *node != 0 && !unread), stops);
            }
            Message::Malformed { role: Role::Nmt, flaw: Flaw::Length { .. } } => self.restart(None, Restart::Likely),
            Message::BootUp { node } => self.restart(Some(node), Restart::Perhaps),
            Message::Heartbeat { node, state: OPERATIONAL, .. } => {
                self.window.alive(node, &self.beat, cx);
                self.judge_silence(node, frame.reference(), cx);
            }
            Message::Heartbeat { node, .. } => self.window.restart(Some(node)),
            Message::PdoRequest { transmit: true, number, node } => self.window.asked(node, number),
            _ => {}
        }
    }

    /// An object of a node is known to hold another value.
    pub fn configured(&mut self, node: u8, mux: Mux, network: &Network, nodes: &PerNode<Node>, at: FrameRef) {
        match mux.index {
            0x1005 | 0x1006 | 0x1007 | 0x1019 => {
                if mux.index != 0x1019 && !self.written.iter().any(|(one, ..)| *one == node) {
                    self.written.push((node, at, 0));
                }
                if let Some(entry) = self.written.iter_mut().find(|(one, ..)| *one == node) {
                    *entry = (node, at, self.beat.cycle());
                }
                self.reconfigure(network, nodes);
                (self.restarted, self.stopped) = (true, Restart::Likely);
            }
            0x1800..=0x19FF => self.window.reconfigured(node, mux.index - 0x17FF),
            0x1A00..=0x1BFF => self.window.reconfigured(node, mux.index - 0x19FF),
            _ => {}
        }
    }

    /// The configuration of nodes is another one: after a reset, or by a concise DCF.
    pub fn reconfigure(&mut self, network: &Network, nodes: &PerNode<Node>) {
        let before = std::mem::replace(&mut self.settings, Settings::compile(network, nodes));
        if before.period_ns != self.settings.period_ns {
            self.beat.forget_period();
            self.compared = false;
        }
        if before.overflow != self.settings.overflow || before.any_overflow != self.settings.any_overflow {
            self.counter.reconfigured();
            self.length = None;
        }
        self.id = None;
        self.two = false;
    }

    /// Frames of the bus were lost.
    pub fn lost(&mut self) {
        self.beat.broken();
        self.silence = Silence::Told;
        self.counter.forget();
        self.window.restart(None);
    }

    /// The capture is over.
    pub fn finish(&mut self, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        if let Some(miscount) = self.counter.finish() {
            tell(miscount, cx);
        }
        if let Some(lateness) = self.beat.finish(cx.at) {
            self.tell_late(lateness, cx);
        }
        self.tell_caught_up(cx);
        self.window.finish(&self.beat, &self.settings.windows, cx);
        self.judge_settings(u64::MAX, nodes, cx);
    }

    /// A node, or all, got an NMT command or has booted.
    fn restart(&mut self, node: Option<u8>, stops: Restart) {
        self.window.restart(node);
        let producer = node.is_none() || self.settings.producer.is_none() || node == self.settings.producer;
        self.restarted |= producer;
        if producer && stops != Restart::None {
            let certain = node.is_none() || self.settings.producer.is_some();
            self.stopped = if certain { Restart::Likely } else { self.stopped.max(stops) };
        }
    }

    fn sync(&mut self, counter: Option<u8>, frame: &Frame, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        if *self.id.get_or_insert(frame.id) != frame.id {
            return;
        }
        let at = frame.reference();
        self.silence = Silence::Short;
        if self.copy(counter, at, cx) {
            return;
        }
        let before = self.beat.sync(self.beat.cycle());
        let restarted = std::mem::take(&mut self.restarted);
        let stopped = std::mem::take(&mut self.stopped);
        let wrong = self.judge_length(frame.len, restarted, cx);
        let decimals = frame.stamp.map_or(0, |stamp| 10_i64.pow(9 - u32::from(stamp.decimals.min(9))));
        let resolution = decimals.max(self.grain.unwrap_or(0));
        let period = self.beat.period_ns();
        let gap = self.beat.delay_ns(at);
        let long = period.is_none_or(|period| gap.is_some_and(|gap| gap > period.saturating_mul(CONFIGURED)));
        let configured = std::mem::take(&mut self.configuring) && long;
        let stopped = if configured { Restart::Likely } else { stopped };
        let pace = self.beat.step(at, resolution, stopped, self.settings.period_ns);
        if let Some(lateness) = self.beat.take_before_pause() {
            self.tell_late(lateness, cx);
        }
        match pace {
            Pace::Settled(lateness) => self.tell_late(lateness, cx),
            _ => self.judge_pace(pace, before, (gap, period), cx),
        }
        self.tell_caught_up(cx);
        let again = restarted || matches!(pace, Pace::Late | Pace::Resumed);
        match counter {
            // What a SYNC of the wrong length carries is no counter.
            Some(value) if !wrong => {
                let exact = self.settings.overflow.filter(|value| *value > 0);
                let bound = self.settings.any_overflow.map(|(value, _)| value).filter(|value| *value > 0);
                for miscount in self.counter.step(value, at, exact, bound, again).into_iter().flatten() {
                    if matches!(miscount, Miscount::Two { .. }) && std::mem::replace(&mut self.two, true) {
                        continue;
                    }
                    if let Miscount::Gap { at, .. } = miscount {
                        self.miscounted = Some(at.no);
                        self.window.explained(self.beat.cycle() - u64::from(at.no != cx.at.no));
                    }
                    tell(miscount, cx);
                }
            }
            _ => self.counter.forget(),
        }
        if self.window.stood_still() && at.t_ns.is_none() {
            self.beat.disturbed();
        }
        self.window.cycle_over(&self.beat, &self.settings.windows, cx);
        self.compare_periods(cx);
        if at.t_ns.is_none() && self.settings.period_ns.is_some() && !self.window.set_told() {
            cx.find(Code::Syn011, None, None, None, Facts::told(0, &[]));
        }
        self.judge_settings(self.beat.cycle(), nodes, cx);
    }

    /// Narrows the resolution of the stamps down.
    #[inline]
    pub fn see_grain(&mut self, t_ns: i64) {
        let mut grain = self.grain.unwrap_or(COARSEST);
        while grain > 1 && t_ns % grain != 0 {
            grain /= 10;
        }
        self.grain = Some(grain);
    }

    /// Whether a SYNC is the last one captured again. One that alone stands twice is told of when the next but one
    /// shows that it is alone.
    fn copy(&mut self, counter: Option<u8>, at: FrameRef, cx: &mut Context<'_>) -> bool {
        let gap = self.beat.delay_ns(at).filter(|gap| (0..=COPIED_NS).contains(gap));
        let cycle = self.beat.cycle();
        let known = match self.beat.period_ns() {
            Some(period) => gap.is_some_and(|gap| gap < period / 4) && !self.beat.catching_up(),
            // Of frames from a buffer the gap before is as short.
            None => cycle == 1 || counter.is_some() || self.beat.last_gap_ns() > 2 * COPIED_NS,
        };
        let fresh = self.copies.cycle != cycle;
        if let Some(gap) = gap.filter(|_| known && fresh && counter == self.copies.value) {
            self.copies.only = (self.copies.count == 0).then_some((at, gap));
            self.copies.count = (self.copies.count + 1).min(COPIED);
            self.copies.cycle = cycle;
            if self.copies.count < COPIED {
                self.beat.disturbed();
            }
            return true;
        }
        self.copies.value = counter;
        if self.copies.count < COPIED
            && cycle > self.copies.cycle
            && let Some((copy, gap)) = self.copies.only.take()
        {
            self.copies.count = 0;
            self.beat.disturbed();
            if self.beat.period_ns().is_none() {
                // It was a SYNC of its own: the cycles were counted wrong.
                self.window.restart(None);
            }
            if let (Some(period), false) = (self.beat.period_ns(), self.two) {
                let tolerance = Quantity::Ns(self.beat.tolerance_ns().unwrap_or(0));
                let facts = [("gap", Quantity::Ns(gap)), ("period", Quantity::Ns(period)), ("tolerance", tolerance)];
                cx.find_at(copy, Code::Syn003, None, None, None, Facts::told(2, &facts));
            }
        }
        false
    }

    /// The length against 1019h, and against the SYNCs before.
    fn judge_length(&mut self, found: u8, restarted: bool, cx: &mut Context<'_>) -> bool {
        if found > 1 {
            return true;
        }
        let measured = Quantity::Count(found.into());
        let said = std::mem::take(&mut self.against_1019);
        if let Some((overflow, node)) = self.settings.any_overflow
            && (overflow > 0) != (found == 1)
        {
            self.against_1019 = true;
            if said {
                return true;
            }
            let facts = [("found", measured), ("overflow", Quantity::Count(overflow.into()))];
            let object = Some(Mux { index: 0x1019, sub: 0 });
            cx.find(Code::Syn001, Some(node), object, None, Facts::told(0, &facts));
            return true;
        }
        let fresh = Length { bytes: found, had: 1, others: 0 };
        let Some(known) = self.length.filter(|_| !restarted) else {
            self.length = Some(fresh);
            return false;
        };
        if found == known.bytes {
            self.length = Some(Length { had: (known.had + 1).min(LENGTHS), others: 0, ..known });
            return false;
        }
        let gives_way = known.had < LENGTHS || known.others + 1 >= LENGTHS;
        self.length = Some(if gives_way { fresh } else { Length { others: known.others + 1, ..known } });
        let wrong = known.had >= LENGTHS && known.others == 0;
        if wrong {
            let facts = [("found", measured), ("expected", Quantity::Count(known.bytes.into()))];
            cx.find(Code::Syn001, None, None, None, Facts::told(1, &facts));
        }
        wrong
    }

    /// A node is Operational, and no SYNC has come for long.
    fn judge_silence(&mut self, node: u8, at: FrameRef, cx: &mut Context<'_>) {
        if self.stopped != Restart::None || self.restarted || self.silence == Silence::Told {
            return;
        }
        let (Some(now), Some(silence), Some(period)) = (at.t_ns, self.beat.delay_ns(at), self.beat.period_ns()) else {
            return;
        };
        if silence <= period.saturating_mul(SILENT_PERIODS).max(SILENT_NS) {
            return;
        }
        match self.silence {
            Silence::Long(since) if now.saturating_sub(since) > period => {
                self.silence = Silence::Told;
                let last = self.beat.sync(self.beat.cycle());
                let facts = [("silence", Quantity::Ns(silence)), ("period", Quantity::Ns(period))];
                cx.find(Code::Syn013, Some(node), None, last, Facts::told(0, &facts));
            }
            Silence::Short => self.silence = Silence::Long(now),
            Silence::Long(_) | Silence::Told => {}
        }
    }

    fn judge_pace(
        &mut self,
        pace: Pace,
        before: Option<FrameRef>,
        (gap, period): (Option<i64>, Option<i64>),
        cx: &mut Context<'_>,
    ) {
        let (gap, period) = (gap.unwrap_or(0), period.unwrap_or(0));
        let tolerance = self.beat.tolerance_ns().unwrap_or(0);
        let measured =
            [("gap", Quantity::Ns(gap)), ("period", Quantity::Ns(period)), ("tolerance", Quantity::Ns(tolerance))];
        match pace {
            Pace::Early if !self.two => {
                cx.find(Code::Syn003, None, None, before, Facts::told(2, &measured));
            }
            Pace::TwoTrains(short, long) if !std::mem::replace(&mut self.two, true) => {
                let [_, period, _] = measured;
                let facts = [("short", Quantity::Ns(short)), ("long", Quantity::Ns(long)), period];
                cx.find(Code::Syn006, None, None, before, Facts::told(1, &facts));
            }
            _ => {}
        }
    }

    /// A SYNC was late, and those after it were not: its producer, or the recording, stood still for a moment.
    fn tell_caught_up(&mut self, cx: &mut Context<'_>) {
        if let Some((gap_ns, cycle)) = self.beat.take_caught_up() {
            self.window.explained(cycle);
            let late = self.beat.sync(cycle);
            let facts = [("gap", Quantity::Ns(gap_ns)), ("period", Quantity::Ns(self.beat.period_ns().unwrap_or(0)))];
            cx.find_at(late.unwrap_or(cx.at), Code::Syn012, None, None, None, Facts::told(0, &facts));
        }
    }

    /// A SYNC was late, or some before it are missing.
    fn tell_late(&mut self, Lateness { gap_ns, cycle, missing }: Lateness, cx: &mut Context<'_>) {
        self.window.explained(cycle);
        let before = self.beat.sync(cycle.saturating_sub(1));
        let at = self.beat.sync(cycle);
        if missing > 0 && at.is_some_and(|at| self.miscounted == Some(at.no)) {
            // The counter has shown it.
            return;
        }
        let facts = [
            ("gap", Quantity::Ns(gap_ns)),
            ("period", Quantity::Ns(self.beat.period_ns().unwrap_or(0))),
            ("tolerance", Quantity::Ns(self.beat.tolerance_ns().unwrap_or(0))),
            ("missing", Quantity::Count(missing.max(1).unsigned_abs())),
        ];
        let face = u8::from(missing == 0);
        cx.find_at(at.unwrap_or(cx.at), Code::Syn003, None, None, before, Facts::told(face, &facts));
    }

    /// Configured periods against the one that shows.
    fn compare_periods(&mut self, cx: &mut Context<'_>) {
        let Some(period) = self.beat.period_ns().filter(|_| !self.compared && self.beat.steady() >= AGREED) else {
            return;
        };
        // Frames that a machine that stood still takes from its buffer have a beat too, and it ends.
        let buffered = |configured: &i64| {
            period < DRAINED_NS.min(configured / 4) && i64::from(self.beat.steady()) < STALL_NS / configured.max(&1)
        };
        if self.settings.periods.iter().any(|(_, configured)| buffered(configured)) {
            return;
        }
        self.compared = true;
        for (node, configured) in &self.settings.periods {
            if configured.abs_diff(period) > configured.unsigned_abs() / 5 {
                let facts = [("period", Quantity::Ns(period)), ("expected", Quantity::Ns(*configured))];
                let object = node.map(|_| Mux { index: 0x1006, sub: 0 });
                cx.find(Code::Syn003, *node, object, None, Facts::told(3, &facts));
            }
        }
    }

    /// What was written, once the configuration has settled.
    fn judge_settings(&mut self, cycle: u64, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        if self.written.is_empty() {
            return;
        }
        let mut written = std::mem::take(&mut self.written);
        let mut two: Option<(FrameRef, u8, u8)> = None;
        written.retain(|(node, at, since)| {
            if cycle < since.saturating_add(SETTLED) {
                return true;
            }
            let observed = |index| {
                let value = nodes.get(*node)?.value(index, 0);
                value.filter(|(us, from)| *us > 0 && *from > Provenance::Option).map(|(us, _)| ns(us))
            };
            let cause = Some(*at).filter(|at| at.no != cx.at.no);
            let period = observed(0x1006).or(self.settings.period_ns);
            if let (Some(window), Some(period)) = (observed(0x1007), period)
                && window >= period
            {
                let facts = [("window", Quantity::Ns(window)), ("period", Quantity::Ns(period))];
                let object = Some(Mux { index: 0x1007, sub: 0 });
                cx.find(Code::Syn007, Some(*node), object, cause, Facts::told(0, &facts));
            }
            let producers = &self.settings.producers;
            let other = producers.iter().find(|other| *other != node && active(nodes, **other));
            if let Some(other) = other.filter(|_| producers.contains(node) && active(nodes, *node)) {
                // Of two that were written, the later one.
                two = two.filter(|(before, ..)| before.no > at.no).or(Some((*at, *node, *other)));
            }
            false
        });
        self.written = written;
        if let Some((at, node, other)) = two {
            let object = Some(Mux { index: 0x1005, sub: 0 });
            let facts = Facts::told(2, &[("other", Quantity::Count(other.into()))]);
            cx.find(Code::Syn006, Some(node), object, Some(at).filter(|at| at.no != cx.at.no), facts);
        }
    }
}

/// Whether a producer has a period: without one it sends nothing.
fn active(nodes: &PerNode<Node>, node: u8) -> bool {
    nodes.get(node).and_then(|node| node.value(0x1006, 0)).is_some_and(|(us, from)| us > 0 && from > Provenance::Eds)
}

fn tell(miscount: Miscount, cx: &mut Context<'_>) {
    let count = |value: u8| Quantity::Count(value.into());
    let (code, at, facts) = match miscount {
        Miscount::Gap { found, expected, at } => {
            (Code::Syn002, at, Facts::told(0, &[("found", count(found)), ("expected", count(expected))]))
        }
        Miscount::Outside { found, limit } => {
            (Code::Syn002, cx.at, Facts::told(1, &[("found", count(found)), ("limit", count(limit))]))
        }
        Miscount::Two { found, expected, at } => {
            (Code::Syn006, at, Facts::told(0, &[("found", count(found)), ("expected", count(expected))]))
        }
    };
    cx.find_at(at, code, None, None, None, facts);
}
