//! Everything behind the reader: frames in their order, what they mean, and what is written of them.
//!
//! Must not: know of files or their formats.

use super::ahead::{Ahead, Behind, Placed};
use super::capture::{Capture, Origin};
use super::decoding::Decoding;
use super::judged::{Judged, JudgedFrame};
use super::sink::{CHANGES, ITEMS, Notice};
use super::sinks::Sinks;
use super::tally::Tally;
use crate::bytes::frame::{BusId, Buses, Frame, FrameRef};
use crate::bytes::info::Info;
use crate::bytes::ns::Ns;
use crate::bytes::readers::{Contents, Damage, Item, Marker};
use crate::evidence::order::Order;
use crate::evidence::recording::RecordedFrame;
use crate::rules::capture::{Cap006, Cap007, Cap009};
use crate::rules::finding::{Code, Finding};
use crate::tables::jsonl;

/// Everything behind the reader.
#[derive(Debug)]
pub(super) struct Stream {
    pub(super) capture: Capture,
    /// Frames that wait for those that are listed late.
    pub(super) order: Order<Origin>,
    /// Frames that wait until it is known what the recording did with them.
    pub(super) ahead: Ahead,
    pub(super) decoding: Decoding,
    /// Frames that were judged before others that the capture lists first.
    pub(super) judged: Judged,
    pub(super) sinks: Sinks,
    pub(super) tally: Tally,
}

impl Stream {
    pub(super) fn item(&mut self, item: &mut Item, buses: &Buses, out: &mut Vec<u8>) {
        if self.sinks.is_done() {
            return;
        }
        if self.sinks.want(ITEMS) {
            if let Item::Frame(frame) = item {
                self.capture.count(frame);
            }
            return self.sinks.find_mut::<Info>().into_iter().for_each(|info| info.take(item));
        }
        if !matches!(item, Item::Frame(_) | Item::Unreadable { .. } | Item::Until { .. }) {
            self.settle(false, buses, out);
            if self.sinks.is_done() {
                return;
            }
        }
        match *item {
            Item::Frame(ref mut frame) => self.place(frame, buses, out),
            Item::Marker(marker) => self.marker(marker, buses, out),
            Item::Unreadable { place, reason } => self.capture.unreadable(place, reason),
            Item::Damaged(damage) => self.damaged(damage, buses, out),
            Item::Gap { bus, away } => self.gap((bus, away), buses, out),
            Item::Until { now_ns } => self.until(now_ns, buses, out),
        }
    }

    /// Returns true if the output may be written later, by another thread.
    pub(super) fn defers(&self) -> bool {
        self.sinks.defers() && !self.decoding.extract
    }

    /// Gives a frame its place in the capture and in the recording, and hands on what is known by that.
    #[inline]
    pub(super) fn place(&mut self, frame: &mut Frame, buses: &Buses, out: &mut Vec<u8>) {
        // Nobody may have recorded between two files: a silence there that is longer than usual is nobody's fault.
        let apart = self.capture.place(frame);
        if self.capture.begins_file() {
            self.arrange(true, buses, out);
            if apart || self.decoding.is_unusual_silence(frame) {
                self.part(buses, out);
            }
        }
        self.capture.follow(frame);
        if self.decoding.is_blind() || self.order.passes(frame) {
            return self.observe(frame, None, buses, out);
        }
        self.order.hold(frame, self.capture.before(frame.bus), self.capture.origin());
        self.arrange(false, buses, out);
    }

    /// Hands on the frames before which no frame follows that is listed late. `over`: none follows at all.
    #[inline]
    fn arrange(&mut self, over: bool, buses: &Buses, out: &mut Vec<u8>) {
        if !self.order.is_empty() {
            self.hand_on(over, buses, out);
        }
    }

    /// Does the same where frames wait.
    #[cold]
    fn hand_on(&mut self, over: bool, buses: &Buses, out: &mut Vec<u8>) {
        while !self.sinks.is_done()
            && let Some((frame, before, origin)) = self.order.next(over)
        {
            self.observe(&frame, Some((before, origin)), buses, out);
        }
        self.capture.caught_up();
    }

