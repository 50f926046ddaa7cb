//! When an attempt stops, what it keeps, and what it may accept: decisions on made-up statistics.

use crate::kernels::decisions::{count_step, refine_again};
use crate::kernels::layout::{refinement, stat};
use crate::method::control::Control;
use crate::method::dispatch::judge;
use crate::method::restart::Attempt;
use crate::tests::reference::mixed_problem;
use crate::Stop;
use crate::{Buffer, Cones, Csc, Engine, Outcome, Problem, Settings, Stage, Status, WarmStart};
use std::time::{Duration, Instant};

struct Decided {
    engine: Engine<f64>,
    control: Control,
}

/// One iterate's numbers: worst residual ratio, the primal's, the dual's and the gap's as fractions of it, radii of primal
/// and dual infeasibility, τ and κ.
#[derive(Clone, Copy)]
struct Iterate {
    worst: f64,
    ratios: [f64; 3],
    primal: f64,
    dual: f64,
    tau: f64,
    kappa: f64,
}

const PLAIN: Iterate = Iterate { worst: 1.0, ratios: [1.0; 3], primal: 0.0, dual: 0.0, tau: 1.0, kappa: 1.0 };
const LEANING: Iterate = Iterate { tau: 1e-4, ..PLAIN };

fn decided() -> Decided {
    decided_with(&Settings::default())
}

fn decided_with(settings: &Settings) -> Decided {
    let engine = Engine::new(&mixed_problem(9), settings).unwrap();
    Decided { engine, control: Control::new(settings) }
}

impl Decided {
    /// Begin an attempt anew.
    fn begin(&mut self, control: Control) {
        self.engine.path.prepare(0, control.attempt);
        self.control = control;
    }

    fn judge(&mut self, at: Iterate) -> Outcome {
        let work = &mut self.engine.path.work;
        work.statistics.fill(0.0);
        work.statistics[stat::STRICT] = at.worst;
        for (k, ratio) in [stat::PRIMAL, stat::DUAL, stat::GAP].into_iter().zip(at.ratios) {
            work.statistics[k] = ratio * at.worst;
        }
        work.statistics[stat::PRIMAL_RADIUS] = at.primal;
        work.statistics[stat::DUAL_RADIUS] = at.dual;
        work.homogenizer.copy_from_slice(&[at.tau, at.kappa, 1.0]);
        work.point.fill(at.worst);
        judge(work);
        self.control.decide(0, Stage::Statistics, work)
    }

    fn step(&mut self, length: f64) {
        let work = &mut self.engine.path.work;
        count_step(length, &mut work.control);
        assert_eq!(self.control.decide(0, Stage::Advance, work), Outcome::Next);
    }

    fn kept(&self, buffer: Buffer) -> f64 {
        self.engine.buffer(buffer)[0]
    }
}

fn warm() -> Control {
    let mut control = Control::new(&Settings::default());
    control.start_warm(true);
    control
}

const CONVERGED: Outcome = Outcome::Done(Stop::Converged);
const STALLED: Outcome = Outcome::Done(Stop::Stalled);

#[test]
fn a_fifth_of_the_tolerance_ends_the_attempt_and_more_buys_one_iteration() {
    assert_eq!(decided().judge(Iterate { worst: 0.2e-8, ..PLAIN }), CONVERGED);
    let mut decided = decided();
    assert_eq!(decided.judge(Iterate { worst: 1.1e-8, ..PLAIN }), Outcome::Next);
    assert_eq!(decided.judge(Iterate { worst: 0.9e-8, ..PLAIN }), Outcome::Next);
    // Whatever that iteration brings, the better one is kept.
    assert_eq!(decided.judge(Iterate { worst: 2e-8, ..PLAIN }), CONVERGED);
    assert_eq!(decided.kept(Buffer::Best), 0.9e-8);
}

#[test]
fn after_a_warm_start_half_of_the_tolerance_is_enough() {
    let mut decided = decided();
    let near = Iterate { worst: 0.5e-8, ..PLAIN };
    assert_eq!(decided.judge(near), Outcome::Next);
    decided.begin(warm());
    assert_eq!(decided.judge(Iterate { worst: 0.51e-8, ..PLAIN }), Outcome::Next);
    let cold = decided.control.restarted(Attempt::Cold);
    decided.begin(cold);
    assert_eq!(decided.judge(near), Outcome::Next);
    decided.begin(warm());
    assert_eq!(decided.judge(near), CONVERGED);
}

