//! Motion about an oblate Earth with drag: coasts through given times with velocity changes, their transition matrices,
//! and finite burns. SI, Earth-centred inertial axes, z along the pole; a state is [position, velocity].
//!
//! | module | what |
//! |---|---|
//! | `field` | accelerations and their Jacobians; the air in exponential layers; thrust |
//! | `extrapolation` | one step by the extrapolated midpoint rule (Gragg, Bulirsch, Stoer) |
//! | `coast` | steps through times, borders of air layers as events |
//!
//! Constants come from the caller: the Python package `orbsoc.orbit` has them with their sources.

mod coast;
mod extrapolation;
mod field;

pub use coast::{burn, coast, Coast, Error};
pub use field::{Field, Layer, Thrust};
