//! From a stage's name to its kernels: which buffers each call gets, and which instructions it may use.
//! Decisions are arithmetic, too: flag words, which `control.rs` reads.

use crate::kernels::layout::{centering, parameter, regularization, stat};
use crate::kernels::supernodal::watch::{Unwatched, Watch, Watched};
use crate::kernels::{
    cone_ops, factorization, line_search, linear_solve, matrix_scaling, matrix_update, right_hand_sides,
};
use crate::kernels::{decisions, reduce::max_abs, statistics, supernodal::pivots::Regularization};
use crate::kkt::structure::Structure;
use crate::method::{stage::Stage, warm_start, workspace::Workspace};
use crate::problem::Settings;
use crate::real::Real;

/// Stages whose arithmetic is compiled into one function: in one for all of them the loops would share its registers.
mod kind {
    pub const SCALING: u8 = 0;
    pub const UPDATE: u8 = 1;
    pub const WARM_START: u8 = 2;
    pub const FACTORIZE: u8 = 3;
    pub const TRANSFER: u8 = 4;
    pub const SOLVE: u8 = 5;
    pub const REFINE: u8 = 6;
    pub const SOLVE_MULTI: u8 = 7;
    pub const REFINE_MULTI: u8 = 8;
    pub const CONES: u8 = 9;
    pub const RHS: u8 = 10;
    pub const LINE_SEARCH: u8 = 11;
    pub const STATISTICS: u8 = 12;
    pub const SCALARS: u8 = 13;
    pub const CHECK: u8 = 14;
}

/// A stage's arithmetic, compiled for each instruction set, one of which is chosen at run time.
struct Run<'a, T, const KIND: u8> {
    structure: &'a Structure,
    settings: &'a Settings,
    work: &'a mut Workspace<T>,
    stage: Stage,
    needs_residual: bool,
}

impl<T: Real, const KIND: u8> pulp::WithSimd for Run<'_, T, KIND> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { structure, settings, work, stage, needs_residual } = self;
        match KIND {
            kind::SCALING => matrix_scaling(structure, settings, work, stage),
            kind::UPDATE => matrix_update(structure, work, stage),
            kind::WARM_START => warm_start::execute(structure, work, stage),
            kind::FACTORIZE => factorize(structure, work, &mut Unwatched),
            kind::TRANSFER => transfer(structure, work, stage),
            kind::SOLVE | kind::REFINE => {
                solve::<T, 1>(structure, work, KIND == kind::REFINE, needs_residual);
            }
            kind::SOLVE_MULTI | kind::REFINE_MULTI => {
                solve::<T, 2>(structure, work, KIND == kind::REFINE_MULTI, needs_residual);
            }
            kind::CONES => cone_operations(structure, work, stage),
            kind::RHS => right_hand_side(structure, work, stage),
            kind::LINE_SEARCH => step_length(structure, work),
            kind::STATISTICS => {
                residuals(structure, work);
                judge(work);
            }
            kind::CHECK => check(work, stage),
            _ => scalars(structure, work, stage),
        }
    }
}

