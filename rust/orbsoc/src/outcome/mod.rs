//! What a solve returns, and its independent verification on the user's data.

pub(crate) mod norms;
mod radius;
pub(crate) mod roundoff;
pub(crate) mod solution;
pub(crate) mod verification;
