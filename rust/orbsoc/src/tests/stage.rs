//! Single stages on an engine's own buffers: the datapaths side by side, poisoned iterates, the scalar
//! pair (τ, κ), and refinement.

use crate::kernels::layout::refinement;
use crate::kernels::layout::regularization;
use crate::tests::reference::{dense, iterate_from_startup, mixed_problem};
use crate::{
    Buffer, Compiled, Decide, Engine, Outcome, Real, Settings, Stage, Status, Step, Stop, CLOSING, ITERATION,
    STARTUP,
};
use nalgebra::DVector;

fn engine<T: Compiled>(seed: u64) -> Engine<T> {
    Engine::new(&mixed_problem(seed), &Settings::single_precision()).unwrap()
}

fn set(engine: &mut Engine<f64>, buffer: Buffer, entries: &[f64]) {
    engine.path.work.get_mut(buffer).copy_from_slice(entries);
}

/// Each stage starts from the same entries, rounded; its outputs agree to 1e-4 of their largest. Solutions
/// of linear systems differ by their condition: there, the error left is compared with |K||x|, and
/// magnified by the reciprocal of the smallest pivot there is, the shift of a zero diagonal entry.
#[test]
fn every_stage_computes_the_same_numbers_in_both_precisions() {
    const CONDITIONED: [Buffer; 6] = [
        Buffer::KktSolution,
        Buffer::KktError,
        Buffer::Refinement,
        Buffer::MultiSolution,
        Buffer::MultiError,
        Buffer::MultiRefinement,
    ];
    let top = |entries: &mut dyn Iterator<Item = f64>| entries.fold(0.0, |top: f64, v| top.max(v.abs()));
    let (mut double, mut single) = (engine::<f64>(3), engine::<f32>(3));
    let once = |step: &Step| match *step {
        Step::Run(stage) | Step::Repeat { stage, .. } => stage,
    };
    for stage in STARTUP.iter().chain(ITERATION).chain(CLOSING).map(once) {
        for &buffer in Buffer::ALL {
            let rounded = double.buffer(buffer).iter().map(|&entry| f32::constant(entry));
            let entries = single.path.work.get_mut(buffer);
            entries.iter_mut().zip(rounded).for_each(|(entry, value)| *entry = value);
        }
        double.path.execute(stage);
        single.path.execute(stage);
        for &buffer in stage.writes().iter().filter(|buffer| !CONDITIONED.contains(buffer)) {
            let (d, s) = (double.buffer(buffer), single.buffer(buffer));
            let size = top(&mut d.iter().copied());
            let worst = top(&mut d.iter().zip(s).map(|(d, s)| d - s.value()));
            assert!(worst <= 1e-4 * size, "{}, {}: {worst:e} of {size:e}", stage.name(), buffer.name());
        }
        for (solution, error) in
            [(Buffer::KktSolution, Buffer::KktError), (Buffer::MultiSolution, Buffer::MultiError)]
        {
            if stage.writes().contains(&solution) {
                let largest = |buffer| top(&mut single.buffer(buffer).iter().map(Decide::value));
                let size = largest(Buffer::KktValues) * largest(solution);
                let magnified = f64::from(f32::EPSILON) / Settings::single_precision().static_regularization;
                assert!(largest(error) <= 4.0 * magnified * size, "{}", stage.name());
            }
        }
    }
}

#[test]
fn an_iterate_with_a_nan_or_an_infinity_stops_the_solve_and_is_never_solved() {
    let mut start = engine::<f64>(4);
    iterate_from_startup(&mut start, 0);
    for buffer in [Buffer::Point, Buffer::Slack, Buffer::Homogenizer] {
        for entry in 0..start.buffer(buffer).len() {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut poisoned = start.clone();
                poisoned.path.work.get_mut(buffer)[entry] = value;
                let outcome = poisoned.run(Stage::Statistics);
                assert_eq!(outcome, Outcome::Done(Stop::Stalled), "{} {entry} = {value}", buffer.name());
                poisoned.run(Stage::Unscale);
                let solution = poisoned.conclude();
                assert_eq!(solution.status, Status::NumericalLimit, "{} {entry} = {value}", buffer.name());
                assert!(solution.certificate.worst().is_infinite());
            }
        }
    }
}

#[test]
fn a_late_nan_leaves_the_best_iterate_of_before() {
    let mut engine = engine::<f64>(4);
    iterate_from_startup(&mut engine, 4);
    let mut plain = engine.clone();
    plain.run(Stage::Unscale);
    engine.path.work.slack[0] = f64::NAN;
    assert_eq!(engine.run(Stage::Statistics), Outcome::Done(Stop::Stalled));
    engine.run(Stage::Unscale);
    let (kept, before) = (engine.conclude(), plain.conclude());
    assert_eq!((kept.x, kept.z, kept.s), (before.x, before.z, before.s));
    assert_ne!(kept.status, Status::Solved);
}

