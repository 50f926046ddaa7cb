//! Where the problem meets its pattern: sizes, cones, and the KKT matrix.

pub(crate) mod assembly;
pub(crate) mod known;
pub(crate) mod structure;
