//! A batch returns, for every problem, the bits of its own single solve, whatever its neighbours are.

use core::ops::ControlFlow;
use orbsoc::{
    solve, solve_batch, BatchProgress, BatchSolver, Cones, Csc, Error, Problem, Settings, Solution, Status,
};

/// Deterministic numbers in (−1, 1).
fn numbers(seed: usize, count: usize) -> Vec<f64> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64.wrapping_mul(seed as u64 + 1);
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

/// min cᵀx in a ball, a few half-spaces and an equality: solvable, infeasible or badly scaled by `k`.
fn base() -> Problem {
    let (n, l, dim) = (6, 4, 7);
    let rows = numbers(1, (l + 1) * n);
    let mut g: Vec<Vec<f64>> = rows[..l * n].chunks(n).map(<[f64]>::to_vec).collect();
    g.push(vec![0.0; n]);
    g.extend((0..n).map(|i| (0..n).map(|j| if i == j { -1.0 } else { 0.0 }).collect()));
    let g: Vec<&[f64]> = g.iter().map(Vec::as_slice).collect();
    let mut h = vec![1.0; l];
    h.push(3.0);
    h.extend(vec![0.0; dim - 1]);
    let p: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| if i == j { 0.1 } else { 0.0 }).collect()).collect();
    let p: Vec<&[f64]> = p.iter().map(Vec::as_slice).collect();
    Problem::new(
        Some(Csc::from_dense(&p, n)),
        numbers(2, n),
        Some(Csc::from_dense(&[&rows[l * n..]], n)),
        vec![0.1],
        Some(Csc::from_dense(&g, n)),
        h,
        Cones { l, q: vec![dim] },
    )
    .unwrap()
}

fn write(k: usize, problem: &mut Problem) -> Result<(), Error> {
    let scale = 10_f64.powi(i32::try_from(k % 7).unwrap() - 3);
    let c: Vec<f64> = numbers(k + 10, 6).iter().map(|v| v * scale).collect();
    problem.set_c(&c)?;
    // Every fifth ball is out of the half-spaces' and the plane's reach: infeasible.
    let b = if k % 5 == 4 { 1e3 } else { 0.3 * numbers(k + 99, 1)[0] };
    problem.set_b(&[b])
}

