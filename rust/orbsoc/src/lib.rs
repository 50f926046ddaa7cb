//! **orbsoc** solves
//!
//! ```text
//! min ½xᵀPx + cᵀx   s.t.   Ax = b,   Gx + s = h,   s ∈ R₊ˡ × Q^{q₁} × … × Q^{q_k}
//! ```
//!
//! by a primal–dual interior-point method on the homogeneous embedding, with Nesterov–Todd scaling,
//! Mehrotra's predictor–corrector, and one LDLᵀ factorisation of the quasi-definite KKT matrix per
//! iteration on a static elimination walk.
//!
//! The method in one page is [`stage`]: two constant lists of stages and a dataflow table.
//! [`Engine::run`] is the only door to the arithmetic; [`Engine::solve`] walks the lists, and so may
//! anybody else, with the same bits. The arithmetic is one source for every datapath ([`real`]).
//!
//! | to read about | see |
//! |---|---|
//! | the user's problem, what comes back | [`Problem`], [`Solution`], [`Settings`], `convexity` |
//! | KKT pattern, order, elimination tree, supernodes | `kkt`, `order`, `elimination`, `symbolic` |
//! | the six modules' kernels | `kernels::{matrix_update, matrix_scaling, factorization, linear_solve, cone_ops, line_search}` |
//! | statistics and decisions | `ps`, `control` |
//! | the evidence for a status | `certificate` |
//! | the operation streams of a pattern | [`record_tapes`] |

mod accuracy;
mod batch;
mod beside;
mod certificate;
mod cones;
mod control;
#[cfg(test)]
mod control_tests;
mod convexity;
mod crew;
mod csc;
#[cfg(test)]
mod dataflow_tests;
mod datapath;
mod desk;
mod doubt;
mod elimination;
mod engine;
mod error;
mod execute;
#[cfg(test)]
mod factor_tests;
mod indices;
mod kernels;
mod kkt;
mod mixed;
#[cfg(test)]
mod newton_tests;
#[cfg(test)]
mod oracle;
mod order;
mod problem;
mod ps;
pub mod real;
mod rows;
mod seats;
mod settings;
mod solution;
pub mod stage;
#[cfg(test)]
mod stage_tests;
mod stretch;
mod structure;
mod sums;
mod supernode;
mod symbolic;
mod tape;
#[cfg(test)]
mod tape_tests;
mod trace;
mod upper;
mod warm_start;
mod workspace;

pub use batch::{solve_batch, solve_batch_from, BatchSolver};
pub use cones::Cones;
pub use convexity::check_convex;
pub use csc::Csc;
pub use desk::BatchProgress;
pub use engine::{operation_counts, Engine, Progress};
pub use error::Error;
pub use mixed::{MixedEngine, Narrow};
pub use problem::Problem;
pub use real::{Decide, Real};
pub use settings::Settings;
pub use solution::{Certificate, Solution, Status, WarmStart};
pub use stage::{Module, Outcome, Stage, Step, Stop, CLOSING, ITERATION, STARTUP, WARM_STARTUP};
pub use tape::{record_tapes, word_of, Recording, Store, Tape};
pub use trace::Event;
pub use warm_start::Start;
pub use workspace::Buffer;

/// Solve a problem in double precision.
///
/// # Errors
/// As [`Engine::new`]; not converging is a [`Status`].
pub fn solve(problem: &Problem, settings: &Settings) -> Result<Solution, Error> {
    Ok(Engine::<f64>::new(problem, settings)?.solve())
}
