//! Compares the protocol's table with the machine: each conformant frame leads to a state that its row names.

use super::*;
use crate::bytes::ns::Ns;
use crate::sdo::machine::{Action, ChannelState, transition};

/// Actions that no frame of a conformant session needs.
const VIOLATIONS: [Action; 8] = [
    Action::Restart,
    Action::GiveUp,
    Action::GoOn,
    Action::Misfit,
    Action::Unasked,
    Action::Stray,
    Action::Outside,
    Action::ConfirmUnseen,
];

/// Returns the state before, the action, and the state after each frame.
fn walk(frames: &[Bytes]) -> Vec<(ChannelState, Action, ChannelState)> {
    let mut channel = SdoChannel::new(BusId(0), 10, None);
    channel.idle_for(Ns::MAX, true);
    let mut evidence = Evidence::default();
    let (mut events, mut next, mut chunks) = (Vec::new(), 0, Vec::new());
    let mut steps = Vec::new();
    for (no, (side, bytes)) in frames.iter().enumerate() {
        let frame = placed(*side, bytes, no, None);
        let behind = frames.get(no + 1).map(|(side, bytes)| (*side, placed(*side, bytes, no + 1, None)));
        let before = channel.state();
        let row = transition(before, *side, &channel.decode(*side, frame.head(), frame.len));
        let at = frame.reference();
        let mut cx = Context {
            events: &mut events,
            next_transfer: &mut next,
            extract: false,
            chunks: &mut chunks,
            bus: BusId(0),
            at,
            evidence: &mut evidence,
            when: When { at, ..When::default() },
            sighting: Sighting::Original,
            next: None,
            repeats: None,
            news_only: false,
        };
        channel.step(*side, &frame, behind.as_ref(), &mut cx);
        let after = channel.state();
        assert!(
            row.to.contains(&after) || after == before,
            "{before:?} {:?} -> {after:?}, not {:?}",
            row.action,
            row.to
        );
        assert!(row.clause.starts_with("7.2.4."), "{before:?}: {}", row.clause);
        steps.push((before, row.action, after));
    }
    steps
}

#[test]
fn the_worked_examples() {
    for text in [E1, E12, E13, E14, E15, E15_ZERO, E17] {
        let steps = walk(&frames(text));
        assert!(steps.iter().all(|(_, action, _)| !VIOLATIONS.contains(action)), "{text}: {steps:?}");
        assert_eq!(steps.last().unwrap().2, ChannelState::Idle, "{text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    /// Each frame of a conformant session follows its row, and none needs a violation's row.
    #[test]
    fn conformant_sessions(sessions in proptest::collection::vec(any_session(), 1..5)) {
        let mut causal = Vec::new();
        for (no, (kind, data, blksize, cut, code)) in sessions.iter().enumerate() {
            causal.extend(session(0x2000 + no as u16, *kind, data, *blksize, *cut, *code));
        }
        let steps = walk(&causal);
        prop_assert!(steps.iter().all(|(_, action, _)| !VIOLATIONS.contains(action)), "{:?}", steps);
        // Only a block transfer stays in its sub-block; every other frame leads on.
        for (before, action, after) in &steps {
            prop_assert!(before != after || *action == Action::Segment, "{:?} {:?}", before, action);
        }
    }
}