#[test]
fn tau_and_kappa_take_part_in_the_step_length() {
    let mut engine = engine::<f64>(5);
    iterate_from_startup(&mut engine, 1);
    let zeros = vec![0.0; engine.buffer(Buffer::ScaledS).len()];
    set(&mut engine, Buffer::ScaledS, &zeros);
    set(&mut engine, Buffer::ScaledZ, &zeros);
    set(&mut engine, Buffer::Homogenizer, &[2.0, 0.5, 1.0]);
    // α ≤ −τ/dτ and α ≤ −κ/dκ; without either, as far as the floor of the reciprocal allows.
    for (step, expected) in
        [([-4.0, 0.0], 0.5), ([0.0, -4.0], 0.125), ([-4.0, -4.0], 0.125), ([3.0, 0.0], 1e6)]
    {
        set(&mut engine, Buffer::TauStep, &step);
        engine.path.execute(Stage::StepLength);
        let found = engine.buffer(Buffer::StepLength)[0];
        assert!((found / expected - 1.0).abs() < 1e-15, "{found} for {step:?}");
    }
    // Joined with the cones: −λ leaves each of them at α = 1.
    let back: Vec<f64> = engine.buffer(Buffer::Lambda).iter().map(|l| -l).collect();
    set(&mut engine, Buffer::ScaledZ, &back);
    for (step, expected) in [([-1.0, 0.0], 1.0), ([-4.0, 0.0], 0.5)] {
        set(&mut engine, Buffer::TauStep, &step);
        engine.path.execute(Stage::StepLength);
        assert!((engine.buffer(Buffer::StepLength)[0] / expected - 1.0).abs() < 1e-9, "{step:?}");
    }
}

/// An engine that has just solved for (−c, b, h) in its third iteration, and the true error of it.
fn solved() -> (Engine<f64>, DVector<f64>) {
    let mut engine = Engine::<f64>::new(&mixed_problem(6), &Settings::default()).unwrap();
    iterate_from_startup(&mut engine, 2);
    for stage in [
        Stage::Statistics,
        Stage::NtScaling,
        Stage::ScalingBlocks,
        Stage::Factorize,
        Stage::PredictorRhs,
        Stage::SolveConstantAndPredictor,
    ] {
        engine.run(stage);
    }
    // The pair's first right-hand side, once more and alone.
    let constant: Vec<f64> = engine.buffer(Buffer::MultiRhs).iter().step_by(2).copied().collect();
    set(&mut engine, Buffer::KktRhs, &constant);
    engine.run(Stage::SolveKkt);
    let error = true_error(&engine);
    (engine, error)
}

/// The shifts that the statistics leave for positive and negative pivots, at an iterate with ‖x‖∞ and ‖(y, z)‖∞ as given.
fn shifts(size_x: f64, size_yz: f64) -> (f64, f64) {
    let settings = Settings { static_regularization: 3e-8, ..Settings::default() };
    let mut engine = Engine::<f64>::new(&mixed_problem(6), &settings).unwrap();
    iterate_from_startup(&mut engine, 0);
    let n = engine.path.structure.n;
    let mut point = vec![0.5 * size_yz; engine.buffer(Buffer::Point).len()];
    point[..n].fill(0.5 * size_x);
    (point[1], point[n]) = (-size_x, -size_yz); // in x and in y
    set(&mut engine, Buffer::Point, &point);
    engine.run(Stage::Statistics);
    let entries = engine.buffer(Buffer::Regularization);
    assert_eq!(entries[regularization::FLOOR], settings.pivot_floor);
    assert_eq!(entries[regularization::REPLACEMENT], settings.dynamic_regularization);
    (entries[regularization::UP], entries[regularization::DOWN])
}

#[test]
fn shifts_are_balanced_by_the_sizes_of_the_iterate() {
    // up/down = ‖(y, z)‖/‖x‖, norms of at least 1, within [1e-6, 1].
    for (size_x, size_yz, ratio) in [
        (400.0, 25.0, 1.0 / 16.0),
        (400.0, 0.1, 1.0 / 400.0),
        (0.1, 25.0, 1.0),
        (25.0, 400.0, 1.0),
        (1e9, 2.0, 1e-6),
    ] {
        let (up, down) = shifts(size_x, size_yz);
        assert!((up / down / ratio - 1.0).abs() < 1e-14, "{up:e}, {down:e} at {size_x}, {size_yz}");
        assert!((up * down / 9e-16 - 1.0).abs() < 1e-14, "the mean is the setting");
    }
}

