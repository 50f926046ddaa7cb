//! One engine, many solves: the same bits each time, and nothing of one solve in the next.

use crate::known::{generated, infeasible, solvable, unbounded, Data};
use orbsoc::{
    Buffer, Engine, Error, Event, Outcome, Problem, Settings, Solution, Stage, Status, CLOSING, ITERATION,
    STARTUP,
};

/// Every number of a solution, as words.
pub fn words(at: &Solution) -> Vec<u64> {
    let lists = [&at.x, &at.y, &at.z, &at.s].into_iter().flatten().copied();
    let c = &at.certificate;
    let numbers = [at.objective, at.dual_objective, c.primal_residual, c.dual_residual, c.gap, c.radius];
    let counts = [u64::from(at.iterations), u64::from(at.refinements), at.status as u64];
    lists.chain(numbers).map(f64::to_bits).chain(counts).collect()
}

/// The words of every buffer.
fn memory(engine: &Engine<f64>) -> Vec<Vec<u64>> {
    let bits = |buffer: &Buffer| engine.buffer(*buffer).iter().map(|v| v.to_bits()).collect();
    Buffer::ALL.iter().map(bits).collect()
}

fn all() -> Vec<(&'static str, Data)> {
    let known = solvable().into_iter().map(|(name, data, _)| (name, data));
    known.chain(infeasible()).chain(unbounded()).chain([("generated", generated(3).0)]).collect()
}

#[test]
fn a_hundred_runs_have_the_same_words_in_every_buffer() {
    let mut engine = Engine::<f64>::new(&generated(0).0.problem(), &Settings::default()).unwrap();
    let first = words(&engine.solve());
    let (buffers, events) = (memory(&engine), engine.events().to_vec());
    for _ in 0..100 {
        assert_eq!(words(&engine.solve()), first);
        assert_eq!(engine.events(), events);
    }
    assert_eq!(memory(&engine), buffers);
}

#[test]
fn two_engines_on_two_threads_have_the_same_words() {
    let problem = generated(1).0.problem();
    let run = || words(&Engine::<f64>::new(&problem, &Settings::default()).unwrap().solve());
    let (here, there) = std::thread::scope(|scope| {
        let there = scope.spawn(run);
        (run(), there.join().unwrap())
    });
    assert_eq!(here, there);
}

#[test]
fn an_engine_may_move_to_another_thread() {
    fn is_send<T: Send>(_: &T) {}
    let mut engine = Engine::<f64>::new(&generated(1).0.problem(), &Settings::default()).unwrap();
    is_send(&engine);
    let here = words(&engine.solve());
    let there = std::thread::spawn(move || words(&engine.solve())).join().unwrap();
    assert_eq!(here, there);
}

#[test]
fn updating_gives_the_words_of_a_fresh_engine_whatever_was_solved_before() {
    // The same pattern throughout: the generator's data are dense.
    let settings = Settings::default();
    let target = generated(5).0;
    let fresh = words(&Engine::<f64>::new(&target.problem(), &settings).unwrap().solve());
    let mut infeasible = generated(6).0;
    // Rows 0 and 1 contradict each other: gᵀx ≤ −1 and −gᵀx ≤ −1.
    infeasible.g[1] = infeasible.g[0].iter().map(|v| -v).collect();
    (infeasible.h[0], infeasible.h[1]) = (-1.0, -1.0);
    let mut scaled = generated(7).0;
    scaled.g.iter_mut().flatten().chain(&mut scaled.h).for_each(|v| *v *= 1e4);
    for (before, expected) in [(infeasible, Status::PrimalInfeasible), (scaled, Status::Solved)] {
        let mut engine = Engine::<f64>::new(&before.problem(), &settings).unwrap();
        let solution = engine.solve();
        assert_eq!(solution.status, expected, "{}", solution.message);
        engine.update(&target.problem()).unwrap();
        assert!(engine.events().is_empty(), "an update forgets the last solve");
        assert_eq!(words(&engine.solve()), fresh);
        engine.update(&before.problem()).unwrap();
        assert_eq!(words(&engine.solve()), words(&solution));
    }
}

#[test]
fn an_update_that_is_refused_leaves_the_engine_as_it_was() {
    let mut engine = Engine::<f64>::new(&generated(0).0.problem(), &Settings::default()).unwrap();
    let before = words(&engine.solve());
    let (mut other, _) = generated(1);
    other.g[0][0] = 0.0;
    assert_eq!(engine.update(&other.problem()), Err(Error::PatternChanged { argument: "G" }));
    assert_eq!(words(&engine.solve()), before);
}