#[test]
fn the_clock_stands_still_while_an_attempt_is_suspended() {
    let settings = Settings { max_time_s: 1e-9, ..Settings::default() };
    let mut decided = decided();
    for (rest, outcome) in
        [(Duration::from_secs(3600), Outcome::Next), (Duration::ZERO, Outcome::Done(Stop::MaxTime))]
    {
        decided.begin(Control::new(&settings));
        let now = Instant::now();
        decided.control.suspend(now);
        decided.control.resume(now + rest);
        assert_eq!(decided.judge(PLAIN), outcome);
    }
}

#[test]
fn the_best_iterate_is_the_one_with_the_smallest_worst_ratio() {
    let mut decided = decided();
    for (worst, best) in [(1.0, 1.0), (0.5, 0.5), (0.7, 0.5), (0.49, 0.49), (0.4899, 0.4899), (3.0, 0.4899)] {
        assert_eq!(decided.judge(Iterate { worst, ..PLAIN }), Outcome::Next);
        assert_eq!(decided.kept(Buffer::Best), best);
    }
}

#[test]
fn iterates_that_are_not_numbers_stall_and_are_not_kept() {
    let mut decided = decided();
    decided.judge(PLAIN);
    assert_eq!(decided.judge(Iterate { worst: f64::NAN, ..PLAIN }), STALLED);
    assert_eq!(decided.kept(Buffer::Best), PLAIN.worst);
    let mut decided = self::decided();
    decided.judge(PLAIN);
    let work = &mut decided.engine.path.work;
    work.statistics[stat::NON_FINITE] = f64::NAN;
    work.statistics[stat::STRICT] = 1e-12;
    judge(work);
    assert_eq!(decided.control.decide(0, Stage::Statistics, work), STALLED);
    assert_eq!(decided.kept(Buffer::Best), PLAIN.worst);
}

#[test]
fn radii_count_only_while_the_embedding_leans_towards_infeasibility() {
    let mut decided = decided();
    assert_eq!(decided.judge(Iterate { primal: 1e12, dual: 1e12, ..PLAIN }), Outcome::Next);
    assert_eq!((decided.control.primal_radius, decided.control.dual_radius), (0.0, 0.0));
    assert_eq!(decided.judge(Iterate { primal: 1e3, worst: 2.0, ..LEANING }), Outcome::Next);
    assert_eq!(decided.judge(Iterate { primal: 1e2, worst: 3.0, ..LEANING }), Outcome::Next);
    assert_eq!(
        (decided.control.primal_radius, decided.kept(Buffer::PrimalCertificate)),
        (1e3, 2.0),
        "the larger one is kept"
    );
    assert_eq!(decided.judge(Iterate { dual: 5.0, worst: 4.0, ..LEANING }), Outcome::Next);
    assert_eq!((decided.control.dual_radius, decided.kept(Buffer::DualCertificate)), (5.0, 4.0));
    let primal = decided.judge(Iterate { primal: 1e8, ..LEANING });
    assert_eq!(primal, Outcome::Done(Stop::PrimalCertificate));
    assert_eq!(self::decided().judge(Iterate { dual: 1e8, ..LEANING }), Outcome::Done(Stop::DualCertificate));
}

#[test]
fn sixteen_iterations_without_progress_stall_and_creeping_is_none() {
    let mut decided = decided();
    decided.judge(PLAIN);
    for k in 1..=15 {
        let creeping = Iterate { worst: 1.0 - 0.001 * f64::from(k), ..PLAIN };
        assert_eq!(decided.judge(creeping), Outcome::Next, "iteration {k}");
    }
    assert_eq!(decided.judge(Iterate { worst: 0.985, ..PLAIN }), STALLED);
    // A tenth less is progress, and so is a larger radius.
    let mut decided = self::decided();
    for k in 0..6 {
        let fraction = 0.8f64.powi(k);
        let progress = if k % 2 == 0 {
            Iterate { worst: fraction, ..PLAIN }
        } else {
            Iterate { primal: f64::from(k), ..LEANING }
        };
        assert_eq!(decided.judge(progress), Outcome::Next);
        for _ in 0..15 {
            assert_eq!(decided.judge(Iterate { worst: 2.0, ..PLAIN }), Outcome::Next);
        }
    }
    assert_eq!(decided.judge(Iterate { worst: 2.0, ..PLAIN }), STALLED);
}

#[test]
fn a_ratio_that_falls_is_progress_while_the_worst_rises_and_not_below_the_tolerance() {
    for falling in 0..3 {
        let mut decided = decided();
        for k in 0..=42 {
            let mut ratios = [1.0; 3];
            ratios[falling] = 0.5f64.powi(2 * k);
            // The worst doubles; one ratio halves, and is above the tolerance for the last time in iteration 26.
            let outcome = decided.judge(Iterate { worst: 2f64.powi(k), ratios, ..PLAIN });
            assert_eq!(outcome, if k <= 26 + 15 { Outcome::Next } else { STALLED }, "iteration {k}");
        }
    }
}

