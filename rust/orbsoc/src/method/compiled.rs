//! The arithmetics that other crates run: this crate compiles their stages, once.

use crate::method::datapath::Datapath;
use crate::method::stage::Stage;
use crate::real::Decide;

/// An arithmetic that an [`Engine`](crate::Engine) may run in.
///
/// Its methods are not generic. A generic one would be compiled again in each crate that names an engine, and all stages
/// with it: minutes each time.
pub trait Compiled: Decide {
    /// [`Datapath::execute`].
    #[doc(hidden)]
    fn execute(path: &mut Datapath<Self>, stage: Stage);

    /// [`Datapath::execute_as_needed`].
    #[doc(hidden)]
    fn execute_as_needed(path: &mut Datapath<Self>, stage: Stage, needs_residual: bool);

    /// [`Datapath::factorize_watched`].
    #[doc(hidden)]
    fn factorize_watched(path: &mut Datapath<Self>, stop: &mut dyn FnMut() -> bool);
}

macro_rules! compiled {
    ($($t:ty),*) => {$(
        impl Compiled for $t {
            fn execute(path: &mut Datapath<Self>, stage: Stage) {
                path.execute(stage);
            }

            fn execute_as_needed(path: &mut Datapath<Self>, stage: Stage, needs_residual: bool) {
                path.execute_as_needed(stage, needs_residual);
            }

            fn factorize_watched(path: &mut Datapath<Self>, stop: &mut dyn FnMut() -> bool) {
                path.factorize_watched(stop);
            }
        }
    )*};
}

compiled!(f64);
#[cfg(feature = "datapaths")]
compiled!(f32);
