//! The iteration as data, its buffers, its decisions, and the engine that runs it.

pub(crate) mod compiled;
pub(crate) mod control;
#[cfg(feature = "datapaths")]
pub(crate) mod counts;
pub(crate) mod datapath;
pub(crate) mod dispatch;
pub(crate) mod engine;
pub(crate) mod events;
#[cfg(feature = "datapaths")]
pub(crate) mod mixed;
pub(crate) mod observer;
pub(crate) mod radius_scale;
pub(crate) mod restart;
pub mod stage;
pub(crate) mod tables;
#[cfg(feature = "datapaths")]
pub(crate) mod tape;
pub(crate) mod warm_start;
pub(crate) mod workspace;
