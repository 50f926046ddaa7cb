//! Warm starts: what they return is worth as much as what a cold start returns.

use crate::engine::words;
use crate::known::{generated, infeasible, solvable, Data};
use orbsoc::{Engine, Error, Outcome, Settings, Solution, Start, Status, Step, WarmStart};
use orbsoc::{CLOSING, ITERATION, STARTUP, WARM_STARTUP};

fn engine(data: &Data) -> Engine<f64> {
    Engine::new(&data.problem(), &Settings::default()).unwrap()
}

fn from(data: &Data, start: &Solution) -> Solution {
    engine(data).solve_from(&Start::from(start)).unwrap()
}

/// The same problem with every number of c, b and h moved by up to `share`, alternately up and down.
fn moved(data: &Data, share: f64) -> Data {
    let mut out = data.clone();
    let numbers = out.c.iter_mut().chain(&mut out.b).chain(&mut out.h);
    numbers.enumerate().for_each(|(k, v)| *v *= 1.0 + if k % 2 == 0 { share } else { -share });
    out
}

#[test]
fn the_same_problem_is_solved_before_the_first_step() {
    for (name, data, _) in solvable() {
        let cold = engine(&data).solve();
        let warm = from(&data, &cold);
        assert_eq!((warm.status, warm.warm_start), (Status::Solved, WarmStart::Used), "{name}");
        assert!(warm.iterations <= 1, "{name}: {} iterations", warm.iterations);
    }
}

#[test]
fn a_nearby_problem_takes_half_the_iterations_and_is_solved_as_well() {
    let (mut warm_total, mut cold_total) = (0, 0);
    for seed in 0..40 {
        let data = generated(seed).0;
        let before = engine(&data).solve();
        let new = moved(&data, 0.01);
        let (cold, warm) = (engine(&new).solve(), from(&new, &before));
        assert_eq!(warm.status, cold.status, "seed {seed}");
        let counts = (warm.iterations, cold.iterations);
        assert!(warm.iterations <= cold.iterations + 1, "seed {seed}: {counts:?} {:?}", warm.warm_start);
        if warm.status == Status::Solved {
            let (primal, dual, gap) = new.residuals(&warm);
            assert!(primal.max(dual).max(gap) <= 1e-6, "seed {seed}");
            assert!((warm.objective - cold.objective).abs() <= 1e-6 * (1.0 + cold.objective.abs()));
        }
        warm_total += warm.iterations;
        cold_total += cold.iterations;
    }
    assert!(2 * warm_total <= cold_total, "{warm_total} warm, {cold_total} cold");
}

#[test]
fn any_start_at_all_ends_like_a_cold_one() {
    let starts: [fn(usize) -> f64; 4] =
        [|_| 0.0, |k| if k % 2 == 0 { 1e8 } else { -1e8 }, |_| 1e300, |k| -(k as f64) - 1.0];
    let known = solvable().into_iter().map(|(name, data, _)| (name, data));
    for (name, data) in known.chain(infeasible()) {
        let cold = engine(&data).solve();
        for (k, word) in starts.iter().enumerate() {
            let list = |n: usize| (0..n).map(word).collect::<Vec<f64>>();
            let (x, y, z) = (list(data.c.len()), list(data.b.len()), list(data.h.len()));
            let start = Start { x: &x, y: &y, z: &z, s: &z };
            let warm = engine(&data).solve_from(&start).unwrap();
            assert_eq!(warm.status, cold.status, "{name}, start {k}");
            assert_ne!(warm.warm_start, WarmStart::None);
        }
    }
}

#[test]
fn a_point_that_is_not_finite_is_answered_by_a_cold_start_bit_for_bit() {
    let (_, solvable, _) = solvable().swap_remove(0);
    let cold = engine(&solvable).solve();
    for value in [f64::NAN, f64::INFINITY] {
        let mut broken = cold.clone();
        broken.x[0] = value;
        let warm = from(&solvable, &broken);
        assert_eq!(warm.warm_start, WarmStart::FellBack);
        assert_eq!(words(&warm), words(&cold));
    }
    // What an infeasible problem returned is such a point: its x is not a number.
    let (_, data) = infeasible().swap_remove(0);
    let claim = engine(&data).solve();
    assert_eq!(from(&data, &claim).warm_start, WarmStart::FellBack);
}