    /// Gives a frame its place in the recording. `held`: the frame before it on its bus and its file, where it was held
    /// back.
    #[inline(always)]
    fn observe(&mut self, frame: &Frame, held: Option<(Option<FrameRef>, Origin)>, buses: &Buses, out: &mut Vec<u8>) {
        let seen = self.decoding.observe(frame, buses);
        if self.ahead.is_empty() && self.decoding.is_decided() && !self.decoding.is_ambiguous(frame) {
            if self.ends_before(frame, buses, out) {
                return;
            }
            let (before, origin) = held.unzip();
            self.capture.take(frame, origin);
            return self.frame(frame, (before, None), seen.as_ref(), buses, out);
        }
        let (before, origin) = held.unwrap_or_else(|| (self.capture.before(frame.bus), self.capture.origin()));
        self.ahead.hold(Placed { frame: *frame, before, seen }, origin);
        self.release(false, buses, out);
    }

    /// Returns true if nothing further is taken, since the capture ends before a frame.
    fn ends_before(&mut self, frame: &Frame, buses: &Buses, out: &mut Vec<u8>) -> bool {
        let ends = self.sinks.ends_before(frame.t_ns, self.capture.start_ns());
        if ends {
            self.write_judged(true, buses, out);
        }
        ends
    }

    /// A file begins that does not go on where the one before ended: across that time nothing is judged on any bus.
    #[cold]
    fn part(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        self.settle(false, buses, out);
        for index in 0..buses.names().count() {
            self.sinks.take(out, &self.capture.view(buses), Notice::Gap(BusId(index as u8), false));
        }
        self.decoding.all_lost(self.capture.last, buses);
        self.aside(buses, out);
    }

    /// Hands on the frames of which it is known what the recording did with them, and what comes next on their SDO
    /// channel where that matters. `over`: nothing more comes.
    pub(super) fn release(&mut self, over: bool, buses: &Buses, out: &mut Vec<u8>) {
        let before = self.decoding.undecided_since().unwrap_or(u64::MAX);
        while let Some(first) = self.ahead.first_before(before) {
            let next = match self.decoding.is_ambiguous(first) {
                true => self.ahead.next(|one, other| self.decoding.is_of_channel(one, other)),
                false => Behind::None,
            };
            let next = match next {
                Behind::Frame(next) => Some(next),
                Behind::Open if !over => break,
                Behind::Open | Behind::None => None,
            };
            let Some((Placed { frame, before, seen }, origin)) = self.ahead.take() else { break };
            if !self.sinks.is_done() && !self.ends_before(&frame, buses, out) {
                self.capture.take(&frame, Some(origin));
                self.frame(&frame, (Some(before), next.as_deref()), seen.as_ref(), buses, out);
            }
        }
        self.capture.caught_up();
    }

    /// Nothing is behind the frames that wait by which more would be known: they are taken by what is. `over`: nothing
    /// will follow.
    pub(super) fn settle(&mut self, over: bool, buses: &Buses, out: &mut Vec<u8>) {
        self.arrange(true, buses, out);
        self.decoding.settle(over);
        self.release(true, buses, out);
    }

