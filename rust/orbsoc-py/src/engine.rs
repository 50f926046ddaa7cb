//! The engine as a Python object.

use crate::convert::{one_at_a_time, problem, refuse, replace_numbers, settings};
use crate::method::RestartInfo;
use crate::watch::Watch;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use orbsoc::{Buffer, Error, Observer, Outcome, Problem, Progress, Solution, Stage, Start, Status};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

pub const NEXT: u8 = 0;
pub const REPEAT: u8 = 1;
pub const DONE: u8 = 2;

#[pyclass(module = "orbsoc._core", frozen, get_all)]
pub struct RawSolution {
    status: &'static str,
    x: Py<PyArray1<f64>>,
    y: Py<PyArray1<f64>>,
    z: Py<PyArray1<f64>>,
    s: Py<PyArray1<f64>>,
    objective: f64,
    dual_objective: f64,
    iterations: u32,
    refinements: u32,
    attempts: u32,
    primal_residual: f64,
    dual_residual: f64,
    gap: f64,
    radius: f64,
    message: String,
    setup_s: f64,
    solve_s: f64,
    nnz_kkt: usize,
    nnz_l: usize,
    warm_start: &'static str,
}

/// x, y, z, s.
pub type Point<'py> = [PyReadonlyArray1<'py, f64>; 4];

pub fn owned(point: &Point<'_>) -> [Vec<f64>; 4] {
    [0, 1, 2, 3].map(|k| point[k].as_array().to_vec())
}

pub fn borrowed([x, y, z, s]: &[Vec<f64>; 4]) -> Start<'_> {
    Start { x, y, z, s }
}

/// One solve at a time: a second thread, or the solve's own callback, gets an error.
#[pyclass(module = "orbsoc._core", frozen)]
pub struct Engine(Mutex<State>);

struct State {
    inner: orbsoc::Engine<f64>,
    /// The problem that the next update changes; between updates, equal to the engine's.
    problem: Arc<Problem>,
    setup: Duration,
}

#[pymethods]
impl Engine {
    #[new]
    fn new(py: Python<'_>, problem_: &Bound<'_, PyAny>, settings_: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (problem, settings) = (problem(problem_)?, settings(settings_)?);
        py.detach(|| {
            let start = Instant::now();
            let inner = orbsoc::Engine::shared(&problem, &settings).map_err(refuse)?;
            let setup = start.elapsed();
            Ok(Self(Mutex::new(State { inner, problem, setup })))
        })
    }

    fn update(&self, py: Python<'_>, problem_: &Bound<'_, PyAny>) -> PyResult<()> {
        let problem = problem(problem_)?;
        let state = &mut *self.state()?;
        state.problem = problem;
        py.detach(|| state.update()).map_err(refuse)
    }

    /// Fast path of the same for plain data: float64 vectors c, b, h and matrices A, G of the same pattern, by name.
    /// Returns false, and changes nothing, if any of it is not plain.
    fn update_numbers(&self, py: Python<'_>, data: &Bound<'_, PyDict>) -> PyResult<bool> {
        let state = &mut *self.state()?;
        if replace_numbers(Arc::make_mut(&mut state.problem), data)? {
            return Ok(py.detach(|| state.update()).is_ok());
        }
        Arc::make_mut(&mut state.problem).clone_from(state.inner.problem());
        Ok(false)
    }

