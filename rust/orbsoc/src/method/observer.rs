//! What looks at a solve that runs, and may end it.

use crate::method::engine::Progress;
use core::ops::ControlFlow;

/// Asked by a running solve whether to go on; the solve ends with its best iterate.
pub trait Observer {
    /// After each iteration.
    fn iterated(&mut self, progress: &Progress) -> ControlFlow<()>;

    /// Every few milliseconds of a factorization that takes long.
    fn waited(&mut self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(&Progress) -> ControlFlow<()>> Observer for F {
    fn iterated(&mut self, progress: &Progress) -> ControlFlow<()> {
        self(progress)
    }
}
