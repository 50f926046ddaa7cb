//! A pattern's tables.

use crate::convert::{problem, refuse, settings};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Sizes, lists and words of buffers of a pattern on the exact factor layout, each by name.
#[pyfunction]
pub fn pattern_tables<'py>(
    py: Python<'py>,
    problem_: &Bound<'py, PyAny>,
    settings_: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let (problem, settings) = (problem(problem_)?, settings(settings_)?);
    let tables = py.detach(|| orbsoc::pattern_tables(&problem, &settings)).map_err(refuse)?;
    let (sizes, lists, words) = (PyDict::new(py), PyDict::new(py), PyDict::new(py));
    for (name, size) in tables.sizes {
        sizes.set_item(name, size)?;
    }
    for (name, list) in tables.lists {
        lists.set_item(name, list.into_pyarray(py))?;
    }
    for (name, entries) in tables.words {
        words.set_item(name, entries)?;
    }
    Ok((sizes, lists, words))
}

macro_rules! sources {
    ($folder:literal: $($name:literal),* $(,)?) => { &[$(($name, include_str!(concat!("../../../", $folder, $name)))),*] };
}

/// The fixed library in C, file by file.
const SOURCES: &[(&str, &str)] = sources![
    "flight/":
    "certificate.c",
    "checksum.c",
    "cone_ops.c",
    "decisions.c",
    "device.c",
    "factorization.c",
    "kernels.h",
    "layout.h",
    "line_search.c",
    "linear_solve.c",
    "matrix_scaling.c",
    "matrix_update.c",
    "method.c",
    "method.h",
    "orbsoc_flight.h",
    "real.h",
    "reduce.h",
    "solver.c",
    "stages.c",
    "statistics.c",
];

/// The outer loops of missions in C, file by file.
const MISSIONS: &[(&str, &str)] = sources![
    "flight/missions/":
    "flights.c",
    "insertion.c",
    "insertion.h",
    "linearise.c",
    "mission_checksum.c",
    "vectors.h",
];

/// The driver of the PL in C, file by file.
const DRIVER: &[(&str, &str)] = sources![
    "rtl/driver/":
    "orbsoc.c",
    "orbsoc.h",
    "orbsoc_device.c",
    "orbsoc_device.h",
    "orbsoc_registers.h",
];

/// The text of each file of the library in C, by name.
#[pyfunction]
pub fn flight_sources(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    by_name(py, SOURCES)
}

/// The text of each file of the missions in C, by name.
#[pyfunction]
pub fn flight_mission_sources(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    by_name(py, MISSIONS)
}

/// The text of each file of the driver in C, by name.
#[pyfunction]
pub fn driver_sources(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    by_name(py, DRIVER)
}

fn by_name<'py>(py: Python<'py>, texts: &[(&str, &str)]) -> PyResult<Bound<'py, PyDict>> {
    let sources = PyDict::new(py);
    for (name, text) in texts {
        sources.set_item(name, text)?;
    }
    Ok(sources)
}