#[test]
fn a_start_of_another_size_is_an_error_that_names_the_vector() {
    let (_, data, _) = solvable().swap_remove(0);
    let cold = engine(&data).solve();
    let short = Start { s: &cold.s[1..], ..Start::from(&cold) };
    let error = engine(&data).solve_from(&short).unwrap_err();
    let (found, expected) = (data.h.len() - 1, data.h.len());
    assert_eq!(
        error,
        Error::Dimension {
            argument: "start.s",
            found,
            unit: "entries",
            expected,
            reason: "the problem needs"
        }
    );
}

#[test]
fn a_warm_start_leaves_nothing_behind() {
    let (data, new) = (generated(2).0, moved(&generated(2).0, 0.01));
    let mut reused = engine(&data);
    let before = reused.solve();
    reused.update(&new.problem()).unwrap();
    let start = Start::from(&before);
    let warm = reused.solve_from(&start).unwrap();
    assert_eq!(words(&warm), words(&engine(&new).solve_from(&start).unwrap()));
    assert_eq!(words(&reused.solve()), words(&engine(&new).solve()), "cold after warm");
    assert_eq!(words(&reused.solve_from(&start).unwrap()), words(&warm), "warm after cold");
}

#[test]
fn running_the_lists_by_hand_gives_the_same_bits() {
    let (data, new) = (generated(5).0, moved(&generated(5).0, 0.01));
    let before = engine(&data).solve();
    let mut by_hand = engine(&new);
    let mut list = if by_hand.start_from(&Start::from(&before)).unwrap() { WARM_STARTUP } else { STARTUP };
    let solution = loop {
        if !follow(&mut by_hand, list) {
            while !follow(&mut by_hand, ITERATION) {}
        }
        follow(&mut by_hand, CLOSING);
        let solution = by_hand.conclude();
        if !by_hand.restart(&solution) {
            break solution;
        }
        list = STARTUP;
    };
    assert_eq!(words(&solution), words(&from(&new, &before)));
}

fn follow(engine: &mut Engine<f64>, list: &[Step]) -> bool {
    list.iter().any(|step| matches!(step.perform(&mut |stage| engine.run(stage)), Outcome::Done(_)))
}

#[test]
fn a_start_given_up_is_counted() {
    // From far outside, the first steps are short: the solve begins again, and says what it cost.
    let (_, data, _) = solvable().swap_remove(0);
    let cold = engine(&data).solve();
    let far = Solution { x: cold.x.iter().map(|x| x + 1e6).collect(), ..cold.clone() };
    let warm = from(&data, &far);
    assert_eq!((warm.status, warm.warm_start), (Status::Solved, WarmStart::FellBack));
    assert_eq!(warm.iterations, cold.iterations, "given up before its first step");
    assert_eq!(warm.x, cold.x);
}

#[test]
fn without_restarts_a_start_that_is_given_up_ends_the_solve() {
    let (_, data, _) = solvable().swap_remove(0);
    let cold = engine(&data).solve();
    let far = Solution { x: cold.x.iter().map(|x| x + 1e6).collect(), ..cold.clone() };
    let limited = |max_restarts, start: &Solution| {
        let settings = Settings { max_restarts, ..Settings::default() };
        let mut engine = Engine::<f64>::new(&data.problem(), &settings).unwrap();
        engine.solve_from(&Start::from(start)).unwrap()
    };
    let none = limited(0, &far);
    assert_eq!((none.status, none.warm_start, none.attempts), (Status::NumericalLimit, WarmStart::Used, 1));
    let one = limited(1, &far);
    assert_eq!((one.status, one.warm_start, one.attempts), (Status::Solved, WarmStart::FellBack, 2));
    assert_eq!(one.x, cold.x);
    // What is no point is not attempted.
    let nowhere = limited(0, &Solution { x: vec![f64::NAN; cold.x.len()], ..cold.clone() });
    assert_eq!(
        (nowhere.status, nowhere.warm_start, nowhere.attempts),
        (Status::Solved, WarmStart::FellBack, 1)
    );
    assert_eq!((cold.attempts, nowhere.x), (1, cold.x));
}
