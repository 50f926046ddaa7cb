//! Static scheduling: every operation gets its cycle, its unit and its addresses.

pub(crate) mod bounds;
pub(crate) mod causes;
pub(crate) mod cycle_driven;
pub(crate) mod event_queue;
pub(crate) mod exports;
pub(crate) mod intervals;
pub(crate) mod placement;
pub(crate) mod priority;
pub(crate) mod reads;
pub(crate) mod ready;
pub(crate) mod registers;
pub(crate) mod reservation;
pub(crate) mod scheduler;
