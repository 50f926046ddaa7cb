//! Limits and interruption: the best iterate comes along, with its residuals.

use crate::known::generated;
use core::ops::ControlFlow;
use orbsoc::{Engine, Settings, Solution, Status};

fn engine(settings: &Settings) -> Engine<f64> {
    let settings = Settings { tol_inaccurate: 1e-7, ..settings.clone() };
    Engine::new(&generated(2).0.problem(), &settings).unwrap()
}

/// The point is worth something: its residuals are finite, and those that the referee finds.
fn assert_best_iterate(solution: &Solution) {
    let (data, _) = generated(2);
    let worst = solution.certificate.worst();
    assert!(worst.is_finite() && worst > 1e-8, "{worst:e}");
    assert!(solution
        .x
        .iter()
        .chain(&solution.y)
        .chain(&solution.z)
        .chain(&solution.s)
        .all(|v| v.is_finite()));
    let (_, _, gap) = data.residuals(solution);
    assert!((gap / solution.certificate.gap - 1.0).abs() < 1e-9);
    assert!(solution.message.starts_with("best iterate returned: "), "{}", solution.message);
}

#[test]
fn an_iteration_limit_returns_the_best_iterate() {
    let full = engine(&Settings::default()).solve();
    assert_eq!(full.status, Status::Solved);
    let mut last = f64::INFINITY;
    for max_iterations in 1..full.iterations {
        let solution = engine(&Settings { max_iterations, ..Settings::default() }).solve();
        if solution.status == Status::SolvedInaccurate {
            continue;
        }
        // Between a fifth of the tolerance and the tolerance, the attempt takes one step more.
        if solution.status == Status::Solved && max_iterations + 1 == full.iterations {
            assert!(solution.certificate.worst() > 0.2e-8, "{:e}", solution.certificate.worst());
            continue;
        }
        assert_eq!(solution.status, Status::MaxIterations);
        assert_eq!(solution.iterations, max_iterations);
        assert_best_iterate(&solution);
        assert!(solution.message.ends_with("raise max_iterations or look at the scaling of the data"));
        // Kept by the statistics' worst ratio, which is at least the certificate's and never grows.
        assert!(solution.certificate.worst() <= last.max(1.0));
        last = last.min(solution.certificate.worst());
    }
    assert!(last < 1e-3, "the later iterates are good ones: {last:e}");
}

#[test]
fn a_time_limit_is_looked_at_in_each_iteration() {
    let solution = engine(&Settings { max_time_s: 1e-9, ..Settings::default() }).solve();
    assert_eq!((solution.status, solution.iterations), (Status::MaxTime, 0));
    assert_best_iterate(&solution);
    assert!(solution.message.ends_with("raise max_time_s"), "{}", solution.message);
}

#[test]
fn an_observer_sees_every_iteration_and_may_end_the_solve() {
    let mut seen = Vec::new();
    let mut watched = engine(&Settings::default());
    let full = watched.solve_observed(|progress| {
        seen.push(*progress);
        ControlFlow::Continue(())
    });
    assert_eq!(
        seen.iter().map(|p| p.iteration).collect::<Vec<_>>(),
        (1..=full.iterations).collect::<Vec<_>>()
    );
    assert!(seen.iter().all(|p| p.step > 0.0 && p.step <= 1.0 && p.mu > 0.0));
    assert!(seen.windows(2).all(|p| p[0].refinements <= p[1].refinements));

    let mut calls = 0;
    let stopped = watched.solve_observed(|_| {
        calls += 1;
        if calls == 2 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    assert_eq!((stopped.status, stopped.iterations, calls), (Status::Interrupted, 2, 2));
    assert_best_iterate(&stopped);
    // Being interrupted is forgotten with the solve.
    assert_eq!(watched.solve().status, Status::Solved);
}
