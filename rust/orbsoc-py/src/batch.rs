//! Many problems of one pattern.

use crate::convert::{one_at_a_time, problem, refuse, settings};
use crate::watch::Watch;
use core::ops::ControlFlow;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use orbsoc::{BatchProgress, Error, Problem, Solution, Start, Status};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// One row of numbers for each problem; none: all problems have the base problem's numbers.
type Rows<'py> = Option<PyReadonlyArray2<'py, f64>>;

type Setter = fn(&mut Problem, &[f64]) -> Result<(), Error>;

#[pyclass(module = "orbsoc._core", frozen, get_all)]
pub struct RawBatch {
    status: Vec<&'static str>,
    message: Vec<String>,
    x: Py<PyArray2<f64>>,
    y: Py<PyArray2<f64>>,
    z: Py<PyArray2<f64>>,
    s: Py<PyArray2<f64>>,
    objective: Py<PyArray1<f64>>,
    dual_objective: Py<PyArray1<f64>>,
    iterations: Py<PyArray1<u32>>,
    refinements: Py<PyArray1<u32>>,
    attempts: Py<PyArray1<u32>>,
    primal_residual: Py<PyArray1<f64>>,
    dual_residual: Py<PyArray1<f64>>,
    gap: Py<PyArray1<f64>>,
    radius: Py<PyArray1<f64>>,
    warm_start: Vec<&'static str>,
    setup_s: f64,
    solve_s: f64,
}

/// One batch at a time: a second thread gets an error.
#[pyclass(module = "orbsoc._core", frozen)]
pub struct BatchSolver(Mutex<State>);

struct State {
    inner: orbsoc::BatchSolver,
    base: Arc<Problem>,
    setup: Duration,
}

#[pymethods]
impl BatchSolver {
    #[new]
    fn new(
        py: Python<'_>,
        problem_: &Bound<'_, PyAny>,
        settings_: &Bound<'_, PyAny>,
        threads: usize,
    ) -> PyResult<Self> {
        let (base, settings) = (problem(problem_)?, settings(settings_)?);
        py.detach(|| {
            let clock = Instant::now();
            let inner = orbsoc::BatchSolver::new(&base, &settings, threads).map_err(refuse)?;
            Ok(Self(Mutex::new(State { inner, base, setup: clock.elapsed() })))
        })
    }

