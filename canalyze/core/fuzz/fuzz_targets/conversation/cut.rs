//! What is left of a capture: cuts of it, as people paste them.
//!
//! It must not change a frame: only leave some out, or list them in another order.

use super::{Input, Sent};
use std::fmt::Write;

/// What is left of a capture.
#[derive(Clone, Debug)]
pub struct Excerpt {
    pub frames: Vec<Sent>,
    /// Announced holes: how many frames come before, and how many frames are missing.
    pub lost: Vec<(usize, usize)>,
    pub stamped: bool,
    /// Frames are missing in its midst, and nothing says so.
    pub unannounced: bool,
    late: bool,
    /// The cuts, in words.
    pub cuts: Vec<&'static str>,
}

impl Excerpt {
    pub fn whole(frames: Vec<Sent>) -> Self {
        Self { frames, lost: Vec::new(), stamped: true, unannounced: false, late: false, cuts: Vec::new() }
    }

    /// Whether client frames are listed late, or may be as nothing shows when they came.
    pub fn is_late(&self) -> bool {
        self.late || !self.stamped
    }

    /// As a candump log, or without stamps as on a console.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (place, frame) in self.frames.iter().enumerate() {
            self.announce(place, &mut text);
            let hex =
                |between: &str| frame.data.iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(between);
            let _ = if self.stamped {
                let micros = frame.t_ns / 1_000;
                writeln!(
                    text,
                    "({}.{:06}) can0 {:03X}#{}",
                    1_700_000_000 + micros / 1_000_000,
                    micros % 1_000_000,
                    frame.id,
                    hex("")
                )
            } else {
                writeln!(text, "  can0  {:03X}   [{}]  {}", frame.id, frame.data.len(), hex(" "))
            };
        }
        self.announce(self.frames.len(), &mut text);
        text
    }

    fn announce(&self, place: usize, text: &mut String) {
        if !self.stamped {
            return;
        }
        for (number, (_, count)) in self.lost.iter().enumerate().filter(|(_, (at, _))| *at == place) {
            let total: usize = self.lost.iter().take(number + 1).map(|(_, count)| count).sum();
            let _ = writeln!(text, "DROPCOUNT: dropped {count} CAN frames on 'can0' socket (total drops {total})");
        }
    }

    fn keep(&mut self, kept: impl Fn(usize, &Sent) -> bool) {
        let mut at = 0;
        let mut before = vec![0; self.frames.len() + 1];
        let frames = std::mem::take(&mut self.frames);
        for (place, frame) in frames.into_iter().enumerate() {
            before[place] = at;
            if kept(place, &frame) {
                self.frames.push(frame);
                at += 1;
            }
        }
        if let Some(last) = before.last_mut() {
            *last = at;
        }
        self.lost.iter_mut().for_each(|(place, _)| *place = before[*place]);
    }

    fn drop_piece(&mut self, input: &mut Input<'_>, announced: bool) {
        if self.frames.len() < 2 {
            return;
        }
        let count = usize::from(input.one_of(&[1_u8, 2, 3, 5, 20, 100])).min(self.frames.len() - 1);
        let first = input.below(self.frames.len() - count + 1);
        self.keep(|place, _| !(first..first + count).contains(&place));
        if announced {
            let at = self.lost.iter().take_while(|(place, _)| *place <= first).count();
            self.lost.insert(at, (first, count));
        } else {
            self.unannounced |= first > 0 && first < self.frames.len();
        }
    }

    /// Client frames are listed late, behind one or two server frames of their node.
    fn list_late(&mut self, input: &mut Input<'_>) {
        let stamps: Vec<i64> = self.frames.iter().map(|frame| frame.t_ns).collect();
        let mut moved = 0;
        for place in 1..self.frames.len() {
            if self.lost.iter().any(|(at, _)| *at == place) {
                moved = 0;
                continue;
            }
            let [before, now] = &mut self.frames[place - 1..=place] else { continue };
            let late = before.is_client() && now.id + 0x80 == before.id && moved < 2 && input.byte() & 1 == 0;
            moved = if late { moved + 1 } else { 0 };
            if late {
                std::mem::swap(before, now);
            }
        }
        self.frames.iter_mut().zip(stamps).for_each(|(frame, t_ns)| frame.t_ns = t_ns);
        self.late = true;
    }

    /// Cuts once.
    pub fn cut(&mut self, input: &mut Input<'_>) {
        if self.frames.is_empty() {
            return;
        }
        let count = self.frames.len();
        let name = match input.byte() % 9 {
            0 => {
                let first = input.below(count);
                self.keep(|place, _| place >= first);
                "beginning"
            }
            1 => {
                let end = 1 + input.below(count);
                self.keep(|place, _| place < end);
                "end"
            }
            2 => {
                let first = input.below(count);
                let end = first + 1 + input.below(100);
                self.keep(|place, _| (first..end).contains(&place));
                "window"
            }
            3 => {
                let base = input.one_of(&[0x580, 0x600]);
                self.keep(|_, frame| frame.id & 0x780 != base);
                "one direction"
            }
            4 => {
                let one = self.frames[input.below(count)].id;
                self.keep(|_, frame| frame.id == one);
                "one identifier"
            }
            5 if !self.late => {
                self.list_late(input);
                "client late"
            }
            5 | 6 => {
                self.drop_piece(input, true);
                "announced"
            }
            7 => {
                self.stamped = false;
                "without stamps"
            }
            _ => {
                self.drop_piece(input, false);
                "unannounced"
            }
        };
        self.cuts.push(name);
        self.unannounced |= !self.stamped && self.lost.iter().any(|(place, _)| *place > 0);
    }
}
