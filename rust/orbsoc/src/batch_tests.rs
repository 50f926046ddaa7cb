//! Every instruction set's lanes, whatever the machine would choose by itself.

use super::Crew;
use crate::oracle::{mixed_problem, Numbers};
use crate::real::{Decide, Lanes};
use crate::structure::Structure;
use crate::supernode::Panels;
use crate::{Engine, Problem, Settings, Solution};
use std::sync::Arc;

const COUNT: usize = 21;

fn vary(k: usize, problem: &mut Problem) {
    let c = Numbers(k as u64 + 50).list(problem.n());
    problem.set_c(&c).unwrap();
}

fn in_lanes<T: Decide>(base: &Problem) -> Vec<Solution> {
    let structure = Arc::new(Structure::new(base, Panels::Relaxed).unwrap());
    let mut crew = Crew::<T>::new(&structure, &Settings::default()).unwrap();
    let (mut next, mut solved) = (0, vec![None; COUNT]);
    let take = |problem: &mut Problem| {
        problem.copy_numbers(base);
        vary(next, problem);
        next += 1;
        Ok((next <= COUNT).then_some(next - 1))
    };
    crew.work(base, take, |k, solution| solved[k] = Some(solution)).unwrap();
    solved.into_iter().map(Option::unwrap).collect()
}

fn assert_singles(base: &Problem, solved: &[Solution]) {
    for (k, found) in solved.iter().enumerate() {
        let mut problem = base.clone();
        vary(k, &mut problem);
        let alone = Engine::<f64>::new(&problem, &Settings::default()).unwrap().solve();
        assert_eq!((found.status, found.iterations), (alone.status, alone.iterations), "problem {k}");
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

/// Half the lanes end before the others: the next problems join those that still run.
#[test]
fn lanes_are_filled_while_others_run() {
    let base = mixed_problem(3);
    let solved = in_lanes::<Lanes<pulp::Scalar512b>>(&base);
    let iterations = |s: &Solution| s.iterations;
    assert!(solved.iter().map(iterations).max() > solved.iter().map(iterations).min());
    assert_singles(&base, &solved);
}
