//! Many problems of one pattern.

use crate::convert::{problem, refuse, settings};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use orbsoc::{Error, Problem, Solution, Start};
use pyo3::prelude::*;
use std::time::Instant;

/// One row of numbers a problem, or nothing: then the base problem's numbers are shared.
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
    primal_residual: Py<PyArray1<f64>>,
    dual_residual: Py<PyArray1<f64>>,
    gap: Py<PyArray1<f64>>,
    radius: Py<PyArray1<f64>>,
    warm_start: Vec<&'static str>,
    solve_s: f64,
}

/// Solve `count` problems; the arrays are C-contiguous, one row a problem.
#[pyfunction]
#[pyo3(signature = (problem_, settings_, count, threads, *, p=None, c=None, a=None, b=None, g=None, h=None, start=None))]
#[allow(clippy::too_many_arguments)] // the six parts of a problem
#[allow(clippy::needless_pass_by_value)] // extracted arguments
pub fn solve_batch(
    py: Python<'_>,
    problem_: &Bound<'_, PyAny>,
    settings_: &Bound<'_, PyAny>,
    count: usize,
    threads: usize,
    p: Rows<'_>,
    c: Rows<'_>,
    a: Rows<'_>,
    b: Rows<'_>,
    g: Rows<'_>,
    h: Rows<'_>,
    start: Option<[PyReadonlyArray2<'_, f64>; 4]>,
) -> PyResult<RawBatch> {
    let (base, settings) = (problem(problem_)?, settings(settings_)?);
    let arrays = [&p, &c, &a, &b, &g, &h].map(Option::as_ref);
    let mut views = Vec::with_capacity(arrays.len());
    for array in arrays {
        views.push(array.map(|a| a.as_slice().map(|s| (s, a.as_array().ncols()))).transpose()?);
    }
    let setters: [Setter; 6] = [
        Problem::set_p_values,
        Problem::set_c,
        Problem::set_a_values,
        Problem::set_b,
        Problem::set_g_values,
        Problem::set_h,
    ];
    let write = |k: usize, problem: &mut Problem| {
        for (view, set) in views.iter().zip(setters) {
            if let Some((words, width)) = view {
                set(problem, &words[k * width..(k + 1) * width])?;
            }
        }
        Ok(())
    };
    let mut points: Vec<(&[f64], usize)> = Vec::new();
    for array in start.iter().flatten() {
        points.push((array.as_slice()?, array.as_array().ncols()));
    }
    let point = |k: usize| {
        let [x, y, z, s] = [0, 1, 2, 3].map(|part| {
            let (words, width): (&[f64], usize) = points[part];
            &words[k * width..(k + 1) * width]
        });
        Start { x, y, z, s }
    };
    let clock = Instant::now();
    let solutions = py.detach(|| {
        if points.is_empty() {
            orbsoc::solve_batch(&base, count, write, &settings, threads)
        } else {
            orbsoc::solve_batch_from(&base, count, write, point, &settings, threads)
        }
    });
    raw(py, &base, &solutions.map_err(refuse)?, clock.elapsed().as_secs_f64())
}

fn raw(py: Python<'_>, base: &Problem, solutions: &[Solution], solve_s: f64) -> PyResult<RawBatch> {
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
        primal_residual: column(|s| s.certificate.primal_residual),
        dual_residual: column(|s| s.certificate.dual_residual),
        gap: column(|s| s.certificate.gap),
        radius: column(|s| s.certificate.radius),
        warm_start: solutions.iter().map(|s| s.warm_start.name()).collect(),
        solve_s,
    })
}
