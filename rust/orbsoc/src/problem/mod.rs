//! The user's problem and settings, checked.

pub(crate) mod cones;
pub(crate) mod convexity;
pub(crate) mod csc;
#[allow(clippy::module_inception)] // the noun of the package
pub(crate) mod problem;
pub(crate) mod settings;

pub use cones::Cones;
pub use csc::Csc;
pub use problem::Problem;
pub use settings::Settings;