#[test]
fn a_smaller_radius_concludes_where_the_embedding_is_clear() {
    let at = |tau, primal| decided().judge(Iterate { primal, tau, ..PLAIN });
    assert_eq!(at(0.9e-10, 1e6), Outcome::Done(Stop::PrimalCertificate));
    assert_eq!((at(0.9e-10, 0.9e6), at(1.1e-10, 1e6)), (Outcome::Next, Outcome::Next));
    assert_eq!(
        decided().judge(Iterate { dual: 1e6, tau: 0.9e-10, ..PLAIN }),
        Outcome::Done(Stop::DualCertificate)
    );
}

#[test]
fn three_short_steps_in_a_row_stall() {
    let mut decided = decided();
    for (length, outcome) in [
        (5e-5, Outcome::Next),
        (5e-5, Outcome::Next),
        (1e-3, Outcome::Next),
        (5e-5, Outcome::Next),
        (5e-5, Outcome::Next),
    ] {
        decided.step(length);
        assert_eq!(decided.judge(PLAIN), outcome);
    }
    decided.step(5e-5);
    assert_eq!(decided.judge(PLAIN), STALLED);
}

#[test]
fn converging_comes_before_every_limit_and_interruption_before_the_others() {
    let settings = Settings { max_iterations: 1, ..Settings::default() };
    let ended = |interrupted, at| {
        let mut decided = decided_with(&settings);
        decided.step(1.0);
        decided.control.interrupted = interrupted;
        decided.judge(at)
    };
    assert_eq!(ended(false, PLAIN), Outcome::Done(Stop::MaxIterations));
    assert_eq!(ended(true, PLAIN), Outcome::Done(Stop::Interrupted));
    assert_eq!(ended(true, Iterate { worst: 1e-10, ..PLAIN }), CONVERGED);
}

#[test]
fn what_has_ended_keeps_nothing_more() {
    let mut decided = decided();
    decided.judge(PLAIN);
    decided.control.interrupted = true;
    assert_eq!(decided.judge(Iterate { worst: 0.5, ..PLAIN }), Outcome::Done(Stop::Interrupted));
    decided.control.interrupted = false;
    assert_eq!(decided.judge(Iterate { worst: 0.1, ..PLAIN }), Outcome::Done(Stop::Interrupted));
    assert_eq!(decided.kept(Buffer::Best), 0.5);
}

#[test]
fn refinement_goes_on_while_it_gains_a_factor_of_four_and_ends_at_its_goal() {
    let settings = Settings { refinement_max: 3, ..Settings::default() };
    let outcomes = |errors: &[(f64, f64)]| {
        let Decided { mut engine, mut control } = decided_with(&settings);
        engine.path.work.refinement_active[0] = 1.0;
        let ask = |&(error, worthwhile)| {
            let entries = &mut engine.path.work.refinement;
            entries[refinement::ERROR] = error;
            entries[refinement::ALLOWED] = 1e-9;
            entries[refinement::WORTHWHILE] = worthwhile;
            let work = &mut engine.path.work;
            refine_again(&work.refinement, &mut work.refinement_active[0], &mut work.control);
            control.decide(0, Stage::CheckSolve, &mut engine.path.work)
        };
        errors.iter().map(ask).collect::<Vec<_>>()
    };
    let (on, enough) = (Outcome::Repeat, Outcome::Next);
    assert_eq!(outcomes(&[(1e-10, 1.0)]), [enough]);
    assert_eq!(outcomes(&[(1e-3, 1e-3), (1e-5, 2.5e-4), (1e-9, 2.5e-6)]), [on, on, enough]);
    assert_eq!(outcomes(&[(1e-3, 1e-3), (2.6e-4, 2.5e-4)]), [on, enough]);
    assert_eq!(outcomes(&[(1e-3, 1e-3), (1e-4, 1.0), (1e-5, 1.0), (1e-6, 1.0)]), [on, on, on, enough]);
    assert_eq!(outcomes(&[(f64::NAN, 1.0)]), [enough]);
}

