//! **orbsoc** solves
//!
//! ```text
//! min ½xᵀPx + cᵀx   s.t.   Ax = b,   Gx + s = h,   s ∈ R₊ˡ × Q^{q₁} × … × Q^{q_k}
//! ```
//!
//! by a primal–dual interior-point method on the homogeneous embedding, with Nesterov–Todd scaling,
//! Mehrotra's predictor–corrector, and one LDLᵀ factorisation of the quasi-definite KKT matrix per
//! iteration on a static symbolic factorization.
//!
//! The method in one page is [`stage`]: two constant lists of stages and a dataflow table.
//! [`Engine::run`] is the only way to the arithmetic. [`Engine::solve`] runs the lists, and so may
//! any caller, with the same bits. The arithmetic is one source for every datapath ([`real`]).
//!
//! | package, each on those above it | what is in it |
//! |---|---|
//! | `symbolic` | a sparsity pattern's ordering, elimination tree, supernodes and scatter indices |
//! | `problem` | [`Problem`], [`Cones`], [`Settings`], checked; convexity |
//! | [`real`] | the scalars of the datapaths |
//! | `kkt` | sizes, cones and the KKT matrix's pattern |
//! | `kernels` | the arithmetic: one file per module of programmable logic, and the processing system's |
//! | `outcome` | [`Solution`], and its independent verification |
//! | `method` | stages, buffers, decisions, restarts, [`Engine`], [`record_tapes`] |
//! | `batch` | [`BatchSolver`] |
//!
//! Feature `datapaths`, a default: every datapath beside `f64`. Without it there is [`Engine`] on `f64` and nothing that needs another.

#![cfg_attr(not(feature = "datapaths"), allow(dead_code, unused_imports))] // what only the other datapaths reach

#[cfg(feature = "datapaths")]
mod batch;
mod error;
mod kernels;
mod kkt;
mod method;
mod outcome;
mod problem;
pub mod real;
mod symbolic;
#[cfg(test)]
mod tests;

#[cfg(feature = "datapaths")]
pub use batch::queue::BatchProgress;
#[cfg(feature = "datapaths")]
pub use batch::solver::{solve_batch, solve_batch_from, BatchSolver};
pub use error::Error;
pub use method::compiled::Compiled;
#[cfg(feature = "datapaths")]
pub use method::counts::operation_counts;
pub use method::engine::{factor_shape, Engine};
pub use method::events::Event;
#[cfg(feature = "datapaths")]
pub use method::mixed::{MixedEngine, Narrow};
pub use method::observer::{Observer, Progress};
pub use method::restart::{Attempt, Restart, RESTARTS};
pub use method::stage;
pub use method::stage::{Flag, Module, Outcome, Stage, Step, CLOSING, ITERATION, STARTUP, WARM_STARTUP};
pub use method::tables::{pattern_tables, PatternTables, SUPERNODE_KINDS};
#[cfg(feature = "datapaths")]
pub use method::tape::{record_tapes, word_of, Recording, Store, Tape};
pub use method::warm_start::Start;
pub use method::workspace::Buffer;
pub use outcome::solution::{Certificate, Solution, Status, WarmStart};
pub use outcome::verification::Stop;
pub use problem::convexity::check_convex;
pub use problem::{Cones, Csc, Problem, Settings};
pub use real::{Decide, Real};
pub use symbolic::ordering::{FactorShape, Ordering};

/// Solve a problem in double precision.
///
/// # Errors
/// As [`Engine::new`]; not converging is a [`Status`].
pub fn solve(problem: &Problem, settings: &Settings) -> Result<Solution, Error> {
    Ok(Engine::<f64>::new(problem, settings)?.solve())
}
