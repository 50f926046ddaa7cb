//! Tests across packages, and the reference implementations that all unit tests compare with.

mod batch;
mod control;
mod dataflow;
mod decisions;
mod factorization;
mod newton;
mod observer;
pub(crate) mod reference;
mod solution;
mod stage;
mod tape;