    /// Judges and writes a frame. `held`: the frame before it on its bus, if any, where it was held back; otherwise the
    /// capture has that one. `next`: the next one of its SDO channel, where it was read ahead.
    pub(super) fn frame(
        &mut self,
        frame: &Frame,
        (held, next): (Option<Option<FrameRef>>, Option<&Frame>),
        seen: Option<&RecordedFrame>,
        buses: &Buses,
        out: &mut Vec<u8>,
    ) {
        let holed = self.decoding.is_behind_hole(frame);
        let stepped = seen.is_some_and(RecordedFrame::is_behind_step);
        let before = if holed || stepped { held.unwrap_or_else(|| self.capture.before(frame.bus)) } else { None };
        if holed && let Some(before) = before {
            self.sinks.take(out, &self.capture.view(buses), Notice::Gap(frame.bus, false));
            self.decoding.lost((frame.bus, true), before, buses);
            self.aside(buses, out);
        }
        let judged = self.decoding.judged(frame, seen);
        let judged = judged.as_ref().unwrap_or(frame);
        self.decoding.step(judged, seen, next, buses);
        if (holed || stepped)
            && let Some((before, apart)) = before.and_then(|before| Some((before, frame.reference().since(before)?)))
        {
            if holed {
                self.decoding.find(judged, Cap007::Silent { silence: apart }.into(), Some(before));
            }
            if stepped {
                self.decoding.find(judged, Cap006::Back { back: -apart }.into(), Some(before));
            }
        }
        if let Some((missing, due)) = self.decoding.losses_shown_at(frame) {
            self.decoding.find(judged, Cap009::Single { missing, due }.into(), None);
        }
        self.decoding.diagnosed(judged);
        let sync = if self.sinks.has_beside() { self.decoding.sync(frame.bus) } else { (0, None) };
        if !frame.is_relisted() && self.judged.is_empty() {
            return self.write(frame, sync, buses, out);
        }
        let events = std::mem::take(&mut self.decoding.events);
        self.judged.hold(frame.no, JudgedFrame { frame: frame.listed(), events, sync, origin: self.capture.of_held() });
        self.write_judged(false, buses, out);
    }

    /// Writes the frames that were judged before others, once those are written. `over`: no others follow.
    #[cold]
    fn write_judged(&mut self, over: bool, buses: &Buses, out: &mut Vec<u8>) {
        while !self.sinks.has_enough()
            && let Some(JudgedFrame { frame, events, sync, origin }) = self.judged.next(over)
        {
            self.decoding.events = events;
            self.capture.show(&frame, origin);
            self.write(&frame, sync, buses, out);
        }
    }

    /// Writes a frame with its events.
    #[inline(always)]
    fn write(&mut self, frame: &Frame, sync: (u64, Option<Ns>), buses: &Buses, out: &mut Vec<u8>) {
        self.decoding.restore();
        if self.sinks.has_beside() {
            self.sinks.frame_beside(&self.capture.view(buses), frame, &mut self.decoding.events, sync);
        }
        self.decoding.fold();
        self.tally.frame(frame, &self.decoding.events);
        self.sinks.frame(out, &self.capture.view(buses), frame, &mut self.decoding.events);
        self.tell(buses, out);
        self.decoding.clear(buses);
    }

    /// Tells of problems that begin to show, and of those that are over.
    #[inline]
    pub(super) fn tell(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        if self.sinks.want(CHANGES) {
            self.tell_changes(buses, out);
        }
    }

    #[inline(never)]
    fn tell_changes(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        for (phase, id) in self.decoding.changes() {
            if let Some(diagnosis) = self.decoding.diagnosis() {
                self.sinks.take(out, &self.capture.view(buses), Notice::Changed(diagnosis, (phase, id)));
            }
        }
    }

    pub(super) fn marker(&mut self, marker: Marker, buses: &Buses, out: &mut Vec<u8>) {
        self.sinks.take(out, &self.capture.view(buses), Notice::Marker(&marker));
        if let Marker::Start { date_ns } = marker {
            return self.capture.dated(date_ns);
        }
        if let Marker::Dropped { bus, count, .. } = marker {
            self.tally.dropped(bus, count);
            self.decoding.lost((bus, true), self.capture.last, buses);
        }
        if let Marker::LeftOut { .. } = marker {
            self.decoding.all_lost(self.capture.last, buses);
        }
        if let Marker::Error { bus, place, .. } = marker {
            let at = self.capture.behind(bus, place.line());
            self.decoding.bare_error(bus, at, buses);
        }
        let finding = self.capture.marker(&marker, buses);
        self.report(finding.as_ref(), buses, out);
        self.aside(buses, out);
    }

    /// A live bus is away: across the gap nothing is judged, and nothing is wrong.
    pub(super) fn gap(&mut self, (bus, away): (BusId, bool), buses: &Buses, out: &mut Vec<u8>) {
        self.sinks.take(out, &self.capture.view(buses), Notice::Gap(bus, away));
        self.capture.gap();
        self.decoding.lost((bus, false), self.capture.last, buses);
        self.aside(buses, out);
    }

