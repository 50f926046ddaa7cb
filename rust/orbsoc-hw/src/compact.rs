//! Schedules for few bits of compressed microcode: results settle where neighbours of the kernel are neighbours in
//! storage, lanes keep to their runs, and a segment takes the way that costs it little time.

use crate::by_cycle::Habit;
use crate::compressed::Compressed;
use crate::configuration::Configuration;
use crate::error::Error;
use crate::graph::Graph;
use crate::layout::Layout;
use crate::schedule::{Schedule, Scheduler};

/// From the fewest bits on, as a rule.
const HABITS: [Habit; 4] = [
    Habit { nodes_per_cycle: Some(2), patience: 0, apart: true },
    Habit { nodes_per_cycle: Some(8), patience: 1, apart: true },
    Habit { nodes_per_cycle: None, patience: 0, apart: true },
    Habit::URGENT,
];
/// A segment may take this share longer than with flat microcode.
const SHARE: u32 = 20;

/// Schedule a graph of a layout for few bits, by the first habit that is hardly slower than a schedule of the fewest
/// cycles, decoding included; if none is, by the quickest.
///
/// # Errors
/// [`Error::Storage`] when the temporaries do not fit.
pub(crate) fn compact(
    scheduler: &Scheduler<'_>,
    fast: &Schedule,
    graph: &Graph,
    layout: &Layout,
    configuration: &Configuration,
) -> Result<Schedule, Error> {
    let mut graph = graph.clone();
    let settled = graph.settle(layout.words(), configuration.words() as u32);
    let mut best: Option<(u32, Schedule)> = None;
    for habit in HABITS {
        let made = scheduler.in_runs(&graph, settled, habit)?;
        let cycles = Compressed::cycles(&made, configuration);
        if cycles <= fast.cycles + fast.cycles / SHARE {
            return Ok(made);
        }
        if best.as_ref().is_none_or(|(least, _)| cycles < *least) {
            best = Some((cycles, made));
        }
    }
    Ok(best.map_or_else(|| fast.clone(), |(_, made)| made))
}
