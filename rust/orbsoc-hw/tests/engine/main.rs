//! Schedules, microcode and machine together.

mod laws;
mod problem;
mod refusals;
