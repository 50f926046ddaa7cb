//! Schedules for few bits of compressed microcode: results settle where neighbours of the kernel are neighbours in
//! storage, lanes keep to their runs, and a segment takes the way that costs it little time.

use super::compressed::Compressed;
use crate::error::Error;
use crate::schedule::cycle_driven::HABITS;
use crate::schedule::priority::Urgency;
use crate::schedule::scheduler::{Schedule, Scheduler};
use std::cell::OnceCell;

/// A segment may take this share longer than with flat microcode.
const SHARE: u32 = 20;

/// Schedule a graph for few bits, by the first habit that is hardly slower than a schedule of the fewest
/// cycles, decoding included; if none is, by the quickest. A walk is left where it is sure to become too long.
///
/// # Errors
/// [`Error::Storage`] when the temporaries do not fit.
pub(crate) fn compact(scheduler: &Scheduler<'_>, fast: &Schedule) -> Result<Schedule, Error> {
    let configuration = scheduler.configuration;
    let mut graph = scheduler.graph.clone();
    let settled = graph.settle(scheduler.layout.words(), configuration.words() as u32);
    let urgencies: [OnceCell<Urgency>; HABITS.len()] = Default::default();
    let urgency = |number: usize| match HABITS[number].nodes_per_cycle {
        None => scheduler.urgent(),
        Some(_) => urgencies[number].get_or_init(|| scheduler.urgency(HABITS[number])),
    };
    let made = |walk| -> Result<_, Error> {
        let schedule = scheduler.walked(walk, settled)?;
        Ok((Compressed::cycles(&schedule, configuration), schedule))
    };
    let limit = fast.cycles + fast.cycles / SHARE;
    // Of a schedule's cycles, those before its first word and after its last result.
    let around = configuration.timing().startup + configuration.timing().finish + 1;
    let (mut best, mut left): (Option<Quickest>, _) = (None, Vec::new());
    for (number, habit) in HABITS.into_iter().enumerate() {
        let mut walk = scheduler.walk(&graph, urgency(number), habit);
        if walk.run(limit.saturating_sub(around)) {
            let (cycles, schedule) = made(walk)?;
            if cycles <= limit {
                return Ok(schedule);
            }
            best = Some(quicker(best, Quickest { cycles, number, schedule }));
        } else {
            left.push((number, walk));
        }
    }
    for (number, mut walk) in left.into_iter().rev() {
        let most = best.as_ref().map_or(u32::MAX, |best| best.cycles - around);
        if walk.run(most) {
            let (cycles, schedule) = made(walk)?;
            best = Some(quicker(best, Quickest { cycles, number, schedule }));
        }
    }
    Ok(best.map_or_else(|| fast.clone(), |best| best.schedule))
}

/// A habit's schedule, when none is quick enough.
struct Quickest {
    cycles: u32,
    number: usize,
    schedule: Schedule,
}

/// The quicker one; of equally quick ones that of the earlier habit.
fn quicker(best: Option<Quickest>, other: Quickest) -> Quickest {
    let key = |of: &Quickest| (of.cycles, of.number);
    best.filter(|best| key(best) < key(&other)).unwrap_or(other)
}
