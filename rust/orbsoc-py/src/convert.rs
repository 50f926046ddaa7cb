//! Python's problem and settings into Rust's.

use numpy::PyReadonlyArray1;
use orbsoc::{Cones, Csc, Error, Problem, Settings};
use pyo3::exceptions::PyValueError;
use pyo3::intern;
use pyo3::prelude::*;

pyo3::create_exception!(_core, CoreError, PyValueError, "The solver core refused its input.");

#[allow(clippy::needless_pass_by_value)] // the shape map_err wants
pub fn refuse(error: Error) -> PyErr {
    CoreError::new_err(error.to_string())
}

/// A NumPy vector's numbers.
fn vector(object: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array: PyReadonlyArray1<'_, f64> = object.extract()?;
    Ok(array.as_array().to_vec())
}

fn indices(object: &Bound<'_, PyAny>) -> PyResult<Vec<usize>> {
    let array: PyReadonlyArray1<'_, i32> = object.extract()?;
    array
        .as_array()
        .iter()
        .map(|&i| usize::try_from(i).map_err(|_| PyValueError::new_err(format!("negative index {i}"))))
        .collect()
}

/// A SciPy matrix in compressed columns; of a symmetric one, only the upper triangle is kept.
fn matrix(name: &'static str, object: &Bound<'_, PyAny>, upper: bool) -> PyResult<Csc> {
    let py = object.py();
    let shape: (usize, usize) = object.getattr(intern!(py, "shape"))?.extract()?;
    let colptr = indices(&object.getattr(intern!(py, "indptr"))?)?;
    let rowidx = indices(&object.getattr(intern!(py, "indices"))?)?;
    let values = vector(&object.getattr(intern!(py, "data"))?)?;
    let full = Csc::new(name, shape, colptr, rowidx, values).map_err(refuse)?;
    if upper {
        full.upper_triangle(name).map_err(refuse)
    } else {
        Ok(full)
    }
}

/// An `orbsoc.Problem`.
pub fn problem(object: &Bound<'_, PyAny>) -> PyResult<Problem> {
    let py = object.py();
    let get = |name| object.getattr(name);
    let cones = get(intern!(py, "cones"))?;
    let cones = Cones {
        l: cones.getattr(intern!(py, "l"))?.extract()?,
        q: cones.getattr(intern!(py, "q"))?.extract()?,
    };
    Problem::new(
        Some(matrix("P", &get(intern!(py, "P"))?, true)?),
        vector(&get(intern!(py, "c"))?)?,
        Some(matrix("A", &get(intern!(py, "A"))?, false)?),
        vector(&get(intern!(py, "b"))?)?,
        Some(matrix("G", &get(intern!(py, "G"))?, false)?),
        vector(&get(intern!(py, "h"))?)?,
        cones,
    )
    .map_err(refuse)
}

/// An `orbsoc.Settings`; its attributes have the names of the fields.
pub fn settings(object: &Bound<'_, PyAny>) -> PyResult<Settings> {
    let py = object.py();
    macro_rules! read {
        ($($field:ident),*) => {
            Settings { $($field: object.getattr(intern!(py, stringify!($field)))?.extract()?,)* }
        };
    }
    Ok(read!(
        tol,
        tol_inaccurate,
        max_iterations,
        max_time_s,
        static_regularization,
        pivot_floor,
        dynamic_regularization,
        refinement_tol,
        refinement_share,
        refinement_max,
        step_fraction,
        ruiz_passes
    ))
}
