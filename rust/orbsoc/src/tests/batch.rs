//! Every instruction set's lanes, whatever the machine would choose by itself.

use crate::batch::worker::{LaneWorker, StartOf, Work};
use crate::kkt::structure::Structure;
use crate::real::{Decide, Lanes};
use crate::tests::reference::{mixed_problem, SplitMix64};
use crate::{solve_batch, solve_batch_from, Engine, Error, Problem, Settings, Solution, Start, WarmStart};
use core::ops::ControlFlow;
use std::sync::Arc;

const COUNT: usize = 21;

fn vary(k: usize, problem: &mut Problem) {
    let c = SplitMix64(k as u64 + 50).list(problem.n());
    problem.set_c(&c).unwrap();
}

fn in_lanes<T: Decide>(base: &Problem) -> Vec<Solution> {
    in_lanes_from::<T>(base, None)
}

fn in_lanes_from<T: Decide>(base: &Problem, start: Option<StartOf<'_, '_>>) -> Vec<Solution> {
    let structure = Arc::new(Structure::for_lanes(base, crate::Ordering::Amd).unwrap());
    let mut worker = LaneWorker::<T>::new(&structure, &Settings::default()).unwrap();
    let (mut next, mut solved) = (0, vec![None; COUNT]);
    let mut take = |problem: &mut Problem| {
        problem.copy_numbers(base);
        vary(next, problem);
        next += 1;
        Ok((next <= COUNT).then_some(next - 1))
    };
    let mut done = |k: usize, solution| solved[k] = Some(solution);
    worker.work(base, &mut take, start, &mut done, &mut || ControlFlow::Continue(())).unwrap();
    solved.into_iter().map(Option::unwrap).collect()
}

fn assert_singles(base: &Problem, solved: &[Solution]) {
    assert_singles_from(base, solved, None);
}

fn assert_singles_from(base: &Problem, solved: &[Solution], start: Option<StartOf<'_, '_>>) {
    for (k, found) in solved.iter().enumerate() {
        let mut problem = base.clone();
        vary(k, &mut problem);
        let mut engine = Engine::<f64>::new(&problem, &Settings::default()).unwrap();
        let alone = match start {
            Some(start) => engine.solve_from(&start(k)).unwrap(),
            None => engine.solve(),
        };
        let ending = |s: &Solution| (s.status, s.iterations, s.warm_start);
        assert_eq!(ending(found), ending(&alone), "problem {k}");
        let bits = |s: &Solution| {
            [&s.x, &s.y, &s.z, &s.s].map(|v| v.iter().map(|w| w.to_bits()).collect::<Vec<_>>())
        };
        assert_eq!(bits(found), bits(&alone), "problem {k}");
    }
}

#[test]
fn every_instruction_set_gives_each_lane_the_bits_of_its_own_solve() {
    for seed in [1, 2] {
        let base = mixed_problem(seed);
        assert_singles(&base, &in_lanes::<Lanes<pulp::Scalar512b>>(&base));
        #[cfg(target_arch = "x86_64")]
        {
            if pulp::x86::V3::try_new().is_some() {
                assert_singles(&base, &in_lanes::<Lanes<pulp::x86::V3_512b>>(&base));
            }
            if pulp::x86::V4::try_new().is_some() {
                assert_singles(&base, &in_lanes::<Lanes<pulp::x86::V4>>(&base));
            }
        }
    }
}

/// Some take longer than the others of their cohort, and end among those of another.
#[test]
fn stragglers_move_to_other_lanes_and_keep_their_bits() {
    let base = mixed_problem(3);
    let solved = in_lanes::<Lanes<pulp::Scalar512b>>(&base);
    let iterations = |s: &Solution| s.iterations;
    assert!(solved.iter().map(iterations).max() > solved.iter().map(iterations).min());
    assert_singles(&base, &solved);
}

