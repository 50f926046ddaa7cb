//! One thread's lanes for a batch: a cohort of eight problems begins together; stragglers go on in a second set of lanes.

use crate::batch::slots::{LaneSlots, Slot, Watch};
use crate::error::Error;
use crate::kkt::structure::Structure;
use crate::method::stage::{STARTUP, WARM_STARTUP};
use crate::method::{restart::Attempt, warm_start::Start};
use crate::outcome::solution::{Solution, WarmStart};
use crate::problem::{Problem, Settings};
use crate::real::Decide;
use std::sync::Arc;

/// Each problem's point to start from.
pub(crate) type StartOf<'f, 'a> = &'f (dyn Fn(usize) -> Start<'a> + Sync);

/// Writes the next problem's numbers, and names it; `None` when there are no more.
pub(crate) type Take<'f> = dyn FnMut(&mut Problem) -> Result<Option<usize>, Error> + 'f;

/// Receives the solution of a problem.
pub(crate) type Done<'f> = dyn FnMut(usize, Solution) + 'f;

/// Lanes of any instruction set.
pub(crate) trait Work: Send {
    /// Solve what `take` hands out, from the points of `start`, until it has no more; give each solution to `done`.
    fn work(
        &mut self,
        base: &Problem,
        take: &mut Take<'_>,
        start: Option<StartOf<'_, '_>>,
        done: &mut Done<'_>,
        watch: &mut Watch<'_>,
    ) -> Result<(), Error>;
}

/// One thread's lanes: the problems that began together, and those left over by earlier cohorts. They are kept from one
/// batch to the next.
pub(crate) struct LaneWorker<T> {
    pub cohort: LaneSlots<T>,
    /// Made when first needed: in many batches all problems of a cohort end with the same iteration.
    stragglers: Option<LaneSlots<T>>,
    /// Problems that restart.
    restarts: Vec<Slot>,
    /// Problems whose memory the next ones take.
    reuse: Vec<Problem>,
}

impl<T: Decide + Send> Work for LaneWorker<T> {
    fn work(
        &mut self,
        base: &Problem,
        take: &mut Take<'_>,
        start: Option<StartOf<'_, '_>>,
        done: &mut Done<'_>,
        watch: &mut Watch<'_>,
    ) -> Result<(), Error> {
        self.clear();
        loop {
            let next_batch = self.next_batch(base, take)?;
            if !next_batch.is_empty() {
                self.make_room(done, watch)?;
                self.begin(next_batch, start, watch)?;
                self.iterate_cohort(Self::STRAGGLERS, done, watch);
            } else if self.stragglers.as_ref().is_some_and(|stragglers| stragglers.busy() > 0) {
                self.make_room(done, watch)?;
                self.iterate_stragglers(0, done, watch);
            } else if self.cohort.busy() > 0 {
                self.iterate_cohort(0, done, watch);
            } else {
                return Ok(());
            }
        }
    }
}

impl<T: Decide> LaneWorker<T> {
    /// With this many problems left, a cohort makes room for the next.
    const STRAGGLERS: usize = T::LANES / 2;

    pub fn new(structure: &Arc<Structure>, settings: &Settings) -> Result<Self, Error> {
        let cohort = LaneSlots::new(structure, settings)?;
        Ok(Self { cohort, stragglers: None, restarts: Vec::new(), reuse: Vec::new() })
    }

    /// Evict what an error left behind.
    fn clear(&mut self) {
        self.restarts.clear();
        self.cohort.clear();
        self.stragglers.iter_mut().for_each(LaneSlots::clear);
    }

    /// The next problems, at most one for each lane. Restarts come once they fill the lanes or nothing
    /// else is left.
    fn next_batch(&mut self, base: &Problem, take: &mut Take<'_>) -> Result<Vec<Slot>, Error> {
        let mut next_batch = Vec::with_capacity(T::LANES);
        while self.restarts.len() < T::LANES && next_batch.len() < T::LANES {
            let mut problem = self.reuse.pop().unwrap_or_else(|| base.clone());
            let Some(index) = take(&mut problem)? else {
                self.reuse.push(problem);
                break;
            };
            next_batch.push(Slot::new(index, problem, self.cohort.settings()));
        }
        if next_batch.is_empty() {
            next_batch.extend(self.restarts.drain(..self.restarts.len().min(T::LANES)));
        }
        Ok(next_batch)
    }

    /// Bring problems to their starting points: warm where there are such, but for those that have tried.
    fn begin(
        &mut self,
        next_batch: Vec<Slot>,
        start: Option<StartOf<'_, '_>>,
        watch: &mut Watch<'_>,
    ) -> Result<(), Error> {
        let tried = next_batch.iter().all(|slot| slot.control.warm_start == WarmStart::FellBack);
        self.cohort.fill(next_batch);
        if let Some(start) = start.filter(|_| !tried) {
            self.restarts.extend(self.cohort.load_starts(start)?);
            self.cohort.begin(WARM_STARTUP, watch);
        } else {
            self.cohort.begin(STARTUP, watch);
        }
        Ok(())
    }

    /// Move what is left of the cohort to the stragglers; when those are full, they iterate until one has ended.
    fn make_room(&mut self, done: &mut Done<'_>, watch: &mut Watch<'_>) -> Result<(), Error> {
        while self.cohort.busy() > 0 {
            if self.stragglers.as_ref().is_some_and(|stragglers| stragglers.busy() == T::LANES) {
                self.iterate_stragglers(T::LANES - 1, done, watch);
            }
            let stragglers = match self.stragglers.take() {
                Some(stragglers) => stragglers,
                None => self.cohort.another()?,
            };
            self.cohort.move_into(self.stragglers.insert(stragglers));
        }
        Ok(())
    }

    fn iterate_cohort(&mut self, at_most: usize, done: &mut Done<'_>, watch: &mut Watch<'_>) {
        self.cohort.iterate_until(at_most, watch);
        let ended = self.cohort.collect();
        self.deliver(ended, done);
    }

    fn iterate_stragglers(&mut self, at_most: usize, done: &mut Done<'_>, watch: &mut Watch<'_>) {
        let Some(stragglers) = &mut self.stragglers else { return };
        stragglers.iterate_until(at_most, watch);
        let ended = stragglers.collect();
        self.deliver(ended, done);
    }

    /// Give the solutions of those that have ended to `done`, and queue the restarts.
    fn deliver(&mut self, ended: Vec<(Slot, Solution)>, done: &mut Done<'_>) {
        for (slot, solution) in ended {
            if let Some(restart) = slot.control.next_restart(solution.status, self.cohort.settings()) {
                let control = slot.control.restarted(restart.attempt);
                let earlier = (control.attempt != Attempt::Cold).then_some(solution);
                self.restarts.push(Slot { control, earlier, ..slot });
            } else {
                done(slot.index, solution);
                self.reuse.push(slot.problem);
            }
        }
    }
}
