//! Problems of one pattern in the lanes of one datapath, all at the same stage.

use crate::error::Error;
use crate::kernels::layout::stop;
use crate::kkt::structure::Structure;
use crate::method::control::Control;
use crate::method::engine::LONG;
use crate::method::stage::{Outcome, Stage, Step, CLOSING, ITERATION};
use crate::method::{datapath::Datapath, warm_start::Start, workspace::Buffer};
use crate::outcome::solution::{better_of, Solution};
use crate::problem::{Problem, Settings};
use crate::real::Decide;
use core::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

/// Asked after each iteration, and within long factorizations, whether to go on; once it is not, attempts end.
pub(crate) type Watch<'f> = dyn FnMut() -> ControlFlow<()> + 'f;

/// A problem in a lane.
pub(crate) struct Slot {
    pub index: usize,
    pub problem: Problem,
    pub control: Control,
    /// The outcome of an earlier attempt that stalled.
    pub earlier: Option<Solution>,
}

impl Slot {
    pub fn new(index: usize, problem: Problem, settings: &Settings) -> Self {
        Self { index, problem, control: Control::new(settings), earlier: None }
    }

    fn busy(&self) -> bool {
        self.control.stop.is_none()
    }
}

/// A slot for each lane. Between calls the statistics have just been decided on: a problem is moved or ends nowhere
/// else in an iteration.
pub(crate) struct LaneSlots<T> {
    path: Datapath<T>,
    lanes: Vec<Option<Slot>>,
    /// Buffers that a problem takes along when it moves.
    carried: Vec<Buffer>,
    /// Multiply–subtracts, in all lanes, from which on a factorization is watched.
    pub long: usize,
}

/// Where decisions keep certificates.
const CERTIFICATES: [Buffer; 2] = [Buffer::PrimalCertificate, Buffer::DualCertificate];

impl<T: Decide> LaneSlots<T> {
    pub fn new(structure: &Arc<Structure>, settings: &Settings) -> Result<Self, Error> {
        Ok(Self {
            path: Datapath::new(structure.clone(), settings)?,
            lanes: (0..T::LANES).map(|_| None).collect(),
            carried: carried_from_statistics(),
            long: LONG,
        })
    }

    pub fn another(&self) -> Result<Self, Error> {
        Ok(Self { long: self.long, ..Self::new(&self.path.structure, &self.path.settings)? })
    }

    pub fn settings(&self) -> &Settings {
        &self.path.settings
    }

    pub fn busy(&self) -> usize {
        self.lanes.iter().flatten().filter(|slot| slot.busy()).count()
    }

    pub fn clear(&mut self) {
        self.lanes.fill_with(|| None);
    }

    /// Fill the slots anew, and load the problems' data.
    pub fn fill(&mut self, next_batch: Vec<Slot>) {
        let mut next_batch = next_batch.into_iter();
        self.lanes.fill_with(|| next_batch.next());
        let problems: Vec<_> =
            self.lanes.iter().map(|slot| slot.as_ref().map(|slot| &slot.problem)).collect();
        self.path.load(&problems);
        for (lane, slot) in self.lanes.iter().enumerate() {
            if let Some(Slot { control, .. }) = slot {
                self.path.prepare(lane, control.attempt);
            }
        }
    }