/// Good points, points that are far off, and points that are none, side by side.
#[test]
fn lanes_start_warm_fall_back_and_start_again_as_a_single_solve_does() {
    let base = mixed_problem(1);
    let mut points = in_lanes::<Lanes<pulp::Scalar512b>>(&base);
    for (k, point) in points.iter_mut().enumerate() {
        match k % 3 {
            1 => point.z.iter_mut().for_each(|z| *z *= 1e12),
            2 if k % 2 == 0 => point.x[0] = f64::NAN,
            _ => {}
        }
    }
    let start = |k: usize| Start::from(&points[k]);
    let solved = in_lanes_from::<Lanes<pulp::Scalar512b>>(&base, Some(&start));
    assert_singles_from(&base, &solved, Some(&start));
    for ending in [WarmStart::Used, WarmStart::FellBack] {
        assert!(solved.iter().any(|s| s.warm_start == ending), "{ending:?}");
    }
    let threads = solve_batch_from(&base, COUNT, written, start, &Settings::default(), 2).unwrap();
    assert_singles_from(&base, &threads, Some(&start));
}

#[allow(clippy::unnecessary_wraps)] // the shape a batch wants
fn written(k: usize, problem: &mut Problem) -> Result<(), Error> {
    vary(k, problem);
    Ok(())
}

#[test]
fn a_point_of_another_size_is_refused() {
    let base = mixed_problem(1);
    let point = solve_batch(&base, 1, written, &Settings::default(), 1).unwrap().remove(0);
    let short = |_| Start { s: &point.s[1..], ..Start::from(&point) };
    let error = solve_batch_from(&base, 1, written, short, &Settings::default(), 1).unwrap_err();
    assert!(matches!(error, Error::Dimension { argument: "start.s", .. }), "{error}");
}

/// Solve a batch whose factorizations count as long, or not; `watch` is asked whether to go on.
fn watched(long: usize, max_time_s: f64, watch: &mut crate::batch::slots::Watch<'_>) -> Vec<Solution> {
    let base = mixed_problem(2);
    let structure = Arc::new(Structure::for_lanes(&base, crate::Ordering::Amd).unwrap());
    let settings = Settings { max_time_s, ..Settings::default() };
    let mut worker = LaneWorker::<Lanes<pulp::Scalar512b>>::new(&structure, &settings).unwrap();
    worker.cohort.long = long;
    let (mut next, mut solved) = (0, vec![None; COUNT]);
    let mut take = |problem: &mut Problem| {
        problem.copy_numbers(&base);
        vary(next, problem);
        next += 1;
        Ok((next <= COUNT).then_some(next - 1))
    };
    let mut done = |k: usize, solution| solved[k] = Some(solution);
    worker.work(&base, &mut take, None, &mut done, watch).unwrap();
    solved.into_iter().map(Option::unwrap).collect()
}

#[test]
fn long_factorizations_in_lanes_end_at_the_time_limit_and_when_told_to() {
    let plain = watched(usize::MAX, f64::INFINITY, &mut || ControlFlow::Continue(()));
    let long = watched(0, f64::INFINITY, &mut || ControlFlow::Continue(()));
    for (one, other) in plain.iter().zip(&long) {
        assert_eq!((one.status, one.iterations), (other.status, other.iterations));
        assert_eq!(one.x, other.x, "looking on changes no bit");
    }
    let late = watched(0, 1e-9, &mut || ControlFlow::Continue(()));
    let stopped = watched(0, f64::INFINITY, &mut || ControlFlow::Break(()));
    for (solutions, status) in [(late, crate::Status::MaxTime), (stopped, crate::Status::Interrupted)] {
        for solution in solutions {
            assert_eq!((solution.status, solution.iterations), (status, 0));
            assert!(solution.x.iter().all(|x| x.is_nan()), "before there was an iterate");
        }
    }
    let at_statistics = watched(usize::MAX, 1e-9, &mut || ControlFlow::Continue(()));
    assert!(at_statistics.iter().all(|s| s.status == crate::Status::MaxTime && s.x[0].is_finite()));
}
