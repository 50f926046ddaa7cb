//! A pattern's buffers in arithmetic `T`, and the arithmetic of each stage on them. No decisions:
//! engines and batches decide.

use crate::error::Error;
use crate::kernels::decisions::{TOLERANCE_MARGIN, WARM_TOLERANCE_MARGIN};
use crate::kernels::layout::{control as word, parameter};
use crate::kkt::structure::Structure;
use crate::method::dispatch::{execute, factorize_watched, rescale};
use crate::method::radius_scale::norms;
use crate::method::workspace::{Buffer, Workspace};
use crate::method::{control::Control, restart::Attempt, stage::Stage, warm_start::Start};
use crate::outcome::verification::{FinishedAttempt, Stop};
use crate::problem::{Problem, Settings};
use crate::real::{Decide, Real};
use std::sync::Arc;

/// Least barrier parameter of a warm start: below it the scaling blocks are too far apart for the first linear solve.
const START_FLOOR: f64 = 1e-10;

#[derive(Clone, Debug)]
pub struct Datapath<T> {
    pub(crate) structure: Arc<Structure>,
    pub(crate) settings: Settings,
    pub(crate) work: Workspace<T>,
    /// P, A, G and their scales are those of the matrices as they are loaded.
    equilibrated: bool,
    /// They are in the KKT matrix.
    in_kkt: bool,
}

/// `refinement_share` at tolerances of 1e-8 and looser, less at tighter ones: no later iteration repairs an error of the
/// size of the residual.
fn effective_refinement_share(settings: &Settings) -> f64 {
    settings.refinement_share * (settings.tol / 1e-8).min(1.0)
}

impl<T: Real> Datapath<T> {
    pub(crate) fn new(structure: Arc<Structure>, settings: &Settings) -> Result<Self, Error> {
        settings.validate()?;
        let mut work = Workspace::new(&structure, T::zero());
        let entries = &mut work.parameters;
        entries[parameter::STATIC_REGULARIZATION] = T::constant(settings.static_regularization);
        entries[parameter::PIVOT_FLOOR] = T::constant(settings.pivot_floor);
        entries[parameter::DYNAMIC_REGULARIZATION] = T::constant(settings.dynamic_regularization);
        entries[parameter::REFINEMENT_TOL] = T::constant(settings.refinement_tol);
        entries[parameter::REFINEMENT_SHARE] = T::constant(effective_refinement_share(settings));
        entries[parameter::RESIDUAL_FLOOR] = T::constant(0.01 * settings.tol);
        entries[parameter::START_FLOOR] = T::constant(START_FLOOR.max(0.01 * settings.tol));
        entries[parameter::STEP_FRACTION] = T::constant(settings.step_fraction);
        Ok(Self { structure, settings: settings.clone(), work, equilibrated: false, in_kkt: false })
    }

    /// Run a stage's arithmetic.
    pub(crate) fn execute(&mut self, stage: Stage) {
        self.execute_with_residual(stage, true);
    }

    /// The same; without `needs_residual`, the residual of a linear solve is left as it was.
    fn execute_with_residual(&mut self, stage: Stage, needs_residual: bool) {
        let Self { structure, settings, work, .. } = self;
        execute(structure, settings, work, stage, needs_residual);
        match stage {
            Stage::Equilibrate => (self.equilibrated, self.in_kkt) = (true, false),
            Stage::LoadKkt => self.in_kkt = true,
            _ => {}
        }
    }

    /// Buffers have been written from outside.
    pub(crate) fn forget_matrices(&mut self) {
        (self.equilibrated, self.in_kkt) = (false, false);
    }

    /// The factorization, which `stop` may end early.
    pub(crate) fn factorize_watched(&mut self, stop: &mut dyn FnMut() -> bool) {
        factorize_watched(&self.structure, &mut self.work, stop);
    }
}

/// Buffers that are written where something better comes along: a solve must not read what the one before left there.
const KEPT: [Buffer; 3] = [Buffer::Best, Buffer::PrimalCertificate, Buffer::DualCertificate];