/// Run a stage's arithmetic; the residual of a linear solve only if a decision needs it.
pub(crate) fn execute<T: Real>(
    structure: &Structure,
    settings: &Settings,
    work: &mut Workspace<T>,
    stage: Stage,
    needs_residual: bool,
) {
    macro_rules! run {
        ($kind:ident) => {
            T::vectorize(Run::<T, { kind::$kind }> { structure, settings, work, stage, needs_residual })
        };
    }
    match stage {
        Stage::Equilibrate | Stage::Unscale => run!(SCALING),
        Stage::LoadKkt | Stage::IdentityBlocks | Stage::ScalingBlocks => run!(UPDATE),
        Stage::LoadStart | Stage::CenterStart | Stage::NewtonStartRhs | Stage::NewtonStart => {
            run!(WARM_START);
        }
        Stage::Factorize => run!(FACTORIZE),
        Stage::StartRhs | Stage::StartPoint | Stage::StoreConstantAndPredictor | Stage::StoreStep => {
            run!(TRANSFER);
        }
        Stage::SolveKkt => run!(SOLVE),
        Stage::RefineKkt => run!(REFINE),
        Stage::SolveConstantAndPredictor => run!(SOLVE_MULTI),
        Stage::RefineConstantAndPredictor => run!(REFINE_MULTI),
        Stage::StartShift | Stage::NtScaling | Stage::Direction | Stage::SlackStep => run!(CONES),
        Stage::PredictorRhs | Stage::CorrectorRhs => run!(RHS),
        Stage::StepLength => run!(LINE_SEARCH),
        Stage::Statistics => run!(STATISTICS),
        Stage::CheckSolve | Stage::CheckConstantAndPredictor => run!(CHECK),
        Stage::EmbeddingPivot | Stage::TauStep | Stage::Centering | Stage::ConeProduct | Stage::Advance => {
            run!(SCALARS);
        }
    }
}

/// What equilibration makes of new (c, b, h), beside the matrices that it has equilibrated.
struct Rescaling<'a, T> {
    structure: &'a Structure,
    work: &'a mut Workspace<T>,
}

impl<T: Real> pulp::WithSimd for Rescaling<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let w = self.work;
        w.p.copy_from_slice(&w.equilibrated_p);
        w.q.copy_from_slice(&w.raw_q);
        matrix_scaling::rescale(self.structure.n, &w.scale, &mut w.p, &mut w.q, &mut w.cost_scale);
    }
}

/// Equilibrate, where the matrices are equilibrated already.
pub(crate) fn rescale<T: Real>(structure: &Structure, work: &mut Workspace<T>) {
    T::vectorize(Rescaling { structure, work });
}

/// The factorization with the same bits, in pieces between which `stop` is asked.
struct Watching<'a, T> {
    structure: &'a Structure,
    work: &'a mut Workspace<T>,
    stop: &'a mut dyn FnMut() -> bool,
}

impl<T: Real> pulp::WithSimd for Watching<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        factorize(self.structure, self.work, &mut Watched::new(self.stop));
    }
}

/// Factorize, unless `stop` ends it.
pub(crate) fn factorize_watched<T: Real>(
    structure: &Structure,
    work: &mut Workspace<T>,
    stop: &mut dyn FnMut() -> bool,
) {
    T::vectorize(Watching { structure, work, stop });
}

#[inline(always)]
fn matrix_scaling<T: Real>(structure: &Structure, settings: &Settings, w: &mut Workspace<T>, stage: Stage) {
    if stage == Stage::Equilibrate {
        w.p.copy_from_slice(&w.raw_p);
        w.a.copy_from_slice(&w.raw_a);
        w.g.copy_from_slice(&w.raw_g);
        w.q.copy_from_slice(&w.raw_q);
        let mut data = matrix_scaling::Data { p: &mut w.p, a: &mut w.a, g: &mut w.g, q: &mut w.q };
        let norms = &mut w.scratch[..structure.unknowns()];
        let scales = matrix_scaling::Scales {
            scale: &mut w.scale,
            inverse: &mut w.scale_inverse,
            cost: &mut w.cost_scale,
            equilibrated_p: &mut w.equilibrated_p,
        };
        matrix_scaling::equilibrate(structure, settings.ruiz_passes, &mut data, norms, scales);
        return;
    }
    let unknowns = structure.unknowns();
    let scales = (&w.scale[..], &w.scale_inverse[..], &w.cost_scale[..]);
    let one = T::one();
    let (point, slack_tau) = w.best.split_at(unknowns);
    let (slack, tau) = slack_tau.split_at(structure.m);
    matrix_scaling::undo(
        structure,
        scales,
        (point, slack, tau[0]),
        w.unscaled_iterate.split_at_mut(unknowns),
    );
    let (primal, dual) = w.unscaled_certificates.split_at_mut(unknowns);
    matrix_scaling::undo(structure, scales, (&w.primal_certificate, &[], one), (primal, &mut []));
    matrix_scaling::undo(structure, scales, (&w.dual_certificate[..unknowns], &[], one), (dual, &mut []));
}