#[test]
fn running_the_lists_by_hand_is_solving() {
    for (name, data) in all() {
        let (problem, settings) = (data.problem(), Settings::default());
        let mut engine = Engine::<f64>::new(&problem, &settings).unwrap();
        let solution = engine.solve();
        let mut by_hand = Engine::<f64>::new(&problem, &settings).unwrap();
        let mut run = |stage| by_hand.run(stage);
        assert!(STARTUP.iter().all(|step| step.perform(&mut run) == Outcome::Next));
        while ITERATION.iter().all(|step| step.perform(&mut run) == Outcome::Next) {}
        assert!(CLOSING.iter().all(|step| step.perform(&mut run) == Outcome::Next));
        assert_eq!(words(&by_hand.conclude()), words(&solution), "{name}");
        assert_eq!(memory(&by_hand), memory(&engine), "{name}");
        assert_eq!(by_hand.events(), engine.events(), "{name}");
    }
}

#[test]
fn events_are_the_stages_with_their_iterations() {
    let mut engine = Engine::<f64>::new(&solvable()[0].1.problem(), &Settings::default()).unwrap();
    let solution = engine.solve();
    let events = engine.events();
    assert_eq!(events[0], Event { stage: Stage::Equilibrate, iteration: 0 });
    assert_eq!(events.last(), Some(&Event { stage: Stage::Unscale, iteration: solution.iterations }));
    let runs = |stage| events.iter().filter(|event| event.stage == stage).count();
    let iterations = solution.iterations as usize;
    assert_eq!(runs(Stage::Advance), iterations);
    assert_eq!(runs(Stage::Statistics), iterations + 1);
    assert_eq!(runs(Stage::Factorize), iterations + 1);
    assert_eq!(runs(Stage::SolveConstantAndPredictor), iterations + 1);
    assert_eq!(runs(Stage::SolveKkt), iterations);
    assert_eq!(
        runs(Stage::RefineConstantAndPredictor) + runs(Stage::RefineKkt),
        solution.refinements as usize
    );
    assert_eq!(
        runs(Stage::CheckConstantAndPredictor),
        runs(Stage::SolveConstantAndPredictor) + runs(Stage::RefineConstantAndPredictor)
    );
    assert_eq!(runs(Stage::CheckSolve), runs(Stage::SolveKkt) + runs(Stage::RefineKkt));
    assert_eq!(engine.iteration(), solution.iterations);
}

/// A problem whose cost factor depends on c, with other numbers in c, b and h, and then in a matrix.
fn updated(data: &Data) -> [Problem; 3] {
    let first = data.problem();
    let times = |numbers: &[f64], factor: f64| -> Vec<f64> { numbers.iter().map(|v| factor * v).collect() };
    let mut second = first.clone();
    second.set_c(&times(first.c(), 300.0)).unwrap();
    second.set_b(&times(first.b(), 1.5)).unwrap();
    second.set_h(&times(first.h(), 1.5)).unwrap();
    let mut third = second.clone();
    third.set_g_values(&times(first.g().values(), 2.0)).unwrap();
    [first, second, third]
}

#[test]
fn an_update_has_the_words_of_a_fresh_engine_whatever_it_leaves_as_it_was() {
    for (name, data) in all() {
        let problems = updated(&data);
        let mut engine = Engine::<f64>::new(&problems[0], &Settings::default()).unwrap();
        for k in [0, 1, 0, 2, 2, 1, 1] {
            engine.update(&problems[k]).unwrap();
            let mut fresh = Engine::<f64>::new(&problems[k], &Settings::default()).unwrap();
            assert_eq!(words(&engine.solve()), words(&fresh.solve()), "{name}, problem {k}");
            for buffer in [Buffer::P, Buffer::A, Buffer::G, Buffer::Q, Buffer::CostScale, Buffer::KktValues] {
                let bits = |engine: &Engine<f64>| -> Vec<u64> {
                    engine.buffer(buffer).iter().map(|v| v.to_bits()).collect()
                };
                assert_eq!(bits(&engine), bits(&fresh), "{name}, problem {k}, {}", buffer.name());
            }
        }
    }
}

#[test]
fn buffers_written_from_outside_are_equilibrated_anew() {
    let problem = generated(3).0.problem();
    let mut engine = Engine::<f64>::new(&problem, &Settings::default()).unwrap();
    let first = words(&engine.solve());
    engine.buffer_mut(Buffer::Scale).fill(1.0);
    engine.buffer_mut(Buffer::KktValues).fill(1.0);
    assert_eq!(words(&engine.solve()), first);
}
