//! Schedules, microcode and machine together.
#![allow(clippy::cast_possible_truncation)] // small engines

mod interleaved;
mod laws;
mod problem;
mod refusals;