    /// Live buses have given all until `now_ns`.
    pub(super) fn until(&mut self, now_ns: Ns, buses: &Buses, out: &mut Vec<u8>) {
        self.arrange(true, buses, out);
        self.advance(now_ns, buses, out);
        self.sinks.take(out, &self.capture.view(buses), Notice::Until(now_ns));
    }

    /// A part of the file is lost: across it nothing is judged on any bus.
    pub(super) fn damaged(&mut self, damage: Damage, buses: &Buses, out: &mut Vec<u8>) {
        let finding = self.capture.damaged(damage);
        if finding.code == Code::Cap004 {
            self.decoding.all_lost(self.capture.last, buses);
        }
        self.report(Some(&finding), buses, out);
        self.aside(buses, out);
    }

    pub(super) fn end_of_file(&mut self, contents: &Contents, buses: &Buses, out: &mut Vec<u8>) {
        self.capture.end_of_complaints();
        if let Some(info) = self.sinks.find::<Info>() {
            return jsonl::info(out, self.capture.view(buses).jsonl, info, contents);
        }
        self.arrange(true, buses, out);
        if self.capture.file.unreadable.count > 0 {
            self.settle(false, buses, out);
        }
        let (unreadable, finding) = self.capture.end();
        if self.capture.file.frames > 0 {
            self.sinks.take(out, &self.capture.view(buses), Notice::EndOfFile(unreadable.count));
        }
        self.report(finding.as_ref(), buses, out);
    }

    pub(super) fn advance(&mut self, now_ns: Ns, buses: &Buses, out: &mut Vec<u8>) {
        if self.sinks.is_done() {
            return;
        }
        self.order.pass(now_ns);
        self.arrange(false, buses, out);
        self.decoding.pass(now_ns);
        self.release(self.ahead.is_over(now_ns), buses, out);
        // What frames that wait have to say comes first.
        if self.ahead.is_empty() && self.order.is_empty() && !self.sinks.is_done() {
            self.decoding.advance(now_ns, self.capture.last, buses);
        }
        self.sinks.take(out, &self.capture.view(buses), Notice::Advance(now_ns));
        self.aside(buses, out);
    }

    pub(super) fn finish(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        self.settle(true, buses, out);
        self.decoding.finish(self.capture.last, buses);
        self.aside(buses, out);
        let diagnosed = self.decoding.finish_diagnosis(self.capture.last, buses);
        self.aside(buses, out);
        self.decoding.counted(self.capture.last);
        self.write_aside(buses, out);
        if let Some(diagnosis) = self.decoding.diagnosis().filter(|_| diagnosed) {
            self.sinks.take(out, &self.capture.view(buses), Notice::Diagnosis(diagnosis));
        }
        if self.capture.frames > 0 {
            let (idle, timeless) = (self.sinks.is_idle(), self.sinks.is_timeless());
            let beyond = self.sinks.beyond(self.capture.frames);
            self.capture.finish(self.decoding.absent(buses), idle, beyond, timeless);
            self.sinks.take(out, &self.capture.view(buses), Notice::Settle(self.decoding.buses()));
            self.sinks.take(out, &self.capture.view(buses), Notice::Finish(self.sinks.shown));
        }
        self.sinks.take(out, &self.capture.view(buses), Notice::Close);
    }

    pub(super) fn report(&mut self, finding: Option<&Finding>, buses: &Buses, out: &mut Vec<u8>) {
        if let Some(finding) = finding {
            self.tally.finding(finding);
            self.decoding.diagnosed_finding(finding);
            self.sinks.finding(out, &self.capture.view(buses), finding);
        }
    }

    /// Writes the events that belong to no frame at hand.
    pub(super) fn aside(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        self.decoding.diagnosed_aside();
        self.decoding.restore();
        self.sinks.asides_beside(&self.capture.view(buses), &self.decoding.events);
        self.decoding.fold();
        self.write_aside(buses, out);
    }

    /// The same of what is not only counted, but for tables.
    pub(super) fn write_aside(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        self.tally.events(&self.decoding.events);
        self.sinks.asides(out, &self.capture.view(buses), &self.decoding.events);
        self.tell(buses, out);
        self.decoding.clear(buses);
    }
}
