//! What looks at a solve that runs, and may end it.

use core::ops::ControlFlow;

/// Where a solve stands.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Progress {
    pub iteration: u32,
    pub objective: f64,
    pub dual_objective: f64,
    pub primal_residual: f64,
    pub dual_residual: f64,
    pub gap: f64,
    pub mu: f64,
    /// Length of the step that led here; 0 before the first.
    pub step: f64,
    pub refinements: u32,
}

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
