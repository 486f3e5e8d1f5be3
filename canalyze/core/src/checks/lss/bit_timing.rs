//! A bit timing configured by LSS (CiA 305): its activation in time, and the silence that follows.

use super::withheld::Withheld;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::finding::Code;
use crate::rules::lss::Lss008;
use crate::wire::lss::bit_rate;
use crate::wire::message::Message;
use crate::world::context::Context;
use crate::world::event::{Event, Note, What};

/// Maximum time from the return to waiting to the activation of a bit timing, in ns; masters do it at once.
const ACTIVATION_NS: Ns = Ns::from_ms(500);

/// A bit timing accepted by a slave.
#[derive(Debug)]
struct Accepted {
    at: FrameRef,
    rate: Option<u16>,
    stored: bool,
    /// The latest time for its activation, in ns, after the slaves have returned to waiting.
    until_ns: Option<Ns>,
}

/// The silence of the bus during the change of the bit rate.
#[derive(Debug)]
struct Silence {
    at: FrameRef,
    from_ns: Ns,
    to_ns: Ns,
    delay_ns: Ns,
}

/// The state of a bus's bit timing.
#[derive(Debug, Default)]
pub struct BitTiming {
    /// The last bit rate requested by the master, in kbit/s.
    requested: Option<u16>,
    accepted: Option<Accepted>,
    silence: Option<Silence>,
}

impl BitTiming {
    /// Takes the master's configuration of a bit timing.
    pub fn configure(&mut self, selector: u8, index: u8) {
        self.requested = if selector == 0 { bit_rate(index) } else { None };
    }

    /// Takes a slave's acceptance.
    pub fn accept(&mut self, at: FrameRef) {
        self.accepted = Some(Accepted { at, rate: self.requested, stored: false, until_ns: None });
    }

    /// Takes a slave's confirmation that it has stored its configuration.
    pub fn store(&mut self) {
        self.accepted.iter_mut().for_each(|accepted| accepted.stored = true);
    }

    /// Takes the slaves' return to waiting.
    pub fn waiting(&mut self, at: FrameRef) {
        if let Some(accepted) = &mut self.accepted {
            accepted.until_ns = at.t_ns.map(|now| now + ACTIVATION_NS);
        }
    }

    /// Takes a reset or boot-up of a node.
    pub fn restarted(&mut self) {
        self.accepted = None;
    }

    /// Forgets everything after lost frames.
    pub fn lost(&mut self) {
        (self.accepted, self.silence) = (None, None);
    }

    /// Takes the activation of the bit timing; returns true if one was accepted.
    pub fn activate(&mut self, delay: u16, cx: &mut Context<'_>) -> bool {
        let Some(Accepted { at, rate, .. }) = self.accepted.take() else { return false };
        cx.push(Some(at), None, What::Note(Note::BitTimingActivated { delay, rate }));
        let Some(now) = cx.at.t_ns else { return true };
        let delay_ns = Ns::from_ms(delay.into());
        // Tolerance at either end for frames on their way and differing clocks.
        let grace = cx.evidence.recording.lag_ns().max(delay_ns / 10);
        let (from_ns, to_ns) = (now + grace, now + (2 * delay_ns - grace));
        self.silence = (from_ns < to_ns).then_some(Silence { at: cx.at, from_ns, to_ns, delay_ns });
        true
    }

    /// Judges a frame during the silence. Error frames belong to a change of the bit rate.
    pub fn heard(&mut self, now_ns: Ns, findings: &mut Withheld, cx: &mut Context<'_>) {
        let Some(silence) = self.silence.take_if(|silence| silence.from_ns <= now_ns) else { return };
        if now_ns >= silence.to_ns {
            return;
        }
        let own = cx.events.first().filter(|event| event.at == cx.at);
        match own.map(|Event { what, .. }| what) {
            None | Some(What::Message(Message::ErrorFrame)) => self.silence = Some(silence),
            Some(_) => {
                let elapsed = now_ns - silence.at.t_ns.unwrap_or(now_ns);
                let what = Lss008::Frame { elapsed, silence: silence.delay_ns * 2 };
                findings.raise(what, None, Some(silence.at), cx);
            }
        }
    }

    /// Reports a bit timing that should be activated, or at least stored, by `now_ns`.
    pub fn advance(&mut self, now_ns: Ns, findings: &mut Withheld, cx: &mut Context<'_>) {
        let overdue = |accepted: &mut Accepted| accepted.until_ns.is_some_and(|until| until <= now_ns);
        if let Some(Accepted { at, stored: false, .. }) = self.accepted.take_if(overdue) {
            findings.raise_timed(Code::Lss006, None, Some(at), cx);
        }
    }

    /// Returns the time of the next deadline, in ns.
    pub fn due(&self) -> Option<Ns> {
        let silence = self.silence.as_ref().map(|silence| silence.from_ns);
        self.accepted.as_ref().and_then(|accepted| accepted.until_ns).into_iter().chain(silence).min()
    }
}