/// Rows −x ≤ −1 and (1 − ε)x ≤ 0.9 with z = (1, 1): ρ = 0.1/ε, on data of scale 1.
fn concluded(stop: Stop, radius: f64) -> Status {
    let epsilon = 0.1 / radius;
    let g = Csc::from_dense(&[&[-1.0], &[1.0 - epsilon]], 1);
    let problem =
        Problem::new(None, vec![1.0], None, vec![], Some(g), vec![-1.0, 0.9], Cones { l: 2, q: vec![] })
            .unwrap();
    let settings = Settings::default();
    let mut engine = Engine::<f64>::new(&problem, &settings).unwrap();
    // The unscaled certificates are x, z of the primal certificate, then of the dual one, in the user's scaling.
    engine.path.work.unscaled_certificates.copy_from_slice(&[0.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let mut control = Control::new(&settings);
    (control.stop, control.primal_radius) = (Some(stop), radius);
    let solution = engine.path.finished(0, &problem, &control).verify();
    if solution.status == Status::PrimalInfeasible {
        assert!((solution.certificate.radius / radius - 1.0).abs() < 1e-9);
    }
    solution.status
}

#[test]
fn a_certificate_is_claimed_from_fifty_times_the_data_on_and_not_after_a_limit() {
    assert_eq!(concluded(Stop::Stalled, 51.0), Status::PrimalInfeasible);
    // Over its own scale it is 2 / 1.9 times as large: terms of 1 and 0.9, left of two terms of 1 in the column.
    assert_eq!(concluded(Stop::Stalled, 48.0), Status::PrimalInfeasible);
    assert_eq!(concluded(Stop::Stalled, 47.0), Status::NumericalLimit);
    assert_eq!(concluded(Stop::PrimalCertificate, 51.0), Status::PrimalInfeasible);
    for (stop, status) in [
        (Stop::MaxIterations, Status::MaxIterations),
        (Stop::MaxTime, Status::MaxTime),
        (Stop::Interrupted, Status::Interrupted),
    ] {
        assert_eq!(concluded(stop, 1e9), status, "what was cut short proves nothing");
    }
}

#[test]
fn a_stall_is_followed_by_the_attempt_that_fits_the_outcome_so_far() {
    let settings = Settings::default();
    let ended = |stop, attempt| {
        let mut control = Control::new(&settings);
        (control.stop, control.attempt) = (Some(stop), attempt);
        control
    };
    let after = |stop, attempt, status| {
        ended(stop, attempt).next_restart(status, &settings).map(|restart| restart.attempt)
    };
    let next = |attempt, status| after(Stop::Stalled, attempt, status);
    for status in [Status::NumericalLimit, Status::SolvedInaccurate] {
        assert_eq!(next(Attempt::Cold, status), Some(Attempt::Refined));
        assert_eq!(next(Attempt::Regularized, status), Some(Attempt::Light));
        assert_eq!(next(Attempt::Light, status), None);
    }
    assert_eq!(next(Attempt::Refined, Status::NumericalLimit), Some(Attempt::Regularized));
    assert_eq!(next(Attempt::Refined, Status::SolvedInaccurate), Some(Attempt::Light));
    for proof in [Status::PrimalInfeasible, Status::DualInfeasible] {
        assert_eq!(next(Attempt::Cold, proof), Some(Attempt::Light));
        assert_eq!(next(Attempt::Refined, proof), Some(Attempt::Light));
        assert_eq!((next(Attempt::Regularized, proof), next(Attempt::Light, proof)), (None, None));
        assert_eq!(next(Attempt::Warm, proof), Some(Attempt::Cold));
        for attempt in [Attempt::Cold, Attempt::Warm] {
            assert_eq!(after(Stop::PrimalCertificate, attempt, proof), None, "it is conclusive");
        }
    }
    assert_eq!(after(Stop::MaxIterations, Attempt::Refined, Status::MaxIterations), None);
    assert_eq!(after(Stop::WarmStartRejected, Attempt::Warm, Status::NumericalLimit), Some(Attempt::Cold));
    for status in [Status::Solved, Status::MaxTime, Status::Interrupted] {
        assert_eq!((next(Attempt::Warm, status), next(Attempt::Cold, status)), (None, None));
    }
}

#[test]
fn restarts_are_counted_and_limited() {
    let mut control = Control::new(&Settings::default());
    control.start_warm(true);
    assert_eq!((control.attempt, control.warm_start), (Attempt::Warm, WarmStart::Used));
    let mut made = Vec::new();
    for max_restarts in 0..6 {
        let settings = Settings { max_restarts, ..Settings::default() };
        let mut control = control.clone();
        control.stop = Some(Stop::Stalled);
        while let Some(restart) = control.next_restart(Status::NumericalLimit, &settings) {
            control = control.restarted(restart.attempt);
            assert_eq!(control.warm_start, WarmStart::FellBack);
            control.stop = Some(Stop::Stalled);
        }
        made.push((control.attempt, control.restarts));
    }
    let (cold, refined) = ((Attempt::Cold, 1), (Attempt::Refined, 2));
    let (regularized, last) = ((Attempt::Regularized, 3), (Attempt::Light, 4));
    assert_eq!(made, [(Attempt::Warm, 0), cold, refined, regularized, last, last]);
}
