//! What ends a solve within a long factorization, and what that leaves.

use crate::tests::reference::mixed_problem;
use crate::{Engine, Observer, Progress, Settings, Stage, Status, CLOSING};
use core::ops::ControlFlow;

/// Interrupts at the `last` question within factorizations, and counts both kinds.
#[derive(Default)]
struct Counting {
    iterations: usize,
    waits: usize,
    last: Option<usize>,
}

impl Observer for Counting {
    fn iterated(&mut self, _: &Progress) -> ControlFlow<()> {
        self.iterations += 1;
        ControlFlow::Continue(())
    }

    fn waited(&mut self) -> ControlFlow<()> {
        self.waits += 1;
        if self.last == Some(self.waits) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

fn watched(settings: &Settings) -> Engine<f64> {
    let mut engine = Engine::new(&mixed_problem(9), settings).unwrap();
    engine.long = 0;
    engine
}

fn before_closing(engine: &Engine<f64>) -> Stage {
    engine.events()[engine.events().len() - CLOSING.len() - 1].stage
}

#[test]
fn a_watched_solve_is_the_same_and_a_short_one_is_not_watched() {
    let (mut plain, mut engine) = (watched(&Settings::default()), watched(&Settings::default()));
    plain.long = usize::MAX;
    let (mut one, mut other) = (Counting::default(), Counting::default());
    let (expected, found) = (plain.solve_watched(&mut one), engine.solve_watched(&mut other));
    assert_eq!((&found.x, &found.z, found.status), (&expected.x, &expected.z, Status::Solved));
    assert_eq!(engine.events(), plain.events());
    assert_eq!((one.waits, one.iterations), (0, other.iterations));
    assert!(other.waits > 2 * other.iterations);
}

#[test]
fn an_interrupt_within_a_factorization_ends_the_solve_there_with_the_best_iterate() {
    let mut whole = Counting::default();
    watched(&Settings::default()).solve_watched(&mut whole);
    for last in [1, 2, whole.waits / 2] {
        let mut engine = watched(&Settings::default());
        let mut observer = Counting { last: Some(last), ..Counting::default() };
        let found = engine.solve_watched(&mut observer);
        assert_eq!(found.status, Status::Interrupted);
        assert_eq!((observer.waits, before_closing(&engine)), (last, Stage::Factorize));
        assert_eq!(found.x.iter().all(|x| x.is_finite()), observer.iterations > 0);
        assert_eq!(found.message.contains("before there was one"), observer.iterations == 0);
        assert_eq!(engine.solve().status, Status::Solved, "the engine is as good as new");
    }
}

#[test]
fn a_time_limit_ends_a_factorization_not_the_next_statistics() {
    let mut engine = watched(&Settings { max_time_s: 1e-9, ..Settings::default() });
    let cut = engine.solve();
    assert_eq!(cut.status, Status::MaxTime);
    assert!(cut.message.contains("before there was one; raise max_time_s"), "{}", cut.message);
    assert_eq!(before_closing(&engine), Stage::Factorize);
    engine.long = usize::MAX;
    assert_eq!(engine.solve().status, Status::MaxTime);
    assert_eq!(before_closing(&engine), Stage::Statistics);
}
