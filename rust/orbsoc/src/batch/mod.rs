//! Many problems of one pattern: SIMD lanes, threads, a work queue.

pub(crate) mod queue;
pub(crate) mod slots;
pub(crate) mod solver;
pub(crate) mod worker;
