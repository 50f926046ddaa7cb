//! The engine in Rust: replay of schedules, validation cases and images for the RTL.

pub(crate) mod copies;
pub(crate) mod image;
pub(crate) mod in_order;
pub(crate) mod machine;
pub(crate) mod snapshots;
pub(crate) mod validation;
