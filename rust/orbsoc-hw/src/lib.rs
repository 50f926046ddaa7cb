//! From the operation stream of a sparsity pattern to the exact cycles of the programmable logic.
//!
//! ```text
//! Tape ─ stream ─ schedule ─┬─ cycles, utilisation, causes        docs/pl-machine.md is the engine
//!        (graph, layout)    └─ microcode ─ program ─ replay ≡ RTL
//! ```
#![allow(clippy::cast_possible_truncation)] // cycles, nodes and addresses of a segment fit 32 bits

mod error;
mod machine;
mod microcode;
mod program;
mod replay;
mod schedule;
mod stream;

pub use error::Error;
pub use machine::arithmetic::compute;
pub use machine::configuration::Configuration;
pub use machine::operation::Code;
pub use machine::timing::{Precision, Timing};
pub use microcode::compressed::{decompress, Compressed, CompressedSegment, Demand};
pub use microcode::flat::{decode, flat, Microcode};
pub use microcode::streamed::Streaming;
pub use program::{Program, Segment};
pub use replay::image::Image;
pub use replay::in_order::{run_in_order, Dynamic, Gaps};
pub use replay::machine::{Fault, Machine, Rule, Violation};
pub use replay::snapshots::{snapshots, Snapshots};
pub use replay::validation::{validation_case, Entry, Format};
pub use schedule::bounds::Bounds;
pub use schedule::causes::Causes;
pub use schedule::scheduler::{schedule, Aim, Issue, Schedule};
pub use stream::graph::{Graph, Node, Operand};
pub use stream::interleaved::interleaved;
pub use stream::layout::Layout;
