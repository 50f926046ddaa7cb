//! The solver through its public interface.

mod closed_forms;
mod engine;
mod errors;
mod known;
mod limits;
mod operation_counts;
mod single_precision;
mod statuses;
mod warm_start;
