//! Schedules for few bits of compressed microcode: temporaries get consecutive locations in kernel order, lanes keep to
//! their chains, and the first policy that costs little time is chosen.

use super::compressed::Compressed;
use crate::error::Error;
use crate::schedule::cycle_driven::SchedulingPolicy;
use crate::schedule::priority::Priorities;
use crate::schedule::scheduler::{Schedule, Scheduler};
use std::cell::OnceCell;

/// A compact schedule may take 1/`SLACK` longer than the fastest one.
const SLACK: u32 = 20;

/// Schedule a graph by the first policy whose cycles, decoding included, are within the slack; if there is none, by the
/// fastest, `fast` itself among them. A schedule is interrupted when it must exceed the limit.
///
/// # Errors
/// [`Error::Storage`] when the temporaries do not fit.
pub(crate) fn compact(scheduler: &Scheduler<'_>, fast: &Schedule) -> Result<Schedule, Error> {
    let configuration = scheduler.configuration;
    let mut graph = scheduler.graph.clone();
    let first_free = graph.assign_locations(scheduler.layout.words(), configuration.words() as u32);
    let weighted: [OnceCell<Priorities>; SchedulingPolicy::ALL.len()] = Default::default();
    let priorities = |number: usize| match SchedulingPolicy::ALL[number] {
        SchedulingPolicy { nodes_per_cycle: None, .. } => scheduler.critical_path(),
        policy => weighted[number].get_or_init(|| scheduler.priorities(policy)),
    };
    // Where the rows are those that one schedule needs, others may need more: they are passed over.
    let candidate = |number, completed| -> Result<_, Error> {
        let schedule = match scheduler.completed(completed, first_free) {
            Err(Error::Storage { .. }) if configuration.rows.is_some() => return Ok(None),
            found => found?,
        };
        Ok(Some(Candidate { cycles: Compressed::cycles(&schedule, configuration), number, schedule }))
    };
    let limit = fast.cycles + fast.cycles / SLACK;
    // Cycles before the first word and after the last result, the decoder's included.
    let timing = configuration.timing();
    let around = timing.startup + timing.finish + timing.decode;
    let (mut best, mut interrupted): (Option<Candidate>, _) = (None, Vec::new());
    for (number, policy) in SchedulingPolicy::ALL.into_iter().enumerate() {
        let mut by_cycle = scheduler.by_cycle(&graph, priorities(number), policy);
        if by_cycle.run(limit.saturating_sub(around)) {
            let Some(found) = candidate(number, by_cycle)? else { continue };
            if found.cycles <= limit {
                return Ok(found.schedule);
            }
            best = Some(faster(best, found));
        } else {
            interrupted.push((number, by_cycle));
        }
    }
    let cycles = Compressed::cycles(fast, configuration);
    let mut best =
        faster(best, Candidate { cycles, number: SchedulingPolicy::ALL.len(), schedule: fast.clone() });
    for (number, mut by_cycle) in interrupted.into_iter().rev() {
        if by_cycle.run(best.cycles - around) {
            best = match candidate(number, by_cycle)? {
                Some(found) => faster(Some(best), found),
                None => best,
            };
        }
    }
    Ok(best.schedule)
}

/// The schedule of a policy.
struct Candidate {
    cycles: u32,
    number: usize,
    schedule: Schedule,
}

/// The faster one; of equally fast ones that of the earlier policy.
fn faster(best: Option<Candidate>, other: Candidate) -> Candidate {
    let key = |of: &Candidate| (of.cycles, of.number);
    best.filter(|best| key(best) < key(&other)).unwrap_or(other)
}