    /// Solve `count` problems with the GIL released; the arrays are C-contiguous, one row for each problem.
    /// `callback(progress)` returning true, or Ctrl-C, stops the batch.
    #[pyo3(signature = (count, *, p=None, c=None, a=None, b=None, g=None, h=None, start=None, callback=None))]
    #[allow(clippy::too_many_arguments)] // the six parts of a problem
    #[allow(clippy::needless_pass_by_value)] // extracted arguments
    fn solve(
        &self,
        py: Python<'_>,
        count: usize,
        p: Rows<'_>,
        c: Rows<'_>,
        a: Rows<'_>,
        b: Rows<'_>,
        g: Rows<'_>,
        h: Rows<'_>,
        start: Option<[PyReadonlyArray2<'_, f64>; 4]>,
        callback: Option<Py<PyAny>>,
    ) -> PyResult<RawBatch> {
        let mut views = Vec::with_capacity(6);
        for array in [&p, &c, &a, &b, &g, &h].map(Option::as_ref) {
            views.push(array.map(view).transpose()?);
        }
        let write = |k: usize, problem: &mut Problem, set_p: Setter| {
            let setters: [Setter; 6] = [
                set_p,
                Problem::set_c,
                Problem::set_a_values,
                Problem::set_b,
                Problem::set_g_values,
                Problem::set_h,
            ];
            for (view, set) in views.iter().zip(setters) {
                if let Some((words, width)) = view {
                    set(problem, &words[k * width..(k + 1) * width])?;
                }
            }
            Ok(())
        };
        let points = start.iter().flatten().map(view).collect::<PyResult<Vec<_>>>()?;
        let point = |k: usize| {
            let [x, y, z, s] = [0, 1, 2, 3].map(|part| {
                let (words, width): (&[f64], usize) = points[part];
                &words[k * width..(k + 1) * width]
            });
            Start { x, y, z, s }
        };
        let state = &mut *one_at_a_time(&self.0)?;
        let State { inner, base, .. } = state;
        let mut watch = Watch::new(callback.as_ref());
        let clock = Instant::now();
        let solutions = py.detach(|| {
            // All numbers are checked before the first solve.
            let mut one = Problem::clone(base);
            let mut stopped = false;
            let none = BatchProgress { ended: 0, count };
            for problem in 0..count {
                if watch.glance(|py| progress_dict(py, &none)).is_break() {
                    stopped = true;
                    break;
                }
                write(problem, &mut one, Problem::set_p_values)
                    .and_then(|()| base.same_pattern(&one))
                    .map_err(|error| Error::OfBatch { problem, error: Box::new(error) })?;
            }
            let observe = |progress: &BatchProgress| {
                if stopped {
                    return ControlFlow::Break(());
                }
                watch.look(|py| progress_dict(py, progress))
            };
            let trusting = |k: usize, problem: &mut Problem| write(k, problem, Problem::trust_p_values);
            inner.solve_observed(
                count,
                trusting,
                if points.is_empty() { None } else { Some(&point) },
                observe,
            )
        });
        let elapsed = clock.elapsed();
        let stopped = |s: &Solution| s.status == Status::Interrupted;
        watch.conclude(|| solutions.as_ref().is_ok_and(|all| all.iter().any(stopped)))?;
        raw(py, state, &solutions.map_err(refuse)?, elapsed)
    }
}

fn progress_dict<'py>(py: Python<'py>, at: &BatchProgress) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("ended", at.ended)?;
    out.set_item("count", at.count)?;
    Ok(out)
}

/// The entries of an array, and their number for one problem.
fn view<'a>(array: &'a PyReadonlyArray2<'_, f64>) -> PyResult<(&'a [f64], usize)> {
    Ok((array.as_slice()?, array.as_array().ncols()))
}

fn raw(py: Python<'_>, state: &State, solutions: &[Solution], elapsed: Duration) -> PyResult<RawBatch> {
    let base = &state.base;
    let rows = |width: usize, of: fn(&Solution) -> &Vec<f64>| -> PyResult<Py<PyArray2<f64>>> {
        let words: Vec<f64> = solutions.iter().flat_map(|s| of(s).iter().copied()).collect();
        Ok(words.into_pyarray(py).reshape([solutions.len(), width])?.unbind())
    };
    let column = |of: fn(&Solution) -> f64| -> Py<PyArray1<f64>> {
        solutions.iter().map(of).collect::<Vec<_>>().into_pyarray(py).unbind()
    };
    let counts = |of: fn(&Solution) -> u32| -> Py<PyArray1<u32>> {
        solutions.iter().map(of).collect::<Vec<_>>().into_pyarray(py).unbind()
    };
    Ok(RawBatch {
        status: solutions.iter().map(|s| s.status.name()).collect(),
        message: solutions.iter().map(|s| s.message.clone()).collect(),
        x: rows(base.n(), |s| &s.x)?,
        y: rows(base.p(), |s| &s.y)?,
        z: rows(base.m(), |s| &s.z)?,
        s: rows(base.m(), |s| &s.s)?,
        objective: column(|s| s.objective),
        dual_objective: column(|s| s.dual_objective),
        iterations: counts(|s| s.iterations),
        refinements: counts(|s| s.refinements),
        attempts: counts(|s| s.attempts),
        primal_residual: column(|s| s.certificate.primal_residual),
        dual_residual: column(|s| s.certificate.dual_residual),
        gap: column(|s| s.certificate.gap),
        radius: column(|s| s.certificate.radius),
        warm_start: solutions.iter().map(|s| s.warm_start.name()).collect(),
        setup_s: state.setup.as_secs_f64(),
        solve_s: elapsed.as_secs_f64(),
    })
}