/// K + regularisation = LDLᵀ by way of solves without refinement: what stays of a right-hand side is the
/// shift's share, positive for x and the one unknown of each expansion, negative for all others.
#[test]
fn each_sign_of_pivot_is_shifted_by_its_own_entry() {
    let mut engine = Engine::<f64>::new(&mixed_problem(6), &Settings::default()).unwrap();
    iterate_from_startup(&mut engine, 2);
    for stage in [Stage::Statistics, Stage::NtScaling, Stage::ScalingBlocks] {
        engine.run(stage);
    }
    let mut entries = engine.buffer(Buffer::Regularization).to_vec();
    (entries[regularization::UP], entries[regularization::DOWN]) = (1e-3, 1e-5);
    set(&mut engine, Buffer::Regularization, &entries);
    for stage in [Stage::Factorize, Stage::PredictorRhs] {
        engine.run(stage);
    }
    let constant: Vec<f64> = engine.buffer(Buffer::MultiRhs).iter().step_by(2).copied().collect();
    set(&mut engine, Buffer::KktRhs, &constant);
    engine.run(Stage::SolveKkt);
    let left = true_error(&engine);
    let (structure, x) = (&engine.path.structure, engine.buffer(Buffer::KktSolution));
    let size = x.iter().fold(0.0, |top: f64, v| top.max(v.abs()));
    let heads = structure.cones.soc.iter().filter_map(|soc| soc.expansion);
    let ups: Vec<usize> = heads.map(|row| structure.n + structure.p + row + 1).collect();
    assert_eq!(ups.len(), 1, "the cone of six is expanded");
    for (old, &at) in structure.kkt.position.iter().enumerate() {
        let shift = if old < structure.n || ups.contains(&old) { 1e-3 } else { -1e-5 };
        let expected = shift * x[at as usize];
        assert!((left[old] - expected).abs() <= 1e-7 * size, "{old}: {:e}, not {expected:e}", left[old]);
    }
}

/// rhs − K·solution in natural order, by the dense unregularised matrix.
fn true_error(engine: &Engine<f64>) -> DVector<f64> {
    let kkt = &engine.path.structure.kkt;
    let natural =
        |entries: &[f64]| DVector::from_iterator(kkt.dim, kkt.position.iter().map(|&k| entries[k as usize]));
    let (rhs, x) = (natural(engine.buffer(Buffer::KktRhs)), natural(engine.buffer(Buffer::KktSolution)));
    rhs - dense(kkt, engine.buffer(Buffer::KktValues)) * x
}

#[test]
fn the_error_left_by_a_solve_is_that_of_the_unregularised_matrix() {
    let (engine, error) = solved();
    let position = &engine.path.structure.kkt.position;
    let found = engine.buffer(Buffer::KktError);
    let size = engine.buffer(Buffer::KktSolution).iter().fold(0.0, |top: f64, v| top.max(v.abs()));
    for (expected, &at) in error.iter().zip(position) {
        assert!((found[at as usize] - expected).abs() <= 1e-12 * size);
    }
    let stated = engine.buffer(Buffer::Refinement)[refinement::ERROR];
    assert!(stated > 0.0 && (stated - error.amax()).abs() <= 1e-12 * size);
}

/// Right-hand sides side by side do not see one another.
#[test]
fn the_first_of_a_pair_is_solved_bit_for_bit_as_alone() {
    let (mut engine, _) = solved();
    for stages in [
        [Stage::SolveConstantAndPredictor, Stage::SolveKkt],
        [Stage::RefineConstantAndPredictor, Stage::RefineKkt],
    ] {
        for stage in stages {
            engine.path.execute(stage);
        }
        for (both, alone) in
            [(Buffer::MultiSolution, Buffer::KktSolution), (Buffer::MultiError, Buffer::KktError)]
        {
            let first: Vec<f64> = engine.buffer(both).iter().step_by(2).copied().collect();
            assert_eq!(first, engine.buffer(alone), "{}", both.name());
        }
        let states = [Buffer::MultiRefinement, Buffer::Refinement].map(|buffer| engine.buffer(buffer));
        assert_eq!(states[0][..refinement::WORDS], *states[1]);
    }
}

#[test]
fn refinement_removes_what_regularisation_left() {
    let (mut engine, error) = solved();
    let before = engine.buffer(Buffer::Refinement)[refinement::ERROR];
    engine.path.execute(Stage::RefineKkt);
    let refined = true_error(&engine);
    assert_eq!(engine.buffer(Buffer::Refinement)[refinement::WORTHWHILE], 0.25 * before);
    // The error falls by about shift/pivot, 1e-8 over 1e-2 or so here, until rounding.
    assert!(refined.amax() <= 1e-3 * error.amax() + 1e-14, "{:e} after {:e}", refined.amax(), error.amax());
}

#[test]
fn a_refinement_that_would_not_help_changes_nothing() {
    let (engine, _) = solved();
    let spoiled: [fn(&mut Engine<f64>); 3] = [
        // Factors that are not numbers, factors of another matrix, and a problem that has ended.
        |engine| engine.path.work.pivot_inverse[0] = f64::NAN,
        |engine| engine.path.work.pivot_inverse.iter_mut().for_each(|d| *d *= -10.0),
        |engine| engine.path.work.refinement_active[0] = 0.0,
    ];
    for spoil in spoiled {
        let mut after = engine.clone();
        spoil(&mut after);
        after.path.execute(Stage::RefineKkt);
        for buffer in [Buffer::KktSolution, Buffer::KktError] {
            assert_eq!(after.buffer(buffer), engine.buffer(buffer), "{}", buffer.name());
        }
        let norms = [&after, &engine].map(|e| e.buffer(Buffer::Refinement)[refinement::ERROR]);
        assert_eq!(norms[0], norms[1]);
    }
}
