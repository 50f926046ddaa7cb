//! The operation stream of a pattern: dataflow graph, storage layout, dependence edges, operation chains.

pub(crate) mod chains;
pub(crate) mod edges;
pub(crate) mod graph;
pub(crate) mod interleaved;
pub(crate) mod layout;
mod node;
mod products;
