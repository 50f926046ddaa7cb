//! Whole solves in binary32: what single-precision logic would compute.

use crate::known::{generated, infeasible, solvable, unbounded};
use orbsoc::{Engine, Problem, Settings, Status};

fn engine(problem: &Problem) -> Engine<f32> {
    Engine::new(problem, &Settings::single_precision()).unwrap()
}

#[test]
fn small_problems_reach_the_single_precision_tolerance() {
    let tol = Settings::single_precision().tol;
    for (name, data, value) in solvable() {
        let solution = engine(&data.problem()).solve();
        assert_eq!(solution.status, Status::Solved, "{name}: {}", solution.message);
        assert!(solution.certificate.worst() <= tol, "{name}");
        assert!((solution.objective - value).abs() <= 10.0 * tol * (1.0 + value.abs()), "{name}");
    }
}

/// W² of a cone with s and z on its boundary has condition (s₀z₀/μ)², which binary32 resolves up to
/// 1/ε. A problem is well-conditioned when it stays below that down to μ = tol·(1 + |f|).
#[test]
fn well_conditioned_problems_reach_the_single_precision_tolerance() {
    let tol = Settings::single_precision().tol;
    let mut well_conditioned = 0;
    for seed in 0..60 {
        let (data, value) = generated(seed);
        let scale = 1.0 + value.abs();
        let exact = orbsoc::solve(&data.problem(), &Settings::default()).unwrap();
        // Row 11 is the head of the cone of size 7, whose s and z are on the boundary.
        let condition = (exact.s[11] * exact.z[11] / (tol * scale)).powi(2);
        let solution = engine(&data.problem()).solve();
        if condition <= 1.0 / f64::from(f32::EPSILON) {
            well_conditioned += 1;
            assert_eq!(solution.status, Status::Solved, "seed {seed}: {}", solution.message);
            assert!((solution.objective - value).abs() <= 10.0 * tol * scale, "seed {seed}");
        }
        // Beyond that, what is claimed is still true.
        match solution.status {
            Status::Solved => assert!(solution.certificate.worst() <= tol),
            Status::SolvedInaccurate => assert!(solution.certificate.worst() <= 1e-2),
            other => panic!("seed {seed}: {other}"),
        }
    }
    assert!(well_conditioned >= 20, "{well_conditioned} of 60");
}

#[test]
fn infeasible_and_unbounded_problems_are_recognised_in_single_precision() {
    let infeasible = infeasible().into_iter().map(|(name, data)| (name, data, Status::PrimalInfeasible));
    let unbounded = unbounded().into_iter().map(|(name, data)| (name, data, Status::DualInfeasible));
    for (name, data, expected) in infeasible.chain(unbounded) {
        let solution = engine(&data.problem()).solve();
        assert_eq!(solution.status, expected, "{name}: {}", solution.message);
    }
}

#[test]
fn the_answer_consists_of_binary32_words() {
    let data = generated(0).0;
    let single = engine(&data.problem()).solve();
    let double = Engine::<f64>::new(&data.problem(), &Settings::single_precision()).unwrap().solve();
    // The same method: about as many iterations in either precision.
    assert!(single.iterations.abs_diff(double.iterations) <= 2);
    #[allow(clippy::cast_possible_truncation)] // to see whether it changes the number
    let is_single = |v: &f64| f64::from(*v as f32) == *v;
    assert!(single.x.iter().all(is_single) && !double.x.iter().all(is_single));
}
