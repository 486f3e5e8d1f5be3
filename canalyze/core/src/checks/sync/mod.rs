//! SYNC (CiA 301, 7.2.5): length, counter, period, and number of producers.
//!
//! Frames are passed on to `period` (gaps), `counter` (values), `window` (synchronous PDOs) and `settings`
//! (configuration), and their results reported here. Two producers explain irregularities, which are reported as
//! consequences.

pub mod configured;
pub mod counter;
mod follower;
pub mod length;
pub mod period;
pub mod settings;
pub mod window;

use self::configured::Configured;
use self::counter::{Counter, Miscount};
use self::follower::Follower;
use self::length::Lengths;
use self::period::{Irregular, Restart, SyncPeriod};
use self::settings::SyncSettings;
use self::window::{SyncWindow, synchronous};
use super::PdoName;
use crate::bytes::frame::{CanId, Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::circumstance::CircumstanceKind;
use crate::evidence::{Rules, When};
use crate::rules::finding::{Code, Finding};
use crate::rules::sync::{Syn001, Syn002, Syn003, Syn006, Syn013};
use crate::sdo::wire::Mux;
use crate::wire::cob_id::Role;
use crate::wire::error_control::OPERATIONAL;
use crate::wire::message::{Flaw, Message};
use crate::wire::nmt::{PRE_OPERATIONAL, RESET_COMMUNICATION, RESET_NODE, START, STOP};
use crate::world::context::Context;
use crate::world::event::Placement;
use crate::world::network::Network;
use crate::world::node::{Node, Pdo, PerNode};

/// Minimum time without SYNC after which it counts as stopped, in ns and in periods.
const SILENT_NS: Ns = Ns::from_ms(250);
const SILENT_PERIODS: i64 = 20;
/// Number of periods for which other frames have come after a silence of the bus, so that SYNC alone has stopped.
const GOES_ON: i64 = 2;
/// Number of periods for which a finding waits for a second producer, or for unsteady SYNCs.
const EXPLAINED: i64 = 12;
/// Number of SYNCs after the end of a silence that are still judged by it.
const RETURNED: u64 = 3;
/// The last node that can be addressed by a command.
const LAST_NODE: u8 = 127;

/// SYNC on one bus.
#[derive(Debug, Default)]
pub struct Sync {
    settings: SyncSettings,
    period: SyncPeriod,
    follower: Follower,
    counter: Counter,
    window: SyncWindow,
    /// A command has stopped or reset all nodes, and none was started since: the SYNC may end, before or after a few more.
    halted: bool,
    /// The identifier of the followed SYNCs: the first one seen.
    id: Option<CanId>,
    lengths: Lengths,
    configured: Configured,
    /// The last SYNC whose counter had a gap before it.
    miscounted: Option<u64>,
    producer: Producer,
    activity: Activity,
    /// The period before the last reported change, in ns, and the frame of the change.
    changed: Option<(Ns, FrameRef)>,
    /// The frame at which SYNCs were reported as unsteady, while they are, and the last period, in ns.
    unsteady: Option<FrameRef>,
    last_ns: Option<Ns>,
    /// The frame at which the end of SYNC was reported, and the last SYNC before it.
    end: Option<(FrameRef, u64)>,
    /// The last cycle before which a node was lost, and the frame that shows it: it may be the producer.
    lost: Option<(u64, FrameRef)>,
}

/// The last frame of any kind, and the longest silence of the bus since the last SYNC, in ns.
#[derive(Debug, Default)]
struct Activity {
    heard_ns: Option<Ns>,
    silence_ns: Ns,
    /// The end of that silence, in ns.
    since_ns: Ns,
}

/// The producer's activity.
#[derive(Debug, Default)]
struct Producer {
    /// It may have restarted since the last SYNC; a reason for its stop.
    restarted: bool,
    stopped: Restart,
    /// The end of SYNC was reported, or is unknown.
    ended: bool,
}

impl Sync {
    /// Creates the state for a bus.
    pub fn new(network: &Network, nodes: &PerNode<Node>) -> Self {
        Self { settings: SyncSettings::compile(network, nodes), ..Self::default() }
    }

    /// Returns the shortest synchronous window of the bus, in ns; `None` if none is known.
    pub fn least_window_ns(&self) -> Option<Ns> {
        self.settings.least_window_ns
    }

    /// Returns the configured period, else the measured one, in ns.
    pub fn period_ns(&self) -> Option<Ns> {
        self.settings.period_ns.or_else(|| self.period.period_ns())
    }

    /// Returns the current cycle; 0 before the first.
    pub fn cycle(&self) -> u64 {
        self.period.cycle()
    }

    /// Returns the place of a synchronous PDO in its running SYNC cycle. `lag_ns`: maximum listing delay of SYNC.
    pub fn place(&self, node: u8, pdo: Option<&Pdo>, frame: &Frame, lag_ns: Ns) -> Option<Placement> {
        let pdo = pdo.filter(|pdo| pdo.transmission.is_some_and(|(kind, _)| synchronous(kind)))?;
        if self.producer.ended || self.period.is_overdue(frame.reference()) {
            return None;
        }
        self.window.place(&self.period, node, pdo, frame.reference(), lag_ns)
    }

    /// Takes the time of any frame.
    pub fn heard(&mut self, now_ns: Ns) {
        if let Some(before) = self.activity.heard_ns.replace(now_ns) {
            let silence_ns = now_ns - before;
            if silence_ns > self.activity.silence_ns {
                (self.activity.silence_ns, self.activity.since_ns) = (silence_ns, now_ns);
            }
        }
    }

    /// Takes a PDO of a node; `pdo` is its known configuration.
    pub fn process_data(&mut self, name: PdoName, pdo: Option<&Pdo>, cx: &mut Context<'_>) {
        let PdoName { transmit, number, node } = name;
        if transmit && let Some(delay) = self.period.delay_ns(cx.at) {
            self.follower.follow((node, number), self.cycle(), delay);
        }
        let followed = |pdo: &&Pdo| pdo.transmit && pdo.transmission.is_some_and(|(kind, _)| synchronous(kind));
        if let Some(pdo) = pdo.filter(followed) {
            let window_ns = self.settings.windows.get(usize::from(node)).copied().flatten();
            self.window.arrived(&self.period, node, pdo, window_ns, cx);
        }
        if transmit {
            self.judge_end(node, cx);
        }
    }

    /// Takes a frame of any service other than SDO.
    pub fn message(&mut self, message: &Message, frame: &Frame, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        match *message {
            Message::Sync { counter } => self.sync(counter, frame, nodes, cx),
            Message::Malformed { role: Role::Sync, flaw: Flaw::Length { .. } } => {
                cx.raise(Syn001::Length { found: frame.len.into() }, None, None, None);
                self.sync(None, frame, nodes, cx);
            }
            Message::Nmt { command, node } if node <= LAST_NODE => {
                let stops = match command {
                    START => Restart::None,
                    PRE_OPERATIONAL if node != 0 => Restart::None,
                    PRE_OPERATIONAL => Restart::Perhaps,
                    STOP | RESET_NODE | RESET_COMMUNICATION if node == 0 => Restart::Likely,
                    STOP | RESET_NODE | RESET_COMMUNICATION => Restart::Perhaps,
                    _ => return self.restart(None, Restart::Likely),
                };
                self.halted = command != START && (node == 0 || self.halted);
                self.restart(Some(node).filter(|node| *node != 0), stops);
            }
            // An unreadable frame may have been any command to any node.
            Message::Nmt { .. } | Message::Malformed { role: Role::Nmt, flaw: Flaw::Length { .. } } => {
                self.restart(None, Restart::Likely);
            }
            Message::BootUp { node } => self.restart(Some(node), Restart::Perhaps),
            Message::Heartbeat { node, state: OPERATIONAL, .. } => {
                self.window.alive(node, &self.period, cx);
                self.judge_end(node, cx);
            }
            Message::Heartbeat { node, .. } => self.window.pause(Some(node)),
            Message::PdoRequest { transmit: true, number, node } => self.window.asked(node, number),
            _ => {}
        }
    }

    /// Takes a changed value of an object.
    pub fn configured(&mut self, node: u8, mux: Mux, network: &Network, nodes: &PerNode<Node>, at: FrameRef) {
        let pdo = |number| nodes.get(node).and_then(|node| node.pdo(true, number));
        match mux.index {
            0x1005 | 0x1006 | 0x1007 | 0x1019 => {
                if mux.index != 0x1019 {
                    self.configured.write(node, at, self.period.cycle());
                }
                self.reconfigure(network, nodes);
                (self.producer.restarted, self.producer.stopped) = (true, Restart::Likely);
            }
            0x1800..=0x19FF => self.window.reconfigured(node, mux.index - 0x17FF, pdo(mux.index - 0x17FF)),
            0x1A00..=0x1BFF => self.window.reconfigured(node, mux.index - 0x19FF, pdo(mux.index - 0x19FF)),
            _ => {}
        }
    }

    /// Takes a change of the nodes' configuration, by a reset or a concise DCF.
    pub fn reconfigure(&mut self, network: &Network, nodes: &PerNode<Node>) {
        let before = std::mem::replace(&mut self.settings, SyncSettings::compile(network, nodes));
        if before.period_ns != self.settings.period_ns {
            self.period.forget();
            self.configured.compared = false;
        }
        if before.overflow != self.settings.overflow || before.any_overflow != self.settings.any_overflow {
            self.counter.reconfigured();
            self.lengths.reconfigured();
        }
        self.id = None;
    }

    /// Forgets what was open after lost frames.
    pub fn lost(&mut self) {
        self.period.broken();
        self.producer.ended = true;
        self.counter.forget();
        self.window.pause(None);
    }

    /// Reports what is open at the end of the capture. `configured`: true for a TPDO of a node whose
    /// configuration is known, and whose frames are its own. Returns true if a configured producer has never sent SYNC.
    pub fn finish(
        &mut self,
        nodes: &PerNode<Node>,
        configured: impl Fn(u8, &Pdo) -> bool,
        cx: &mut Context<'_>,
    ) -> bool {
        let never = self.cycle() == 0 && self.configured.never(&self.settings, nodes, cx);
        if let Some(miscount) = self.counter.finish() {
            self.report_miscount(miscount, cx);
        }
        if let Some(irregular) = self.period.finish(cx.at, &cx.evidence.recording) {
            self.report_irregular(irregular, cx);
        }
        self.configured.judge(&self.settings, u64::MAX, nodes, cx);
        self.window.finish(nodes, configured, cx);
        never
    }

    /// Takes an NMT command to a node or to all, or a boot-up.
    fn restart(&mut self, node: Option<u8>, stops: Restart) {
        self.window.pause(node);
        let producer = node.is_none() || self.settings.producer.is_none() || node == self.settings.producer;
        self.producer.restarted |= producer;
        if producer && stops != Restart::None {
            let certain = self.settings.producer.is_some();
            self.producer.stopped = self.producer.stopped.max(if certain { Restart::Likely } else { stops });
        }
    }

    fn sync(&mut self, counter: Option<u8>, frame: &Frame, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        if *self.id.get_or_insert(frame.id) != frame.id {
            return;
        }
        let at = frame.reference();
        let silent = self.is_silent(at);
        self.activity.silence_ns = Ns::ZERO;
        let Producer { restarted, stopped, ended } = std::mem::take(&mut self.producer);
        // A producer that starts counts from 1.
        let restarts = stopped == Restart::Perhaps && counter.is_some_and(|value| self.counter.begins_again(value));
        let wrong = self.lengths.judge(frame.len, self.settings.any_overflow, restarted, cx);
        let period = self.period.period_ns();
        let long = self.period.is_overdue(at);
        let rests = self.halted && self.period.delay_ns(at).is_some_and(|silence| silence > self.end_ns());
        let stopped = if ended || restarts || rests { Restart::Likely } else { stopped };
        let spread_ns = self.follower.spread_ns(self.cycle());
        let before = self.period.frame(self.cycle());
        let lost = before.and_then(|last| cx.evidence.circumstances.first_excuse(Rules::SyncGap, last));
        self.lost = lost.map(|at| (self.cycle() + 1, at)).or(self.lost);
        self.period.counted = self.counter.is_single();
        let irregular = self.period.step(cx.when, (stopped, silent, spread_ns), &cx.evidence.recording);
        match counter {
            // A SYNC of the wrong length carries no counter.
            Some(value) if !wrong => self.count(value, at, restarted || long || (silent && period.is_none()), cx),
            _ => self.counter.forget(),
        }
        for one in irregular {
            self.report_irregular(one, cx);
        }
        self.unsteady = self.unsteady.filter(|_| self.period.is_unsteady());
        self.last_ns = self.period.period_ns().or(self.last_ns);
        self.end = self.end.filter(|(_, cycle)| self.cycle() <= cycle + RETURNED);
        if self.cycle() == 1 {
            self.window.first_sync(cx);
        }
        if self.period.is_single() && !self.counter.are_two() {
            cx.evidence.circumstances.over(CircumstanceKind::TwoSyncProducers, None);
        }
        if self.window.stood_still() && at.t_ns.is_none() {
            self.period.disturbed();
        }
        self.configured.compare(&self.settings, &self.period, cx);
        self.window.report_unjudged(&self.period, self.settings.period_ns.filter(|_| at.t_ns.is_none()), cx);
        self.configured.judge(&self.settings, self.period.cycle(), nodes, cx);
    }

    /// Returns true if the whole bus was silent for most of the time since the last SYNC.
    fn is_silent(&self, at: FrameRef) -> bool {
        self.period.delay_ns(at).is_some_and(|gap| self.activity.silence_ns > gap / 2)
    }

    /// Takes a counter value. `again`: the producer may have restarted with it.
    fn count(&mut self, value: u8, at: FrameRef, again: bool, cx: &mut Context<'_>) {
        let exact = self.settings.overflow.filter(|value| *value > 0);
        for miscount in self.counter.step(value, at, exact, again).into_iter().flatten() {
            if let Miscount::Gap { at, .. } = miscount {
                self.miscounted = Some(at.no);
                let of_it = |cycle: &u64| self.period.frame(*cycle).is_some_and(|frame| frame.no == at.no);
                let cycle = [self.cycle(), self.cycle().saturating_sub(1)].into_iter().find(of_it);
                let sync = cycle.and_then(|cycle| self.period.sync(cycle)).unwrap_or(cx.when);
                self.broken(sync, cx);
                let same = |finding: &Finding| finding.code == Code::Syn003 && finding.at.no == at.no;
                cx.evidence.pending.explain(at, same);
            }
            self.report_miscount(miscount, cx);
        }
    }

    fn report_miscount(&mut self, miscount: Miscount, cx: &mut Context<'_>) {
        let (at, what) = match miscount {
            Miscount::Gap { found, expected, at } => {
                (at, Syn002::Skipped { found: found.into(), expected: expected.into() })
            }
            Miscount::Outside { found, limit } => {
                (cx.at, Syn002::OutOfRange { found: found.into(), limit: limit.into() })
            }
            Miscount::Two { found, expected, at } => {
                let what = Syn006::Counters { found: found.into(), expected: expected.into() };
                return self.two_producers(Finding { at, ..cx.verdict(what, None, None, None) }, cx);
            }
        };
        self.report(Finding { at, ..cx.verdict(what, None, None, None) }, cx);
    }

    /// Reports two producers, which explain waiting and later findings.
    fn two_producers(&self, finding: Finding, cx: &mut Context<'_>) {
        if cx.evidence.circumstances.holds(CircumstanceKind::TwoSyncProducers) {
            return;
        }
        cx.evidence.circumstances.note(CircumstanceKind::TwoSyncProducers, None, When { at: finding.at, ..cx.when });
        cx.evidence.pending.explain(finding.at, is_of_sync);
        cx.report(finding);
    }

    /// Notes a SYNC from which faults of PDOs follow.
    fn broken(&self, sync: When, cx: &mut Context<'_>) {
        cx.evidence.circumstances.note(CircumstanceKind::SyncBroken, None, sync);
        cx.evidence.pending.explain(sync.at, |finding| is_of_sync(finding) && is_of_pdo(finding));
    }

    /// Returns the frame of a reported state of SYNC from which other faults of it follow.
    fn cause(&self, at: FrameRef) -> Option<FrameRef> {
        self.unsteady.or(self.end.map(|(at, _)| at)).filter(|cause| cause.no != at.no)
    }

    /// Reports a finding that a second producer may explain.
    fn report(&self, finding: Finding, cx: &mut Context<'_>) {
        let finding = Finding { because_of: finding.because_of.or_else(|| self.cause(finding.at)), ..finding };
        let period_ns = self.period.scale_ns(&cx.evidence.recording).map_or(Ns::ZERO, |(_, most)| most);
        cx.report_later(cx.excused(Rules::Sync, cx.when, finding), period_ns * EXPLAINED);
    }

    /// Returns the time without SYNC after which it counts as stopped, in ns.
    fn end_ns(&self) -> Ns {
        self.last_ns.map_or(SILENT_NS, |period| (period * SILENT_PERIODS).max(SILENT_NS))
    }

    /// Reports that SYNC has stopped although a node is Operational and the bus alive.
    fn judge_end(&mut self, node: u8, cx: &mut Context<'_>) {
        let Some(silence) = self.period.delay_ns(cx.at).filter(|silence| *silence > SILENT_NS) else { return };
        let intended = self.halted || self.producer.stopped != Restart::None;
        if intended || self.producer.ended || !cx.evidence.recording.teaches(cx.when) {
            return;
        }
        let (Some(last), Some(period)) = (self.period.sync(self.cycle()), self.last_ns) else { return };
        let limit = self.end_ns();
        let active_ns = cx.at.t_ns.map_or(Ns::ZERO, |now| now - self.activity.since_ns);
        let pauses = self.is_silent(cx.at) && active_ns <= period * GOES_ON;
        if pauses || !cx.evidence.recording.certainly_later(cx.when, last, limit) {
            return;
        }
        self.producer.ended = true;
        self.end = Some((cx.at, self.cycle()));
        cx.evidence.circumstances.note(CircumstanceKind::SyncBroken, None, cx.when);
        cx.raise(Syn013::Stopped { silence, period }, Some(node), None, Some(last.at));
    }

    /// Reports the explanation of gaps between SYNCs.
    fn report_irregular(&mut self, irregular: Irregular, cx: &mut Context<'_>) {
        let (cycle, what, lasts) = match irregular {
            Irregular::Changed(from_ns, to_ns, since) => return self.report_change(from_ns, to_ns, since, cx),
            Irregular::Unsteady(cycle, what) => (cycle, what, true),
            Irregular::Sync(cycle, what) => (cycle, what, false),
        };
        let at = self.period.frame(cycle).unwrap_or(cx.at);
        let before = self.period.frame(cycle.saturating_sub(1));
        let cause = before.filter(|_| what.code != Code::Syn012);
        let mut finding = Finding { at, ..cx.verdict(what, None, None, cause) };
        match finding.code {
            Code::Syn006 => return self.two_producers(finding, cx),
            // The counter has shown it.
            Code::Syn003 if self.miscounted == Some(at.no) => return,
            Code::Syn003 => {
                let early =
                    |before: FrameRef| at.since(before).zip(self.period.period_ns()).is_some_and(|(a, b)| a < b);
                finding.because_of = before.filter(|one| self.miscounted == Some(one.no) && early(*one));
                let lost = self.lost.filter(|(back, _)| *back == cycle).map(|(_, at)| at);
                finding.because_of = finding.because_of.or(lost);
                self.broken(self.period.sync(cycle).unwrap_or(cx.when), cx);
            }
            _ => {}
        }
        if lasts {
            cx.evidence.pending.explain(at, is_of_sync);
            self.report(finding, cx);
            self.unsteady = Some(at);
            return;
        }
        self.report(finding, cx);
    }

    /// Reports a change of period that no write explains; a change back follows from it.
    fn report_change(&mut self, from_ns: Ns, to_ns: Ns, since: FrameRef, cx: &mut Context<'_>) {
        let back = self.changed.take().filter(|(before, _)| before.abs_diff(to_ns) <= before.abs() / 32);
        if back.is_none() {
            self.changed = Some((from_ns, since));
        }
        cx.evidence.pending.explain(since, is_of_sync);
        let finding = cx.verdict(Syn003::Changed { period: to_ns, expected: from_ns }, None, None, None);
        self.configured.compared = true;
        self.window.restart(None);
        let because_of = back.map(|(_, at)| at).or_else(|| self.cause(since));
        let finding = Finding { at: since, because_of, ..finding };
        cx.report(cx.excused(Rules::Sync, cx.when, finding));
    }
}

/// Returns true if a finding is about SYNC or a synchronous PDO.
fn is_of_sync(finding: &Finding) -> bool {
    matches!(
        finding.code,
        Code::Syn002 | Code::Syn003 | Code::Syn004 | Code::Syn008 | Code::Syn009 | Code::Syn010 | Code::Syn012
    )
}

/// Returns true if a finding is about a PDO.
fn is_of_pdo(finding: &Finding) -> bool {
    finding.object.is_some()
}
