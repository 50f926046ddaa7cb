//! Scalars the kernels are generic over. **The datapath is a type**: one kernel source runs on
//! `f64`, on `f32`, on [`Lanes`], eight problems at once, on [`Counted`], which carries no number and counts the operations,
//! and on `Taped`, which records them.
//!
//! The bits of a result are defined by the operations a kernel asks for and nothing else: every
//! operation below rounds once, `c ± a·b` rounds twice, and nothing here is ever fused.

mod counted;
mod ieee;
mod lanes;
mod narrow;
#[cfg(target_arch = "aarch64")]
mod neon;
mod outline;
mod scalar;
mod taped;
pub mod tiles;

pub use counted::{count, Counted, Latency, OperationCounts, Tally};
pub use lanes::{EightLanes, Lanes};
pub use narrow::Reduced;
pub(crate) use outline::{outline, Outlined};
pub use scalar::{Decide, Real};
pub(crate) use taped::{record, Taped};
pub use taped::{Opcode, Operation, Value};
