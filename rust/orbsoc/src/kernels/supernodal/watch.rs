//! Whether a long factorization is to be given up, asked between pieces of its work.

/// Asked between pieces of work.
pub trait Watch {
    /// Whether the work is cut into pieces at all.
    const LOOKS: bool;

    /// After `work` multiply–subtracts more: whether to give up.
    fn stops(&mut self, work: usize) -> bool;
}

/// Runs to its end in one piece.
pub struct Unwatched;

impl Watch for Unwatched {
    const LOOKS: bool = false;

    #[inline(always)]
    fn stops(&mut self, _: usize) -> bool {
        false
    }
}

/// Multiply–subtracts between two questions: a few milliseconds of them, and in tests few.
pub const PIECE: usize = if cfg!(test) { 1 << 6 } else { 1 << 24 };

/// Asks `stop` after each [`PIECE`]; what it has stopped stays so.
pub struct Watched<'a> {
    stop: &'a mut dyn FnMut() -> bool,
    /// Since the last question.
    work: usize,
    pub stopped: bool,
}

impl<'a> Watched<'a> {
    pub fn new(stop: &'a mut dyn FnMut() -> bool) -> Self {
        Self { stop, work: 0, stopped: false }
    }
}

impl Watch for Watched<'_> {
    const LOOKS: bool = true;

    fn stops(&mut self, work: usize) -> bool {
        self.work += work;
        if self.work >= PIECE && !self.stopped {
            self.work = 0;
            self.stopped = (self.stop)();
        }
        self.stopped
    }
}
