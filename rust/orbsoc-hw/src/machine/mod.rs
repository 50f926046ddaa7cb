//! The engine: its operations, their arithmetic and latencies, and the parameters of one instance.

pub(crate) mod arithmetic;
pub(crate) mod configuration;
pub(crate) mod identity;
pub(crate) mod operation;
pub(crate) mod timing;