#[inline(always)]
fn matrix_update<T: Real>(structure: &Structure, w: &mut Workspace<T>, stage: Stage) {
    let (kkt, cones) = (&structure.kkt, &structure.cones);
    match stage {
        Stage::LoadKkt => matrix_update::load_data(kkt, &w.p, &w.a, &w.g, &mut w.kkt_values),
        Stage::IdentityBlocks => {
            statistics::first_regularization(&w.parameters, &mut w.regularization);
            matrix_update::identity_blocks(kkt, cones, &mut w.kkt_values);
        }
        _ => matrix_update::scaling_blocks(kkt, cones, &w.w, &w.cone, &mut w.kkt_values),
    }
}

#[inline(always)]
fn factorize<T: Real>(structure: &Structure, w: &mut Workspace<T>, watch: &mut impl Watch) {
    let regularization = Regularization {
        shift_up: w.regularization[regularization::UP],
        shift_down: w.regularization[regularization::DOWN],
        floor: w.regularization[regularization::FLOOR],
        replacement: w.regularization[regularization::REPLACEMENT],
    };
    factorization::factorize(
        &structure.kkt.symbolic,
        &structure.kkt.positive,
        regularization,
        &w.kkt_values,
        factorization::Factor {
            l: &mut w.factor_l,
            pivot_inverse: &mut w.pivot_inverse,
            scratch: &mut w.scratch,
        },
        watch,
    );
}

#[inline(always)]
fn transfer<T: Real>(structure: &Structure, w: &mut Workspace<T>, stage: Stage) {
    let n = structure.n;
    let position = &structure.kkt.position[..structure.unknowns()];
    let solutions = w.multi_solution.as_chunks::<2>().0;
    match stage {
        Stage::StartRhs => {
            // The starting point needs no accuracy, only a place inside the cone.
            w.refinement_tolerance[0] = T::constant(1e-6) * max_abs(&w.q);
            let (linear, rhs) = (structure.cost.nnz() == 0, w.multi_rhs.as_chunks_mut::<2>().0);
            let rows = n + structure.p;
            right_hand_sides::starting(position, n, rows..rows + structure.cones.l, linear, &w.q, rhs);
        }
        Stage::StartPoint => {
            right_hand_sides::unload(&position[..n], solutions, 0, &mut w.point[..n]);
            right_hand_sides::unload(&position[n..], solutions, 1, &mut w.point[n..]);
            for (slack, &from) in w.slack.iter_mut().zip(&position[n + structure.p..]) {
                *slack = -solutions[from as usize][0];
            }
            if structure.cost.nnz() > 0 {
                let rows = n + structure.p;
                right_hand_sides::unbounded(&w.q[rows..], &mut w.slack[..structure.cones.l]);
            }
        }
        Stage::StoreConstantAndPredictor => {
            right_hand_sides::unload(position, solutions, 0, &mut w.constant_solution);
            right_hand_sides::unload(position, solutions, 1, &mut w.step);
        }
        _ => right_hand_sides::unload(position, w.kkt_solution.as_chunks::<1>().0, 0, &mut w.step),
    }
}

