//! How many operations each stage asks for on a pattern.

use crate::error::Error;
use crate::kkt::structure::Structure;
use crate::method::{datapath::Datapath, stage::Stage, workspace::Workspace};
use crate::problem::{Problem, Settings};
use crate::real::{count, Counted, Latency, Real, Tally};
use crate::symbolic::supernodes::Panels;
use std::sync::Arc;

/// Operations of each stage on a problem's pattern, and their longest dependent chain.
///
/// # Errors
/// As [`crate::Engine::new`].
pub fn operation_counts(
    problem: &Problem,
    settings: &Settings,
    latency: Latency,
) -> Result<Vec<(Stage, Tally)>, Error> {
    let structure = Arc::new(Structure::new(problem, settings.ordering, Panels::Exact)?);
    let mut path = Datapath::<Counted>::new(structure, settings)?;
    let inputs_ready = Workspace::new(&path.structure, Counted::zero());
    let mut tally = |stage| {
        path.work.clone_from(&inputs_ready);
        (stage, count(latency, || path.execute(stage)))
    };
    Ok(Stage::ALL.iter().map(|&stage| tally(stage)).collect())
}
