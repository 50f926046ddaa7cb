//! The engine of two precisions as a Python object.

use crate::convert::{one_at_a_time, problem, refuse, settings};
use crate::engine::{raw_solution, stage_of, RawSolution, DONE, NEXT, REPEAT};
use orbsoc::{Buffer, Module, Narrow, Outcome, Stage};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

#[pyclass(module = "orbsoc._core", frozen)]
pub struct MixedEngine(Mutex<(orbsoc::MixedEngine, Duration)>);

#[pymethods]
impl MixedEngine {
    /// `bits` significant bits (24 is binary32) in the stages of `modules`, binary64 elsewhere.
    #[new]
    #[allow(clippy::needless_pass_by_value)] // what the binding hands over is owned
    fn new(
        py: Python<'_>,
        problem_: &Bound<'_, PyAny>,
        settings_: &Bound<'_, PyAny>,
        bits: u32,
        modules: Vec<String>,
    ) -> PyResult<Self> {
        let (problem, settings) = (problem(problem_)?, settings(settings_)?);
        let modules = modules.iter().map(|name| module_of(name)).collect::<PyResult<Vec<_>>>()?;
        let narrow = if bits == 24 { Narrow::Binary32 } else { Narrow::Bits(bits) };
        py.detach(|| {
            let start = Instant::now();
            let inner = orbsoc::MixedEngine::new(&problem, &settings, narrow, &modules).map_err(refuse)?;
            Ok(Self(Mutex::new((inner, start.elapsed()))))
        })
    }

    /// Run one stage: NEXT, REPEAT or DONE.
    fn run(&self, stage: &str) -> PyResult<u8> {
        Ok(match self.state()?.0.run(stage_of(stage)?) {
            Outcome::Next => NEXT,
            Outcome::Repeat => REPEAT,
            Outcome::Done(_) => DONE,
        })
    }

    /// Stop at the next statistics.
    fn interrupt(&self) -> PyResult<()> {
        self.state()?.0.interrupt();
        Ok(())
    }

    /// The solution of a finished attempt; `solve_s` is the caller's measurement.
    #[pyo3(signature = (solve_s=0.0))]
    fn finish(&self, py: Python<'_>, solve_s: f64) -> PyResult<RawSolution> {
        let state = self.state()?;
        let elapsed = Duration::try_from_secs_f64(solve_s).unwrap_or_default();
        Ok(raw_solution(py, state.0.wide().conclude(), state.0.wide().kkt_sizes(), (state.1, elapsed)))
    }

    fn events(&self) -> PyResult<Vec<(&'static str, u32)>> {
        Ok(self.state()?.0.wide().events().iter().map(|e| (e.stage.name(), e.iteration)).collect())
    }

    fn buffer_words<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (state, words) = (self.state()?, PyDict::new(py));
        for &buffer in Buffer::ALL {
            words.set_item(buffer.name(), state.0.wide().buffer(buffer).len())?;
        }
        Ok(words)
    }
}

impl MixedEngine {
    fn state(&self) -> PyResult<MutexGuard<'_, (orbsoc::MixedEngine, Duration)>> {
        one_at_a_time(&self.0)
    }
}

fn module_of(name: &str) -> PyResult<Module> {
    let modules = || Stage::ALL.iter().map(|stage| stage.module());
    let found = modules().find(|module| module.name() == name);
    found.ok_or_else(|| {
        let mut known: Vec<&str> = modules().map(Module::name).collect();
        known.sort_unstable();
        known.dedup();
        PyValueError::new_err(format!("no module named {name:?}; modules are {}", known.join(", ")))
    })
}