    /// Load the points to start from. Problems without a useful point leave, for a cold start.
    pub fn load_starts<'a>(&mut self, start: impl Fn(usize) -> Start<'a>) -> Result<Vec<Slot>, Error> {
        let mut without = Vec::new();
        for (lane, taken) in self.lanes.iter_mut().enumerate() {
            let Some(Slot { index, problem, control, .. }) = taken else { continue };
            let start = start(*index);
            start.fit(problem)?;
            let useful = self.path.load_start(lane, &start);
            control.start_warm(useful);
            self.path.prepare(lane, control.attempt);
            if !useful {
                control.suspend(Instant::now());
                without.extend(taken.take());
            }
        }
        Ok(without)
    }

    /// Run a start-up list, and the first statistics.
    pub fn begin(&mut self, startup: &[Step], watch: &mut Watch<'_>) {
        self.follow(startup, watch);
        self.follow(&ITERATION[..1], watch);
    }

    /// One iteration, from one statistics to the next.
    fn iterate(&mut self, watch: &mut Watch<'_>) {
        self.follow(&ITERATION[1..], watch);
        self.follow(&ITERATION[..1], watch);
    }

    /// Iterate until at most `at_most` attempts go on, which are then suspended. All end soon after `watch` says so.
    pub fn iterate_until(&mut self, at_most: usize, watch: &mut Watch<'_>) {
        let now = Instant::now();
        for slot in self.lanes.iter_mut().flatten() {
            slot.control.resume(now);
        }
        while self.busy() > at_most {
            self.iterate(watch);
            if watch().is_break() {
                self.lanes.iter_mut().flatten().for_each(|slot| slot.control.interrupted = true);
            }
        }
        let now = Instant::now();
        for slot in self.lanes.iter_mut().flatten() {
            slot.control.suspend(now);
        }
    }

    /// Perform the steps in all lanes, up to a long factorization that ends all; a repeated stage runs as long as any lane asks
    /// for it.
    fn follow(&mut self, steps: &[Step], watch: &mut Watch<'_>) {
        let long = self.path.structure.kkt.symbolic.multiply_subtracts.saturating_mul(T::LANES) >= self.long;
        for step in steps {
            if long && *step == Step::Run(Stage::Factorize) {
                if self.factorize_watched(watch) {
                    return;
                }
            } else {
                step.perform(&mut |stage| self.run(stage));
            }
        }
    }

    /// A long factorization, which ends early where each attempt has a reason to: whether it did.
    fn factorize_watched(&mut self, watch: &mut Watch<'_>) -> bool {
        let Self { path, lanes, .. } = self;
        let mut reasons = vec![stop::NONE; T::LANES];
        let mut ended = false;
        path.factorize_watched(&mut || {
            let interrupted = watch().is_break();
            ended = true;
            for (slot, reason) in lanes.iter_mut().zip(&mut reasons) {
                let Some(Slot { control, .. }) = slot.as_mut().filter(|slot| slot.busy()) else { continue };
                control.interrupted |= interrupted;
                *reason = control.or_from_outside(stop::NONE);
                ended &= *reason != stop::NONE;
            }
            ended
        });
        for (lane, (slot, reason)) in lanes.iter_mut().zip(reasons).enumerate().filter(|_| ended) {
            if let Some(Slot { control, .. }) = slot.as_mut().filter(|slot| slot.busy()) {
                control.end(lane, reason, &mut path.work);
            }
        }
        ended
    }

    /// Run one stage in all lanes; repeat it if a lane asks to.
    fn run(&mut self, stage: Stage) -> Outcome {
        let Self { path, lanes, .. } = self;
        let busy = lanes.iter().enumerate().filter(|(_, slot)| slot.as_ref().is_some_and(Slot::busy));
        let needs_residual =
            busy.map(|(lane, _)| lane).any(|lane| Control::needs_residual(lane, stage, &path.work));
        path.execute_as_needed(stage, needs_residual);
        let mut repeats = false;
        for (lane, slot) in lanes.iter_mut().enumerate() {
            let Some(Slot { control, .. }) = slot else { continue };
            if control.stop.is_none() {
                repeats |= control.decide(lane, stage, &mut path.work) == Outcome::Repeat;
            }
        }
        if repeats {
            Outcome::Repeat
        } else {
            Outcome::Next
        }
    }

    /// Move those whose attempt goes on to free slots of `other`, as far as there are any.
    pub fn move_into(&mut self, other: &mut Self) {
        let free = other.lanes.iter().enumerate().filter(|(_, slot)| slot.is_none());
        let busy = self.lanes.iter().enumerate().filter(|(_, slot)| slot.as_ref().is_some_and(Slot::busy));
        let moves: Vec<(usize, usize)> = busy.zip(free).map(|((from, _), (to, _))| (from, to)).collect();
        other.path.copy_lanes(&moves, &self.path, &self.carried);
        for (from, to) in moves {
            let Some(slot) = self.lanes[from].take() else { continue };
            if slot.control.has_certificate() {
                other.path.copy_lanes(&[(from, to)], &self.path, &CERTIFICATES);
            }
            other.lanes[to] = Some(slot);
        }
    }

    /// Collect those that have ended, with their solutions.
    pub fn collect(&mut self) -> Vec<(Slot, Solution)> {
        if self.lanes.iter().flatten().all(Slot::busy) {
            return Vec::new();
        }
        for step in CLOSING {
            step.perform(&mut |stage| self.run(stage));
        }
        let path = &self.path;
        let ended = self.lanes.iter_mut().enumerate().filter_map(|(lane, slot)| {
            let slot = slot.take_if(|slot| !slot.busy())?;
            let solution = path.finished(lane, &slot.problem, &slot.control).verify();
            let solution = better_of(slot.earlier.as_ref(), solution, path.settings.tol_inaccurate);
            Some((slot, solution))
        });
        ended.collect()
    }
}

/// Buffers that the rest of an iteration, the next statistics or the closing read before they write them, and the best
/// iterate. Certificates come along where a decision has kept one.
fn carried_from_statistics() -> Vec<Buffer> {
    let mut written: Vec<Buffer> = Vec::new();
    let mut carried = vec![Buffer::Best];
    let steps = ITERATION.iter().cycle().skip(1).take(ITERATION.len()).chain(CLOSING);
    let stages = steps.flat_map(|step| match *step {
        Step::Run(stage) => [Some(stage), None],
        Step::Repeat { stage, until } => [Some(until), Some(stage)],
    });
    for stage in stages.flatten() {
        for &buffer in stage.reads() {
            if !written.contains(&buffer) && !carried.contains(&buffer) && !CERTIFICATES.contains(&buffer) {
                carried.push(buffer);
            }
        }
        written.extend(stage.writes());
    }
    carried
}