impl<T: Decide> Datapath<T> {
    /// Run what a solve needs of a stage, with the same numbers: not a residual that no decision needs, nor what is known
    /// of the matrices since the solve before.
    pub(crate) fn execute_as_needed(&mut self, stage: Stage, needs_residual: bool) {
        match stage {
            Stage::Equilibrate if self.equilibrated => {
                let factors = |work: &Workspace<T>| lanes_of(work.cost_scale[0]);
                let before = factors(&self.work);
                rescale(&self.structure, &mut self.work);
                self.in_kkt &= self.work.p.is_empty() || before.eq(factors(&self.work));
            }
            Stage::LoadKkt if self.in_kkt => {}
            _ => self.execute_with_residual(stage, needs_residual),
        }
    }

    /// Forget the last solve of a lane.
    pub(crate) fn reset(&mut self, lane: usize) {
        for buffer in KEPT {
            self.work.get_mut(buffer).iter_mut().for_each(|entry| entry.set_lane(lane, 0.0));
        }
        self.prepare(lane, Attempt::default());
    }

    /// Set the parameters and limits of an attempt in a lane that has been reset.
    pub(crate) fn prepare(&mut self, lane: usize, attempt: Attempt) {
        let (settings, entries) = (&self.settings, &mut self.work.parameters);
        let (refinement, regularization) = attempt.factors();
        entries[parameter::REFINEMENT_SHARE]
            .set_lane(lane, refinement * effective_refinement_share(settings));
        let shift = regularization * settings.static_regularization;
        entries[parameter::STATIC_REGULARIZATION].set_lane(lane, shift);
        self.work.verdict[0].set_lane(lane, 0.0);
        let words = &mut self.work.control;
        for entry in words.iter_mut() {
            entry.set_lane(lane, 0.0);
        }
        let warm = attempt == Attempt::Warm;
        let margin = if warm { WARM_TOLERANCE_MARGIN } else { TOLERANCE_MARGIN };
        let flag = |holds: bool| f64::from(u8::from(holds));
        for (k, value) in [
            // Before there is a tolerance, every residual is checked.
            (word::NEEDS_RESIDUAL, 1.0),
            (word::BEST, f64::INFINITY),
            (word::LEAST, f64::INFINITY),
            (word::LEAST + 1, f64::INFINITY),
            (word::LEAST + 2, f64::INFINITY),
            (word::TOLERANCE_AIM, margin * settings.tol),
            (word::TOLERANCE_MET, settings.tol),
            (word::MAX_ITERATIONS, f64::from(settings.max_iterations)),
            (word::MAX_REFINEMENTS, f64::from(settings.refinement_max)),
            // Only a plain cold attempt skips residuals: a warm one begins where they are large.
            (word::TRUSTING, flag(attempt == Attempt::Cold)),
            (word::WARM, flag(warm)),
        ] {
            words[k].set_lane(lane, value);
        }
    }

    /// Problems' entries into the input buffers, each into its own lane.
    pub(crate) fn load(&mut self, problems: &[Option<&Problem>]) {
        let (work, reduced) = (&mut self.work, &self.structure.reduced);
        let lanes: Vec<(usize, &Problem)> =
            problems.iter().enumerate().filter_map(|(lane, problem)| Some((lane, (*problem)?))).collect();
        let mut changed = fill(&mut work.raw_p, &lanes, |problem| problem.p.values(), |k| k);
        changed |= fill(&mut work.raw_a, &lanes, |problem| problem.a.values(), |k| k);
        changed |= fill(&mut work.raw_g, &lanes, |problem| problem.g.values(), |k| reduced.g_origin[k]);
        self.equilibrated &= !changed;
        self.in_kkt &= !changed;
        let (c, bh) = work.raw_q.split_at_mut(self.structure.n);
        let (b, h) = bh.split_at_mut(self.structure.p);
        fill(c, &lanes, |problem| &problem.c, |k| k);
        fill(b, &lanes, |problem| &problem.b, |k| k);
        fill(h, &lanes, |problem| &problem.h, |k| reduced.row_origin[k]);
        for &(lane, problem) in &lanes {
            for (norm, value) in work.norms.iter_mut().zip(norms(reduced, problem)) {
                norm.set_lane(lane, value);
            }
        }
        for (lane, _) in lanes {
            self.reset(lane);
        }
    }

