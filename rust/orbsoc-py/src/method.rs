//! The method's tables, and what its stages cost in operations.

use crate::convert::{problem, refuse, settings};
use orbsoc::real::{Latency, OperationCounts};
use orbsoc::{Flag, Restart, Stage, Step, CLOSING, ITERATION, RESTARTS, STARTUP, WARM_STARTUP};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::collections::BTreeMap;

fn steps<'py>(py: Python<'py>, list: &[Step]) -> PyResult<Vec<Bound<'py, PyTuple>>> {
    list.iter()
        .map(|step| match step {
            Step::Run(stage) => PyTuple::new(py, [stage.name()]),
            Step::Repeat { stage, until } => PyTuple::new(py, [stage.name(), until.name()]),
        })
        .collect()
}

#[pyfunction]
pub fn startup(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyTuple>>> {
    steps(py, STARTUP)
}

#[pyfunction]
pub fn warm_startup(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyTuple>>> {
    steps(py, WARM_STARTUP)
}

#[pyfunction]
pub fn iteration(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyTuple>>> {
    steps(py, ITERATION)
}

#[pyfunction]
pub fn closing(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyTuple>>> {
    steps(py, CLOSING)
}

/// A row of the restart policy.
#[pyclass(module = "orbsoc._core", frozen, get_all)]
pub struct RestartInfo {
    after: Vec<&'static str>,
    stalled: bool,
    statuses: Vec<&'static str>,
    attempt: &'static str,
    refinement_factor: f64,
    regularization_factor: f64,
}

impl From<&Restart> for RestartInfo {
    fn from(row: &Restart) -> Self {
        Self {
            after: row.after.iter().map(|attempt| attempt.name()).collect(),
            stalled: row.stalled,
            statuses: row.statuses.iter().map(|status| status.name()).collect(),
            attempt: row.attempt.name(),
            refinement_factor: row.refinement_factor,
            regularization_factor: row.regularization_factor,
        }
    }
}

#[pyfunction]
pub fn restarts() -> Vec<RestartInfo> {
    RESTARTS.iter().map(RestartInfo::from).collect()
}

/// A row of the dataflow table.
#[pyclass(module = "orbsoc._core", frozen)]
pub struct StageInfo(Stage);

#[pymethods]
impl StageInfo {
    #[getter]
    fn module(&self) -> &'static str {
        self.0.module().name()
    }

    #[getter]
    fn reads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.reads().iter().map(|b| b.name()))
    }

    #[getter]
    fn writes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.writes().iter().map(|b| b.name()))
    }

    /// "repeat" or "stop", and the buffer whose first word decides.
    #[getter]
    fn flag(&self) -> Option<(&'static str, &'static str)> {
        self.0.flag().map(|flag| match flag {
            Flag::Repeat(buffer) => ("repeat", buffer.name()),
            Flag::Stop(buffer) => ("stop", buffer.name()),
        })
    }

    #[getter]
    fn stales<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.stales().iter().map(|b| b.name()))
    }
}

#[pyfunction]
pub fn stages(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    for &stage in Stage::ALL {
        out.set_item(stage.name(), StageInfo(stage))?;
    }
    Ok(out)
}

/// Operations and critical paths of every stage on a problem's pattern; `latencies` maps a preset's
/// name to cycles by operation.
#[pyfunction]
pub fn operation_counts<'py>(
    py: Python<'py>,
    problem_: &Bound<'py, PyAny>,
    settings_: &Bound<'py, PyAny>,
    latencies: BTreeMap<String, BTreeMap<String, u32>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (problem, settings) = (problem(problem_)?, settings(settings_)?);
    let out = PyDict::new(py);
    for stage in Stage::ALL {
        let entry = PyDict::new(py);
        entry.set_item("critical_path", PyDict::new(py))?;
        out.set_item(stage.name(), entry)?;
    }
    let unit = [(String::new(), None)];
    let presets = latencies.into_iter().map(|(name, cycles)| (name, Some(cycles)));
    for (name, cycles) in unit.into_iter().chain(presets) {
        let latency = cycles.as_ref().map_or(Ok(Latency::UNIT), |cycles| latency(&name, cycles))?;
        let counted = py.detach(|| orbsoc::operation_counts(&problem, &settings, latency)).map_err(refuse)?;
        for (stage, tally) in counted {
            let entry = out.as_any().get_item(stage.name())?;
            if cycles.is_some() {
                entry.get_item("critical_path")?.set_item(&name, tally.critical_path)?;
            } else {
                entry.set_item("operations", operations(py, &tally.operations)?)?;
            }
        }
    }
    Ok(out)
}

/// Height of the elimination tree, entries of L, multiply-adds of LDLᵀ.
#[pyfunction]
pub fn factor_shape(
    py: Python<'_>,
    problem_: &Bound<'_, PyAny>,
    settings_: &Bound<'_, PyAny>,
) -> PyResult<(u32, u64, u64)> {
    let (problem, settings) = (problem(problem_)?, settings(settings_)?);
    let shape = py.detach(|| orbsoc::factor_shape(&problem, &settings)).map_err(refuse)?;
    Ok((shape.height, shape.entries, shape.multiply_adds))
}

fn operations<'py>(py: Python<'py>, counts: &OperationCounts) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    macro_rules! write {
        ($($name:literal $field:ident),*) => { $(out.set_item($name, counts.$field)?;)* };
    }
    write!(
        "neg" neg, "abs" abs, "mul" mul, "add" add, "sub" sub, "mul_add" add_mul, "mul_sub" sub_mul,
        "div" div, "sqrt" sqrt, "min" min, "max" max, "compare" compare, "and" and, "select" select
    );
    out.set_item("move", 0)?;
    Ok(out)
}

fn latency(preset: &str, cycles: &BTreeMap<String, u32>) -> PyResult<Latency> {
    let of = |name: &str| {
        cycles.get(name).copied().ok_or_else(|| {
            PyKeyError::new_err(format!("latency preset {preset:?} has no entry for operation {name:?}"))
        })
    };
    Ok(Latency {
        neg: of("neg")?,
        abs: of("abs")?,
        mul: of("mul")?,
        add: of("add")?,
        sub: of("sub")?,
        add_mul: of("mul_add")?,
        sub_mul: of("mul_sub")?,
        div: of("div")?,
        sqrt: of("sqrt")?,
        min: of("min")?,
        max: of("max")?,
        compare: of("compare")?,
        and: of("and")?,
        select: of("select")?,
    })
}
