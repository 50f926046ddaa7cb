//! A pattern's buffers in arithmetic `T`, and the arithmetic of each stage on them. No decisions:
//! engines and batches decide.

use crate::error::Error;
use crate::execute::execute;
use crate::problem::Problem;
use crate::real::{Decide, Real};
use crate::settings::Settings;
use crate::stage::Stage;
use crate::structure::Structure;
use crate::workspace::{parameter, Buffer, Workspace};
use std::sync::Arc;

#[derive(Clone, Debug)]
pub(crate) struct Datapath<T> {
    pub structure: Arc<Structure>,
    pub settings: Settings,
    pub work: Workspace<T>,
    simd: pulp::Arch,
}

impl<T: Real> Datapath<T> {
    pub fn new(structure: Arc<Structure>, settings: &Settings) -> Result<Self, Error> {
        settings.validate()?;
        let mut work = Workspace::new(&structure, T::zero());
        let words = &mut work.parameters;
        words[parameter::STATIC_REGULARIZATION] = T::constant(settings.static_regularization);
        words[parameter::PIVOT_FLOOR] = T::constant(settings.pivot_floor);
        words[parameter::DYNAMIC_REGULARIZATION] = T::constant(settings.dynamic_regularization);
        words[parameter::REFINEMENT_TOL] = T::constant(settings.refinement_tol);
        words[parameter::REFINEMENT_SHARE] = T::constant(settings.refinement_share);
        words[parameter::RESIDUAL_FLOOR] = T::constant(0.01 * settings.tol);
        words[parameter::STEP_FRACTION] = T::constant(settings.step_fraction);
        Ok(Self { structure, settings: settings.clone(), work, simd: pulp::Arch::new() })
    }

    /// Run a stage's arithmetic.
    pub fn execute(&mut self, stage: Stage) {
        let Self { structure, settings, work, .. } = self;
        self.simd.dispatch(StageRun { structure, settings, work, stage });
    }
}

/// Buffers that decisions write: a word that a previous solve left there must never be taken for one
/// of this solve.
const KEPT: [Buffer; 3] = [Buffer::Best, Buffer::Farkas, Buffer::Ray];

impl<T: Decide> Datapath<T> {
    /// Forget the last solve of a lane.
    pub fn reset(&mut self, lane: usize) {
        for buffer in KEPT {
            self.work.get_mut(buffer).iter_mut().for_each(|word| word.set_lane(lane, 0.0));
        }
    }

    /// The problem's words into a lane's input buffers.
    pub fn load(&mut self, lane: usize, problem: &Problem) {
        let (work, reduced) = (&mut self.work, &self.structure.reduced);
        let fill = |to: &mut [T], from: &mut dyn Iterator<Item = f64>| {
            to.iter_mut().zip(from).for_each(|(word, value)| word.set_lane(lane, value));
        };
        fill(&mut work.raw_p, &mut problem.p.values().iter().copied());
        fill(&mut work.raw_a, &mut problem.a.values().iter().copied());
        fill(&mut work.raw_g, &mut reduced.g_origin.iter().map(|&k| problem.g.values()[k]));
        let h = || reduced.row_origin.iter().map(|&i| problem.h[i]);
        let (c, bh) = work.raw_q.split_at_mut(self.structure.n);
        fill(c, &mut problem.c.iter().copied());
        fill(bh, &mut problem.b.iter().copied().chain(h()));
        let largest =
            |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |top: f64, v| top.max(v.abs()));
        work.norms[0].set_lane(lane, largest(&mut problem.b.iter().copied()));
        work.norms[1].set_lane(lane, largest(&mut h()));
        work.norms[2].set_lane(lane, largest(&mut problem.c.iter().copied()));
        self.reset(lane);
    }

    /// One lane's words of a buffer.
    pub fn lane(&self, buffer: Buffer, lane: usize) -> Vec<f64> {
        self.work.get(buffer).iter().map(|word| word.lane(lane)).collect()
    }
}

/// A stage's arithmetic, to be compiled once for each instruction set and chosen at run time.
struct StageRun<'a, T> {
    structure: &'a Structure,
    settings: &'a Settings,
    work: &'a mut Workspace<T>,
    stage: Stage,
}

impl<T: Real> pulp::WithSimd for StageRun<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        execute(self.structure, self.settings, self.work, self.stage);
    }
}