    /// Copy the entries of some lanes of `buffers` from another datapath's, (from, to) each.
    pub(crate) fn copy_lanes(&mut self, moves: &[(usize, usize)], from: &Self, buffers: &[Buffer]) {
        self.forget_matrices();
        for &buffer in buffers {
            for (to, entry) in self.work.get_mut(buffer).iter_mut().zip(from.work.get(buffer)) {
                for &(from_lane, to_lane) in moves {
                    to.set_lane(to_lane, entry.lane(from_lane));
                }
            }
        }
    }

    /// A point's entries into a lane's input buffer; false when they are of no use: not all of them are finite,
    /// or there are no rows, without which the first step from anywhere is Newton's, and exact.
    pub(crate) fn load_start(&mut self, lane: usize, start: &Start) -> bool {
        let rows = &self.structure.reduced.row_origin;
        let (z, s) = (rows.iter().map(|&i| &start.z[i]), rows.iter().map(|&i| &start.s[i]));
        let entries = start.x.iter().chain(start.y).chain(z).chain(s).copied();
        let mut finite = true;
        for (to, entry) in self.work.start.iter_mut().zip(entries) {
            to.set_lane(lane, entry);
            finite &= entry.is_finite();
        }
        finite && self.structure.unknowns() > self.structure.n
    }

    /// The attempt that has ended in a lane, for its verification.
    pub(crate) fn finished<'a>(
        &'a self,
        lane: usize,
        problem: &'a Problem,
        control: &Control,
    ) -> FinishedAttempt<'a> {
        let read = |entries: &[T]| entries.iter().map(|entry| entry.lane(lane)).collect();
        // Most attempts have found no certificate, and the entries of a lane are far apart.
        let (primal, dual) = self.work.unscaled_certificates.split_at(self.structure.unknowns());
        FinishedAttempt {
            problem,
            settings: &self.settings,
            row_origin: &self.structure.reduced.row_origin,
            stop: control.stop.unwrap_or(Stop::Interrupted),
            best: read(&self.work.unscaled_iterate),
            any_iterate: control.best.is_finite(),
            primal: (control.primal_radius > 0.0).then(|| read(primal)),
            dual: (control.dual_radius > 0.0).then(|| read(dual)),
            iterations: control.total_iterations(),
            refinements: control.refinements,
            attempts: control.restarts + 1,
            warm_start: control.warm_start,
        }
    }
}

/// Bits of a number's lanes.
fn lanes_of<T: Decide>(number: T) -> impl Iterator<Item = u64> {
    (0..T::LANES).map(move |lane| number.lane(lane).to_bits())
}

/// Word by entry, not lane by lane: the entries of all lanes are next to one another. Word k is the number at `origin(k)`, or zero
/// where that is subnormal: its inverse, by which equilibration scales, would be infinite. Whether any word has other bits now.
fn fill<'a, T: Decide>(
    to: &mut [T],
    lanes: &[(usize, &'a Problem)],
    numbers: impl Fn(&'a Problem) -> &'a [f64],
    origin: impl Fn(usize) -> usize,
) -> bool {
    let lanes: Vec<(usize, &[f64])> = lanes.iter().map(|&(lane, problem)| (lane, numbers(problem))).collect();
    let mut changed = false;
    for (k, entry) in to.iter_mut().enumerate() {
        let at = origin(k);
        for &(lane, numbers) in &lanes {
            let (number, before) = (numbers[at], entry.lane(lane));
            entry.set_lane(lane, if number.is_subnormal() { 0.0 } else { number });
            changed |= before.to_bits() != entry.lane(lane).to_bits();
        }
    }
    changed
}
