//! What ran, in order. Costs are computed from this and from operation counts, never from clocks.

use crate::method::stage::Stage;

/// One stage run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// The stage.
    pub stage: Stage,
    /// Interior-point iteration, 0 until the first step was taken.
    pub iteration: u32,
}