/// Solve with `R` right-hand sides side by side, or refine their solutions.
#[inline(always)]
fn solve<T: Real, const R: usize>(
    structure: &Structure,
    w: &mut Workspace<T>,
    refine: bool,
    needs_residual: bool,
) {
    let system = linear_solve::System {
        kkt: &structure.kkt,
        values: &w.kkt_values,
        l: &w.factor_l,
        pivot_inverse: &w.pivot_inverse,
    };
    let (rhs, x, error, state) = if R == 1 {
        (&w.kkt_rhs, &mut w.kkt_solution, &mut w.kkt_error, &mut w.refinement)
    } else {
        (&w.multi_rhs, &mut w.multi_solution, &mut w.multi_error, &mut w.multi_refinement)
    };
    let (rhs, scratch) = (rhs.as_chunks::<R>().0, w.scratch.as_chunks_mut().0);
    let (x, error) = (x.as_chunks_mut().0, error.as_chunks_mut().0);
    if refine {
        linear_solve::refine(system, rhs, scratch, x, error, state, w.refinement_active[0]);
        return;
    }
    linear_solve::solve(system, rhs, scratch, x);
    if needs_residual {
        let tolerance = (w.parameters[parameter::REFINEMENT_TOL], w.refinement_tolerance[0]);
        linear_solve::measure(system, rhs, tolerance, x, error, state);
        w.refinement_active[0] = T::one();
    }
}

#[inline(always)]
fn cone_operations<T: Real>(structure: &Structure, w: &mut Workspace<T>, stage: Stage) {
    let cones = &structure.cones;
    let rows = structure.n + structure.p;
    match stage {
        Stage::StartShift => {
            cone_ops::shift_into_cone(cones, &mut w.slack);
            cone_ops::shift_into_cone(cones, &mut w.point[rows..]);
            w.homogenizer.copy_from_slice(&[T::one(), T::one(), T::zero()]);
        }
        Stage::NtScaling => cone_ops::nt_scaling(
            cones,
            &w.slack,
            &w.point[rows..],
            &mut w.w,
            &mut w.lambda,
            &mut w.lambda_inverse,
            &mut w.cone,
        ),
        Stage::Direction => {
            cone_ops::add_scaled(w.tau_step[0], &w.constant_solution, &mut w.step);
            cone_ops::scale(cones, &w.w, &w.cone, &w.step[rows..], &mut w.scaled_z);
            cone_ops::negative_sum(&w.cone_division, &w.scaled_z, &mut w.scaled_s);
        }
        _ => cone_ops::scale(cones, &w.w, &w.cone, &w.scaled_s, &mut w.slack_step),
    }
}

#[inline(always)]
fn right_hand_side<T: Real>(structure: &Structure, w: &mut Workspace<T>, stage: Stage) {
    let cones = &structure.cones;
    let positions = structure.kkt.position.split_at(structure.unknowns());
    if stage == Stage::PredictorRhs {
        w.cone_division.copy_from_slice(&w.lambda);
        let rhs = w.multi_rhs.as_chunks_mut().0;
        right_hand_sides::predictor(positions, structure.n, &w.q, &w.residual, &w.slack, rhs);
        return;
    }
    cone_ops::divide(
        cones,
        &w.lambda,
        &w.lambda_inverse,
        &w.cone,
        &w.complementarity_rhs,
        &mut w.cone_division,
    );
    let lifted = &mut w.scratch[..structure.m];
    cone_ops::scale(cones, &w.w, &w.cone, &w.cone_division, lifted);
    let damping = w.centering[centering::DAMPING];
    right_hand_sides::corrector(positions, damping, &w.residual, lifted, &mut w.kkt_rhs);
}

#[inline(always)]
fn step_length<T: Real>(structure: &Structure, w: &mut Workspace<T>) {
    let (lambda, lambda_inverse, cone) = (&w.lambda[..], &w.lambda_inverse[..], &w.cone[..]);
    let cones = &structure.cones;
    let mut inverse = (-w.tau_step[0] / w.homogenizer[0]).max(-w.tau_step[1] / w.homogenizer[1]);
    for delta in [&w.scaled_s, &w.scaled_z] {
        let here = line_search::inverse_step(cones, lambda, lambda_inverse, cone, delta, &mut w.scratch);
        inverse = inverse.max(here);
    }
    w.step_length[0] = T::one() / inverse.max(T::constant(1e-6));
}

