//! The work queue of a batch: threads fetch problems there and submit solutions, and the observer sees its progress.

use crate::outcome::solution::Solution;
use crate::problem::Problem;
use core::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::Mutex;

/// How far a batch is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchProgress {
    /// Problems that have ended, whatever their status.
    pub ended: usize,
    /// Problems of the batch.
    pub count: usize,
}

pub(crate) struct BatchQueue {
    next: AtomicUsize,
    ended: AtomicUsize,
    /// No more problems are handed out, and those under way are to stop.
    closed: AtomicBool,
    solved: Mutex<Vec<Option<Solution>>>,
    count: usize,
}

impl BatchQueue {
    pub fn new(count: usize) -> Self {
        let [next, ended] = [0, 0].map(AtomicUsize::new);
        Self { next, ended, closed: AtomicBool::new(false), solved: Mutex::new(vec![None; count]), count }
    }

    pub fn empty(&self) -> bool {
        self.flow().is_break() || self.next.load(Ordering::Relaxed) >= self.count
    }

    pub fn next(&self) -> Option<usize> {
        let fetch = || self.next.fetch_add(1, Ordering::Relaxed);
        (!self.empty()).then(fetch).filter(|&k| k < self.count)
    }

    pub fn submit(&self, k: usize, solution: Solution) {
        self.ended.fetch_add(1, Ordering::Relaxed);
        if let Ok(mut solved) = self.solved.lock() {
            solved[k] = Some(solution);
        }
    }

    /// Whether to go on.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.closed.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Show the observer how far the batch is; asked only until its answer is to stop.
    pub fn show(&self, observe: &mut impl FnMut(&BatchProgress) -> ControlFlow<()>) -> ControlFlow<()> {
        let progress = BatchProgress { ended: self.ended.load(Ordering::Relaxed), count: self.count };
        if self.flow().is_continue() && observe(&progress).is_break() {
            self.close();
        }
        self.flow()
    }

    pub fn close(&self) {
        self.closed.store(true, Ordering::Relaxed);
    }

    /// One for each problem.
    pub fn solutions(self, base: &Problem) -> Vec<Solution> {
        let solved = self.solved.into_inner().unwrap_or_default();
        solved.into_iter().map(|s| s.unwrap_or_else(|| Solution::not_begun(base))).collect()
    }
}
