//! Microcode of a schedule, flat and compressed, and the schedules that compress well.

pub(crate) mod compact;
pub(crate) mod compressed;
pub(crate) mod encoder;
pub(crate) mod flat;
pub(crate) mod streamed;
pub(crate) mod template;