#[inline(always)]
fn residuals<T: Real>(structure: &Structure, w: &mut Workspace<T>) {
    let at = statistics::Iterate {
        p: &w.p,
        a: &w.a,
        g: &w.g,
        q: &w.q,
        norms: &w.norms,
        scale_inverse: &w.scale_inverse,
        cost_scale: &w.cost_scale,
        point: &w.point,
        slack: &w.slack,
        homogenizer: &w.homogenizer,
    };
    let products = &mut w.scratch[..2 * structure.n + structure.p + structure.m];
    statistics::statistics(
        structure,
        &at,
        products,
        &mut w.residual,
        &mut w.cost_product,
        &mut w.embedding,
        &mut w.centering,
        &mut w.statistics,
    );
    let degree = T::constant(structure.cones.degree() as f64 + 1.0);
    let complementarity = w.statistics[stat::MU] * degree;
    let sizes = statistics::sizes(structure.n, &w.point);
    w.refinement_tolerance[0] =
        statistics::refinement_tolerance(&w.residual, complementarity, sizes, &w.homogenizer, &w.parameters);
    statistics::balance_regularization(sizes, &w.parameters, &mut w.regularization);
}

/// Whether the attempt ends at this iterate, which is kept where it is better than those before.
#[inline(always)]
pub(crate) fn judge<T: Real>(w: &mut Workspace<T>) {
    let keep = decisions::judge(&w.statistics, &w.homogenizer, w.refinement_tolerance[0], &mut w.control);
    decisions::keep(keep.best, &[&w.point, &w.slack, &w.homogenizer[..1]], &mut w.best);
    decisions::keep(keep.primal, &[&w.point], &mut w.primal_certificate);
    decisions::keep(keep.dual, &[&w.point, &w.slack], &mut w.dual_certificate);
}

/// Whether to refine once more.
#[inline(always)]
fn check<T: Real>(w: &mut Workspace<T>, stage: Stage) {
    let entries = if stage == Stage::CheckSolve { &w.refinement } else { &w.multi_refinement };
    decisions::refine_again(entries, &mut w.refinement_active[0], &mut w.control);
}

#[inline(always)]
fn scalars<T: Real>(structure: &Structure, w: &mut Workspace<T>, stage: Stage) {
    match stage {
        Stage::EmbeddingPivot => {
            statistics::embedding_pivot(
                &w.q,
                &w.constant_solution,
                &w.cost_product,
                &w.homogenizer,
                &mut w.embedding,
            );
        }
        Stage::TauStep => statistics::tau_step(
            &w.q,
            &w.step,
            &w.cost_product,
            &w.homogenizer,
            &w.embedding,
            &w.centering,
            &mut w.tau_step,
        ),
        Stage::Centering => {
            let mu = w.statistics[stat::MU];
            let step = w.step_length[0];
            statistics::centering(step, mu, &w.homogenizer, &w.tau_step, &mut w.centering);
            let least = w.parameters[parameter::STEP_FRACTION];
            w.boundary_fraction[0] = statistics::fraction_to_boundary(step, least);
        }
        Stage::ConeProduct => statistics::cone_product(
            &structure.cones,
            &w.lambda,
            &w.scaled_s,
            &w.scaled_z,
            &w.centering,
            &mut w.complementarity_rhs,
        ),
        _ => {
            let alpha = statistics::step_taken(w.step_length[0], w.boundary_fraction[0]);
            w.step_taken[0] = alpha;
            statistics::advance(alpha, &w.step, &mut w.point);
            statistics::advance(alpha, &w.slack_step, &mut w.slack);
            statistics::advance(alpha, &w.tau_step, &mut w.homogenizer[..2]);
            w.homogenizer[statistics::STEPPED] = T::one();
            decisions::count_step(alpha, &mut w.control);
        }
    }
}