fn single(k: usize, settings: &Settings) -> Solution {
    let mut problem = base();
    write(k, &mut problem).unwrap();
    solve(&problem, settings).unwrap()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

fn assert_same(k: usize, a: &Solution, b: &Solution) {
    assert_eq!(a.status, b.status, "problem {k}");
    assert_eq!((a.iterations, a.refinements), (b.iterations, b.refinements), "problem {k}");
    for (name, a, b) in [("x", &a.x, &b.x), ("y", &a.y, &b.y), ("z", &a.z, &b.z), ("s", &a.s, &b.s)] {
        assert_eq!(bits(a), bits(b), "problem {k}: {name}");
    }
    assert_eq!(a.message, b.message, "problem {k}");
}

#[test]
fn every_lane_equals_its_own_single_solve_on_any_number_of_threads() {
    let settings = Settings::default();
    let singles: Vec<Solution> = (0..61).map(|k| single(k, &settings)).collect();
    assert!(singles.iter().any(|s| s.status == Status::PrimalInfeasible));
    assert!(singles.iter().filter(|s| s.status == Status::Solved).count() > 30);
    let spread: Vec<u32> = singles.iter().map(|s| s.iterations).collect();
    assert!(spread.iter().min() != spread.iter().max(), "lanes must end at different iterations");
    for threads in [1, 2, 3] {
        let batch = solve_batch(&base(), 61, write, &settings, threads).unwrap();
        assert_eq!(batch.len(), 61);
        for (k, (a, b)) in singles.iter().zip(&batch).enumerate() {
            assert_same(k, a, b);
        }
    }
}

#[test]
fn limits_hold_for_each_problem_apart() {
    let settings = Settings { max_iterations: 5, ..Settings::default() };
    for (k, solution) in solve_batch(&base(), 19, write, &settings, 1).unwrap().iter().enumerate() {
        assert!(solution.iterations <= 5);
        assert_same(k, &single(k, &settings), solution);
    }
}

#[test]
fn batches_smaller_than_a_register_and_empty_ones_work() {
    let settings = Settings::default();
    for count in 0..4 {
        let batch = solve_batch(&base(), count, write, &settings, 2).unwrap();
        assert_eq!(batch.len(), count);
        for (k, solution) in batch.iter().enumerate() {
            assert_same(k, &single(k, &settings), solution);
        }
    }
}

#[test]
fn one_solver_solves_batch_after_batch_with_the_bits_of_single_solves() {
    let settings = Settings::default();
    let mut solver = BatchSolver::new(&base(), &settings, 2).unwrap();
    let interrupted = |k: usize, problem: &mut Problem| {
        if k == 13 {
            return problem.set_c(&[1.0]);
        }
        write(k, problem)
    };
    for count in [30, 3, 17] {
        assert!(solver.solve(30, interrupted).is_err(), "some lanes are left in the middle of their attempt");
        let batch = solver.solve(count, write).unwrap();
        assert_eq!(batch.len(), count);
        for (k, solution) in batch.iter().enumerate() {
            assert_same(k, &single(k, &settings), solution);
        }
    }
}

#[test]
fn a_wrong_length_is_an_error_that_names_it() {
    let wrong = |_: usize, problem: &mut Problem| problem.set_c(&[1.0]);
    let error = solve_batch(&base(), 3, wrong, &Settings::default(), 1).unwrap_err();
    assert_eq!(error.to_string(), "problem 0 of the batch: `c` has 1 entries, but the problem needs 6");
}

/// Stop a batch of 61 when `at` problems have ended.
fn stopped_at(at: usize, threads: usize) -> (Vec<Solution>, Vec<BatchProgress>) {
    let mut solver = BatchSolver::new(&base(), &Settings::default(), threads).unwrap();
    let mut seen = Vec::new();
    let observe = |progress: &BatchProgress| {
        seen.push(*progress);
        if progress.ended >= at {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let solutions = solver.solve_observed(61, write, None, observe).unwrap();
    let again = solver.solve(9, write).unwrap();
    again.iter().enumerate().for_each(|(k, s)| assert_same(k, &single(k, &Settings::default()), s));
    (solutions, seen)
}

/// That of its own solve, or one that was stopped when the tolerance was met already.
fn assert_ended(k: usize, solution: &Solution) {
    let alone = single(k, &Settings::default());
    if solution.iterations == alone.iterations {
        assert_same(k, &alone, solution);
    } else {
        assert_eq!(solution.status, Status::Solved);
        assert!(solution.certificate.worst() <= Settings::default().tol, "problem {k}");
    }
}

#[test]
fn a_stopped_batch_keeps_what_has_ended_and_says_what_has_not() {
    let (solutions, seen) = stopped_at(20, 1);
    assert!(seen.windows(2).all(|w| w[0].ended <= w[1].ended && w[1].count == 61));
    assert!(
        seen.iter().filter(|progress| progress.ended >= 20).count() == 1,
        "asked again after it said stop"
    );
    let (stopped, ended): (Vec<_>, Vec<_>) =
        solutions.iter().enumerate().partition(|(_, s)| s.status == Status::Interrupted);
    assert!(ended.len() >= 20 && stopped.len() >= 61 - 20 - 16, "{} ended", ended.len());
    for (k, solution) in ended {
        assert_ended(k, solution);
    }
    let (under_way, not_begun): (Vec<_>, Vec<_>) = stopped.into_iter().partition(|(_, s)| s.iterations > 0);
    assert!(!under_way.is_empty() && !not_begun.is_empty());
    assert!(under_way.iter().all(|(_, s)| s.x.iter().all(|x| x.is_finite())));
    for (k, s) in not_begun {
        assert!(s.x.iter().chain(&s.y).chain(&s.z).chain(&s.s).all(|w| w.is_nan()), "problem {k}");
        assert_eq!(s.message, "stopped before this problem began");
        assert_eq!(s.certificate.worst(), f64::INFINITY);
    }
}

#[test]
fn who_watches_a_batch_sees_it_begin_and_end() {
    for (threads, count) in [(1, 0), (1, 1), (1, 20), (2, 0), (2, 1), (2, 20)] {
        let mut seen = Vec::new();
        let observe = |progress: &BatchProgress| {
            seen.push(*progress);
            ControlFlow::Continue(())
        };
        let mut solver = BatchSolver::new(&base(), &Settings::default(), threads).unwrap();
        solver.solve_observed(count, write, None, observe).unwrap();
        assert_eq!(seen.last(), Some(&BatchProgress { ended: count, count }));
        assert_eq!(seen[0], BatchProgress { ended: 0, count });
    }
}

#[test]
fn a_batch_on_threads_is_stopped_from_the_thread_that_called() {
    let (solutions, seen) = stopped_at(0, 2);
    assert!(solutions.len() == 61 && seen.len() == 1);
    for (k, solution) in solutions.iter().enumerate().filter(|(_, s)| s.status != Status::Interrupted) {
        assert_ended(k, solution);
    }
}
