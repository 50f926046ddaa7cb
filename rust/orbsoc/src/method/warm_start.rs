//! Starting from the solution of a problem nearby. docs/decisions/0008.
//!
//! The old point, on the new data, is moved to the central path at a barrier parameter μ₁ from its residuals
//! ([`Stage::CenterStart`]). One Newton step from there meets the new equations ([`Stage::NewtonStart`]), perhaps
//! outside the cones. The result is moved to the central path again, at μ₀ from the distance moved. One factorisation,
//! as in the cold start. A rejected start is followed by a cold one.

use crate::error::{fit, Error};
use crate::kernels::decisions::{judge_start, WARM_START_MU_MAX, WARM_STEP_MU_MAX};
use crate::kernels::{central_pair::central_pair, layout::parameter, reduce::max_abs};
use crate::kernels::{cone_ops, right_hand_sides};
use crate::kkt::structure::Structure;
use crate::method::{stage::Stage, workspace::Workspace};
use crate::outcome::solution::Solution;
use crate::problem::Problem;
use crate::real::Real;

/// A primal–dual point to start from, in the user's units: x (n), y (p), z (m), s (m). On rows whose
/// h is +∞, z and s mean nothing.
///
/// ```
/// # use orbsoc::*;
/// # let problem = Problem::new(None, vec![1.0], None, vec![], Some(Csc::from_dense(&[&[-1.0]], 1)),
/// #     vec![-2.0], Cones { l: 1, q: vec![] })?;
/// let mut engine = Engine::<f64>::new(&problem, &Settings::default())?;
/// let before = engine.solve();
/// let mut moved = problem.clone();
/// moved.set_h(&[-2.01])?;
/// engine.update(&moved)?;
/// let after = engine.solve_from(&Start::from(&before))?;
/// assert_eq!(after.warm_start, WarmStart::Used);
/// assert!((after.x[0] - 2.01).abs() < 1e-7 && after.iterations < before.iterations);
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Start<'a> {
    /// Variables.
    pub x: &'a [f64],
    /// Multipliers of Ax = b.
    pub y: &'a [f64],
    /// Multipliers of the cone rows.
    pub z: &'a [f64],
    /// Slacks.
    pub s: &'a [f64],
}

impl Start<'_> {
    /// Check the lengths.
    pub(crate) fn fit(&self, problem: &Problem) -> Result<(), Error> {
        let reason = "the problem needs";
        fit("start.x", (self.x.len(), "entries"), problem.n(), reason)?;
        fit("start.y", (self.y.len(), "entries"), problem.p(), reason)?;
        fit("start.z", (self.z.len(), "entries"), problem.m(), reason)?;
        fit("start.s", (self.s.len(), "entries"), problem.m(), reason)
    }
}

impl<'a> From<&'a Solution> for Start<'a> {
    fn from(of: &'a Solution) -> Self {
        Self { x: &of.x, y: &of.y, z: &of.z, s: &of.s }
    }
}

/// The stages of a warm start.
#[inline(always)]
pub(crate) fn execute<T: Real>(structure: &Structure, w: &mut Workspace<T>, stage: Stage) {
    match stage {
        Stage::LoadStart => load(structure, w),
        Stage::CenterStart => center(structure, w),
        Stage::NewtonStartRhs => {
            let position = &structure.kkt.position[..structure.unknowns()];
            right_hand_sides::newton_start(position, structure.n, &w.q, &w.slack, &mut w.kkt_rhs);
        }
        _ => newton(structure, w),
    }
}

/// The user's point in the scaling of the new data: x̂ = D⁻¹x, (ŷ, ẑ) = γ(E, F)⁻¹(y, z), ŝ = Fs.
#[inline(always)]
fn load<T: Real>(structure: &Structure, w: &mut Workspace<T>) {
    let (n, unknowns) = (structure.n, structure.unknowns());
    let (point, slack) = w.start.split_at(unknowns);
    for (i, (out, &entry)) in w.point.iter_mut().zip(point).enumerate() {
        let scaled = entry * w.scale_inverse[i];
        *out = if i < n { scaled } else { scaled * w.cost_scale[0] };
    }
    for ((out, &entry), &scale) in w.slack.iter_mut().zip(slack).zip(&w.scale[n + structure.p..]) {
        *out = entry * scale;
    }
    w.homogenizer.copy_from_slice(&[T::one(), T::zero(), T::zero()]);
}

/// Onto the central path: s from Gx + s = h, and μ₁ from the product of primal and dual residual, or,
/// where one of them is small, from the other's square.
#[inline(always)]
fn center<T: Real>(structure: &Structure, w: &mut Workspace<T>) {
    let (n, rows) = (structure.n, structure.n + structure.p);
    let (dual, primal) = (max_abs(&w.residual[..n]), max_abs(&w.residual[n..]));
    let worst = primal.max(dual);
    let both = T::constant(0.3) * (primal * dual);
    let one = T::constant(1e-4) * (worst * worst);
    let mu = w.parameters[parameter::START_FLOOR].max(both).max(one);
    for (slack, &residual) in w.slack.iter_mut().zip(&w.residual[rows..]) {
        *slack = *slack - residual;
    }
    central_pair(&structure.cones, mu, &mut w.slack, &mut w.point[rows..]);
    w.homogenizer.copy_from_slice(&[T::one(), mu, T::zero()]);
    w.verdict[0] = judge_start(mu, WARM_START_MU_MAX);
}

/// Take the step, and move onto the central path: at μ₁, or, where that move is long, at a μ from its square. κ is at
/// most τ, as more would lean towards infeasibility, unless μ is too large: then κ says so.
///
/// s − z stays, so s and z move equally far, and moving twice is moving once.
#[inline(always)]
fn newton<T: Real>(structure: &Structure, w: &mut Workspace<T>) {
    let (m, rows, cones) = (structure.m, structure.n + structure.p, &structure.cones);
    let position = &structure.kkt.position[..structure.unknowns()];
    let solution = w.kkt_solution.as_chunks::<1>().0;
    right_hand_sides::unload(&position[..rows], solution, 0, &mut w.point[..rows]);
    let z = &mut w.point[rows..];
    let (delta, rest) = w.scratch.split_at_mut(m);
    let scaled = &mut rest[..m];
    for ((delta, z), &from) in delta.iter_mut().zip(z.iter_mut()).zip(&position[rows..]) {
        let stepped = w.kkt_solution[from as usize];
        *delta = stepped - *z;
        *z = stepped;
    }
    cone_ops::scale(cones, &w.w, &w.cone, delta, scaled);
    cone_ops::scale(cones, &w.w, &w.cone, scaled, delta);
    for (slack, &delta) in w.slack.iter_mut().zip(delta.iter()) {
        *slack = *slack - delta;
    }
    let mu = w.homogenizer[1];
    // What the move costs in feasibility, and the barrier parameter that belongs to residuals of this size.
    let moved = &mut w.scratch[..m];
    moved.copy_from_slice(&w.slack);
    central_pair(cones, mu, &mut w.slack, &mut w.point[rows..]);
    for (moved, &slack) in moved.iter_mut().zip(&w.slack) {
        *moved = *moved - slack;
    }
    let distance = max_abs(moved);
    let mu = mu.max(T::constant(0.5) * (distance * distance));
    central_pair(cones, mu, &mut w.slack, &mut w.point[rows..]);
    let kappa = T::select(mu.lt(T::constant(WARM_STEP_MU_MAX)), mu.min(T::one()), mu);
    w.homogenizer.copy_from_slice(&[T::one(), kappa, T::zero()]);
    w.verdict[0] = judge_start(kappa, WARM_STEP_MU_MAX);
}
