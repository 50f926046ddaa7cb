//! One solve in two precisions: chosen modules in a narrow arithmetic, everything else in binary64.

use crate::error::Error;
use crate::method::stage::{Module, Outcome, Stage};
use crate::method::{datapath::Datapath, engine::Engine, workspace::Workspace};
use crate::problem::{Problem, Settings};
use crate::real::{Decide, Reduced};
use std::sync::Arc;

/// A narrow arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Narrow {
    Binary32,
    /// This many significant bits with binary64's exponents: 12, 16 or 20.
    Bits(u32),
}

/// An engine whose stages of some modules compute in a narrow arithmetic on entries of their own.
///
/// What such a stage reads is rounded on its way there, and what it writes comes back exactly. A loop
/// over the method's lists drives it stage by stage, as it drives an [`Engine`].
pub struct MixedEngine {
    wide: Engine<f64>,
    narrow: Box<dyn Arithmetic>,
    modules: Vec<Module>,
}

/// A narrow arithmetic's buffers, whatever its type.
trait Arithmetic: Send {
    fn execute(&mut self, stage: Stage, wide: &mut Workspace<f64>);
}

impl<T: Decide> Arithmetic for Datapath<T> {
    fn execute(&mut self, stage: Stage, wide: &mut Workspace<f64>) {
        // What a stage writes in part comes back whole, so it goes there too.
        for &buffer in stage.reads().iter().chain(stage.writes()) {
            for (entry, &value) in self.work.get_mut(buffer).iter_mut().zip(wide.get(buffer)) {
                entry.set_lane(0, value);
            }
        }
        Datapath::execute(self, stage);
        for &buffer in stage.writes() {
            for (value, entry) in wide.get_mut(buffer).iter_mut().zip(self.work.get(buffer)) {
                *value = entry.value();
            }
        }
    }
}

impl MixedEngine {
    /// Analyse the pattern, allocate, load the data; stages of `modules` compute in `narrow`.
    ///
    /// # Errors
    /// As [`Engine::new`], or [`Error::Setting`] for a number of bits that there is no arithmetic for.
    pub fn new(
        problem: &Problem,
        settings: &Settings,
        narrow: Narrow,
        modules: &[Module],
    ) -> Result<Self, Error> {
        let wide = Engine::new(problem, settings)?;
        let narrow: Box<dyn Arithmetic> = match narrow {
            Narrow::Binary32 => arithmetic::<f32>(&wide, settings)?,
            Narrow::Bits(12) => arithmetic::<Reduced<12>>(&wide, settings)?,
            Narrow::Bits(16) => arithmetic::<Reduced<16>>(&wide, settings)?,
            Narrow::Bits(20) => arithmetic::<Reduced<20>>(&wide, settings)?,
            Narrow::Bits(bits) => {
                let allowed = "12, 16 or 20 (or binary32, which has 24)";
                return Err(Error::Setting { name: "significant bits", value: f64::from(bits), allowed });
            }
        };
        Ok(Self { wide, narrow, modules: modules.to_vec() })
    }

    /// Run one stage where it belongs and say how to go on.
    pub fn run(&mut self, stage: Stage) -> Outcome {
        let Self { wide, narrow, modules } = self;
        if modules.contains(&stage.module()) {
            wide.run_with(stage, |path, _| narrow.execute(stage, &mut path.work))
        } else {
            wide.run(stage)
        }
    }

    /// Stop at the next statistics.
    pub fn interrupt(&mut self) {
        self.wide.interrupt();
    }

    /// The solve in binary64: what ran, its buffers and sizes, the outcome, which is verified on the data as given.
    pub fn wide(&self) -> &Engine<f64> {
        &self.wide
    }
}