    /// The present c, b, h, and entries of A and G.
    fn numbers<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyArray1<f64>>; 5]> {
        let problem = &self.state()?.problem;
        let words = [problem.c(), problem.b(), problem.h(), problem.a().values(), problem.g().values()];
        Ok(words.map(|w| PyArray1::from_slice(py, w)))
    }

    /// Solve with the GIL released, from `start` = (x, y, z, s) if it is given; `callback(progress)`
    /// returning true stops the solve.
    #[pyo3(signature = (callback=None, start=None))]
    #[allow(clippy::needless_pass_by_value)] // what the binding hands over is owned
    fn solve(
        &self,
        py: Python<'_>,
        callback: Option<Py<PyAny>>,
        start: Option<Point<'_>>,
    ) -> PyResult<RawSolution> {
        let start = start.as_ref().map(owned);
        let mut watch = Watch::new(callback.as_ref());
        let state = &mut *self.state()?;
        let inner = &mut state.inner;
        let (solution, elapsed) = py.detach(|| {
            let clock = Instant::now();
            let observer = &mut Observing(&mut watch);
            let solution = match &start {
                Some(from) => inner.solve_from_watched(&borrowed(from), observer),
                None => Ok(inner.solve_watched(observer)),
            };
            (solution, clock.elapsed())
        });
        watch.conclude(|| solution.as_ref().is_ok_and(|s| s.status == Status::Interrupted))?;
        Ok(state.raw(py, solution.map_err(refuse)?, elapsed))
    }

    /// Load a starting point. Whether the warm start is accepted; if not, the caller runs the cold start.
    #[allow(clippy::needless_pass_by_value)] // what the binding hands over is owned
    fn start_from(&self, start: Point<'_>) -> PyResult<bool> {
        self.state()?.inner.start_from(&borrowed(&owned(&start))).map_err(refuse)
    }

    /// The restart that is to follow the attempt that ended.
    fn next_restart(&self) -> PyResult<Option<RestartInfo>> {
        let inner = &self.state()?.inner;
        Ok(inner.next_restart(&inner.conclude()).map(RestartInfo::from))
    }

    /// Get ready for that restart, where there is one, and say so.
    fn begin_again(&self) -> PyResult<bool> {
        let inner = &mut self.state()?.inner;
        let solution = inner.conclude();
        Ok(inner.restart(&solution))
    }

    /// Run one stage: NEXT, REPEAT or DONE.
    fn run(&self, stage: &str) -> PyResult<u8> {
        Ok(match self.state()?.inner.run(stage_of(stage)?) {
            Outcome::Next => NEXT,
            Outcome::Repeat => REPEAT,
            Outcome::Done(_) => DONE,
        })
    }

    /// Stop at the next statistics.
    fn interrupt(&self) -> PyResult<()> {
        self.state()?.inner.interrupt();
        Ok(())
    }

    /// The solution of a finished attempt; `solve_s` is the caller's measurement.
    #[pyo3(signature = (solve_s=0.0))]
    fn finish(&self, py: Python<'_>, solve_s: f64) -> PyResult<RawSolution> {
        let state = self.state()?;
        let elapsed = Duration::try_from_secs_f64(solve_s).unwrap_or_default();
        Ok(state.raw(py, state.inner.conclude(), elapsed))
    }

    #[getter]
    fn iteration(&self) -> PyResult<u32> {
        Ok(self.state()?.inner.iteration())
    }

    fn progress<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        progress_dict(py, &self.state()?.inner.progress())
    }

    fn events(&self) -> PyResult<Vec<(&'static str, u32)>> {
        Ok(self.state()?.inner.events().iter().map(|e| (e.stage.name(), e.iteration)).collect())
    }

    fn buffer<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let buffer = Buffer::ALL.iter().find(|b| b.name() == name);
        let buffer = buffer.ok_or_else(|| PyKeyError::new_err(format!("no buffer named {name:?}")))?;
        Ok(PyArray1::from_slice(py, self.state()?.inner.buffer(*buffer)))
    }

    fn buffer_words<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (state, words) = (self.state()?, PyDict::new(py));
        for &buffer in Buffer::ALL {
            words.set_item(buffer.name(), state.inner.buffer(buffer).len())?;
        }
        Ok(words)
    }
}

impl Engine {
    fn state(&self) -> PyResult<MutexGuard<'_, State>> {
        one_at_a_time(&self.0)
    }
}

impl State {
    /// Load `self.problem` into the engine; after an error, `self.problem` is the engine's old one.
    fn update(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        let updated = self.inner.update(&self.problem);
        match updated {
            Ok(()) => self.setup = start.elapsed(),
            Err(_) => Arc::make_mut(&mut self.problem).clone_from(self.inner.problem()),
        }
        updated
    }

    fn raw(&self, py: Python<'_>, solution: Solution, elapsed: Duration) -> RawSolution {
        raw_solution(py, solution, self.inner.kkt_sizes(), (self.setup, elapsed))
    }
}

/// A solution with the sizes of its KKT system and the times of set-up and solve.
pub fn raw_solution(
    py: Python<'_>,
    solution: Solution,
    (nnz_kkt, nnz_l): (usize, usize),
    (setup, elapsed): (Duration, Duration),
) -> RawSolution {
    let array = |v: Vec<f64>| v.into_pyarray(py).unbind();
    RawSolution {
        status: solution.status.name(),
        x: array(solution.x),
        y: array(solution.y),
        z: array(solution.z),
        s: array(solution.s),
        objective: solution.objective,
        dual_objective: solution.dual_objective,
        iterations: solution.iterations,
        refinements: solution.refinements,
        attempts: solution.attempts,
        primal_residual: solution.certificate.primal_residual,
        dual_residual: solution.certificate.dual_residual,
        gap: solution.certificate.gap,
        radius: solution.certificate.radius,
        message: solution.message,
        setup_s: setup.as_secs_f64(),
        solve_s: elapsed.as_secs_f64(),
        nnz_kkt,
        nnz_l,
        warm_start: solution.warm_start.name(),
    }
}

/// A solve that Python looks at.
struct Observing<'a, 'b>(&'a mut Watch<'b>);

impl Observer for Observing<'_, '_> {
    fn iterated(&mut self, progress: &Progress) -> ControlFlow<()> {
        self.0.look(|py| progress_dict(py, progress))
    }

    fn waited(&mut self) -> ControlFlow<()> {
        self.0.wait()
    }
}

fn progress_dict<'py>(py: Python<'py>, at: &Progress) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("iteration", at.iteration)?;
    out.set_item("objective", at.objective)?;
    out.set_item("dual_objective", at.dual_objective)?;
    out.set_item("primal_residual", at.primal_residual)?;
    out.set_item("dual_residual", at.dual_residual)?;
    out.set_item("gap", at.gap)?;
    out.set_item("mu", at.mu)?;
    out.set_item("step", at.step)?;
    out.set_item("refinements", at.refinements)?;
    Ok(out)
}

pub fn stage_of(name: &str) -> PyResult<Stage> {
    let stage = Stage::ALL.iter().find(|s| s.name() == name);
    stage.copied().ok_or_else(|| PyKeyError::new_err(format!("no stage named {name:?}")))
}
