//! The time from each frame of a stream to the next.

use crate::bytes::ns::Ns;

/// The stamp of the last frame of a stream.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gaps {
    last_ns: Option<Ns>,
}

impl Gaps {
    /// Takes the stamp of the next frame, in ns. Returns the time since the one before, which is not negative; `None`
    /// for the first frame, without a stamp, and if the clock went back.
    #[inline]
    pub fn take(&mut self, t_ns: Option<Ns>) -> Option<Ns> {
        let before = std::mem::replace(&mut self.last_ns, t_ns)?;
        let now = t_ns?;
        (now >= before).then(|| now - before)
    }

    /// Separates the frames to come from those before, since some may be missing.
    pub fn interrupt(&mut self) {
        self.last_ns = None;
    }
}
