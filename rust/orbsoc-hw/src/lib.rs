//! From the operation stream of a sparsity pattern to the cycles of the programmable logic, exactly.
//!
//! ```text
//! Tape ─ graph ─ schedule ─┬─ cycles, utilisation, causes        docs/pl-machine.md is the engine
//!  layout ─────────────────┴─ microcode ─ machine (replay) ≡ RTL
//! ```
#![allow(clippy::cast_possible_truncation)] // cycles, nodes and addresses of a segment fit 32 bits

mod arithmetic;
mod bounds;
mod by_cycle;
mod calendar;
mod causes;
mod code;
mod compact;
mod compressed;
mod configuration;
mod edges;
mod encoder;
mod error;
mod graph;
mod image;
mod in_order;
mod intervals;
mod layout;
mod machine;
mod microcode;
mod placement;
mod program;
mod ready;
mod reservation;
mod rows;
mod schedule;
mod snapshots;
mod template;
mod timing;
mod urgency;
mod validation;
mod vectors;

pub use arithmetic::compute;
pub use bounds::Bounds;
pub use causes::Causes;
pub use code::Code;
pub use compressed::{decompress, Compressed, CompressedSegment};
pub use configuration::Configuration;
pub use error::Error;
pub use graph::{Graph, Node, Operand};
pub use image::Image;
pub use in_order::{run_in_order, Dynamic, Gaps};
pub use layout::Layout;
pub use machine::{Fault, Machine, Rule, Violation};
pub use microcode::{decode, flat, Microcode};
pub use program::{Program, Segment};
pub use schedule::{schedule, Aim, Issue, Schedule};
pub use snapshots::{snapshots, Snapshot, Snapshots};
pub use timing::{Precision, Timing};
pub use validation::{validation_case, Entry, Format};