fn arithmetic<T: Decide>(wide: &Engine<f64>, settings: &Settings) -> Result<Box<dyn Arithmetic>, Error> {
    Ok(Box::new(Datapath::<T>::new(Arc::clone(&wide.path.structure), settings)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::stage::{Step, CLOSING, ITERATION, STARTUP};
    use crate::{Buffer, Cones, Csc, Solution, Status};

    const ALL: [Module; 6] = [
        Module::MatrixUpdate,
        Module::MatrixScaling,
        Module::Factorization,
        Module::LinearSolve,
        Module::ConeOps,
        Module::LineSearch,
    ];

    /// min x₀ + 2x₁ + 3x₂ on the simplex inside a ball.
    fn problem() -> Problem {
        let g = [
            [-1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, -1.0],
            [0.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, -1.0],
        ];
        let rows: Vec<&[f64]> = g.iter().map(|row| &row[..]).collect();
        let h = vec![0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0];
        Problem::new(
            None,
            vec![1.0, 2.0, 3.0],
            Some(Csc::from_dense(&[&[1.0, 1.0, 1.0]], 3)),
            vec![1.0],
            Some(Csc::from_dense(&rows, 3)),
            h,
            Cones { l: 3, q: vec![4] },
        )
        .unwrap()
    }

    fn attempt(engine: &mut MixedEngine) -> Solution {
        let perform = |engine: &mut MixedEngine, step: Step| match step {
            Step::Run(stage) => engine.run(stage),
            Step::Repeat { stage, until } => loop {
                match engine.run(until) {
                    Outcome::Repeat => engine.run(stage),
                    other => return other,
                };
            },
        };
        for step in STARTUP {
            perform(engine, *step);
        }
        while !ITERATION.iter().any(|step| matches!(perform(engine, *step), Outcome::Done(_))) {}
        for step in CLOSING {
            perform(engine, *step);
        }
        engine.wide().conclude()
    }

    #[test]
    fn without_a_narrow_module_the_bits_are_those_of_the_engine() {
        let settings = Settings::default();
        let mixed = attempt(&mut MixedEngine::new(&problem(), &settings, Narrow::Binary32, &[]).unwrap());
        let plain = crate::solve(&problem(), &settings).unwrap();
        assert_eq!((mixed.iterations, mixed.status), (plain.iterations, plain.status));
        assert!(mixed.x.iter().zip(&plain.x).all(|(a, b)| a.to_bits() == b.to_bits()));
    }

    #[test]
    fn a_narrow_factor_refined_in_binary64_reaches_a_tolerance_below_its_own() {
        let settings = Settings {
            tol: 1e-6,
            static_regularization: 3e-4,
            pivot_floor: 3e-6,
            dynamic_regularization: 3e-3,
            refinement_max: 50,
            ..Settings::default()
        };
        let modules = [Module::Factorization];
        let solution =
            attempt(&mut MixedEngine::new(&problem(), &settings, Narrow::Binary32, &modules).unwrap());
        assert_eq!(solution.status, Status::Solved, "{}", solution.message);
        assert!(solution.certificate.worst() <= settings.tol);
        let wide = crate::solve(&problem(), &Settings { tol: 1e-6, ..Settings::default() }).unwrap();
        assert!(solution.refinements > wide.refinements);
    }

    #[test]
    fn what_narrow_stages_write_has_few_bits_and_a_claim_is_still_true() {
        let settings = Settings::single_precision();
        for narrow in [Narrow::Binary32, Narrow::Bits(20), Narrow::Bits(16), Narrow::Bits(12)] {
            let mut engine = MixedEngine::new(&problem(), &settings, narrow, &ALL).unwrap();
            let solution = attempt(&mut engine);
            if solution.status == Status::Solved {
                assert!(solution.certificate.worst() <= settings.tol, "{narrow:?}");
            }
            let dropped = match narrow {
                Narrow::Binary32 => 29,
                Narrow::Bits(bits) => 53 - bits,
            };
            let factor = engine.wide().buffer(Buffer::FactorL);
            assert!(factor.iter().all(|entry| entry.to_bits().trailing_zeros() >= dropped), "{narrow:?}");
        }
    }

    #[test]
    fn an_arithmetic_that_does_not_exist_is_refused() {
        let refused = MixedEngine::new(&problem(), &Settings::default(), Narrow::Bits(17), &ALL);
        assert!(matches!(refused.err(), Some(Error::Setting { name: "significant bits", .. })));
    }
}
