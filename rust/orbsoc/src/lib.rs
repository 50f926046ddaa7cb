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
//! | to read about | see |
//! |---|---|
//! | the user's problem, what comes back | [`Problem`], [`Solution`], [`Settings`], `convexity` |
//! | KKT pattern, order, elimination tree, supernodes | `kkt`, `order`, `elimination`, `symbolic` |
//! | the six modules' kernels | `kernels::{matrix_update, matrix_scaling, factorization, linear_solve, cone_ops, line_search}` |
//! | statistics and decisions | `ps`, `control` |
//! | the evidence for a status | `certificate` |
//! | the operation streams of a pattern | [`record_tapes`] |

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

pub use batch::queue::BatchProgress;
pub use batch::solver::{solve_batch, solve_batch_from, BatchSolver};
pub use error::Error;
pub use method::engine::{operation_counts, Engine, Progress};
pub use method::events::Event;
pub use method::mixed::{MixedEngine, Narrow};
pub use method::restart::{Attempt, Restart, RESTARTS};
pub use method::stage;
pub use method::stage::{Module, Outcome, Stage, Step, CLOSING, ITERATION, STARTUP, WARM_STARTUP};
pub use method::tape::{record_tapes, word_of, Recording, Store, Tape};
pub use method::warm_start::Start;
pub use method::workspace::Buffer;
pub use outcome::solution::{Certificate, Solution, Status, WarmStart};
pub use outcome::verification::Stop;
pub use problem::convexity::check_convex;
pub use problem::{Cones, Csc, Problem, Settings};
pub use real::{Decide, Real};

/// Solve a problem in double precision.
///
/// # Errors
/// As [`Engine::new`]; not converging is a [`Status`].
pub fn solve(problem: &Problem, settings: &Settings) -> Result<Solution, Error> {
    Ok(Engine::<f64>::new(problem, settings)?.solve())
}
