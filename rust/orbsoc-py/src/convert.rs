//! Conversion of Python's problems and settings.

use crate::problem_data::ProblemData;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyUntypedArray};
use orbsoc::{Cones, Csc, Error, Ordering, Problem, Settings};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

pyo3::create_exception!(_core, CoreError, PyValueError, "The solver core refused its input.");

/// The content of a solver's lock, if no solve holds it.
pub fn one_at_a_time<S>(state: &Mutex<S>) -> PyResult<MutexGuard<'_, S>> {
    state.try_lock().map_err(|refused| {
        PyRuntimeError::new_err(match refused {
            TryLockError::WouldBlock => {
                "this solver is already solving, in another thread or in the caller of this callback; \
                 use one Solver for each thread"
            }
            TryLockError::Poisoned(_) => {
                "an earlier solve of this solver ended in an internal error and left it unfinished; make a new one"
            }
        })
    })
}

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

/// Refuse a cost whose matrix, symmetric and in compressed columns, is not positive semidefinite.
#[pyfunction]
pub fn check_cost(cost: &Bound<'_, PyAny>) -> PyResult<()> {
    let whole = matrix("P", cost, false)?;
    cost.py().detach(|| orbsoc::check_convex(&whole)).map_err(refuse)
}

/// The data of an `orbsoc.Problem`, whose constructor has checked P, or of an object with its attributes.
pub fn problem(object: &Bound<'_, PyAny>) -> PyResult<Arc<Problem>> {
    let py = object.py();
    let get = |name| object.getattr(name);
    let data = object.getattr_opt(intern!(py, "_data"))?;
    if let Some(data) = data.as_ref().and_then(|data| data.cast_exact::<ProblemData>().ok()) {
        return Ok(Arc::clone(&data.get().0));
    }
    let cones = get(intern!(py, "cones"))?;
    let cones = Cones {
        l: cones.getattr(intern!(py, "l"))?.extract()?,
        q: cones.getattr(intern!(py, "q"))?.extract()?,
    };
    Problem::trusted(
        Some(matrix("P", &get(intern!(py, "P"))?, true)?),
        vector(&get(intern!(py, "c"))?)?,
        Some(matrix("A", &get(intern!(py, "A"))?, false)?),
        vector(&get(intern!(py, "b"))?)?,
        Some(matrix("G", &get(intern!(py, "G"))?, false)?),
        vector(&get(intern!(py, "h"))?)?,
        cones,
    )
    .map(Arc::new)
    .map_err(refuse)
}

/// Replace a problem's numbers by plain data, by name. Whether all data were plain; if not, the problem is partly
/// changed. Plain are contiguous float64 vectors c, b, h, and such matrices A, G of the problem's pattern.
pub fn replace_numbers(problem: &mut Problem, data: &Bound<'_, PyDict>) -> PyResult<bool> {
    for (name, value) in data {
        let name = name.cast::<PyString>()?;
        let taken = match name.to_str()? {
            "c" => numbers(&value, |words| problem.set_c(words)),
            "b" => numbers(&value, |words| problem.set_b(words)),
            "h" => numbers(&value, |words| problem.set_h(words)),
            "A" => entries(&value, problem.a())?.is_some_and(|v| numbers(&v, |w| problem.set_a_values(w))),
            "G" => entries(&value, problem.g())?.is_some_and(|v| numbers(&v, |w| problem.set_g_values(w))),
            _ => false,
        };
        if !taken {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether `set` accepted a plain vector. A subclass is not plain: it may mean more than its entries, such as a mask.
fn numbers(value: &Bound<'_, PyAny>, set: impl FnOnce(&[f64]) -> Result<(), Error>) -> bool {
    let plain = value.get_type().is(value.py().get_type::<PyUntypedArray>());
    let vector = value.cast::<PyArray1<f64>>().ok().filter(|_| plain);
    let plain = vector.and_then(|array| array.try_readonly().ok());
    plain.is_some_and(|array| array.as_slice().is_ok_and(|words| set(words).is_ok()))
}

/// The entries of a matrix in compressed columns if it has the pattern of `kept`.
fn entries<'py>(matrix: &Bound<'py, PyAny>, kept: &Csc) -> PyResult<Option<Bound<'py, PyAny>>> {
    let py = matrix.py();
    let in_columns = matrix.getattr_opt(intern!(py, "format"))?;
    if !in_columns.is_some_and(|f| f.eq(intern!(py, "csc")).unwrap_or(false)) {
        return Ok(None);
    }
    let same = |found: Bound<'py, PyAny>, kept: &[usize]| {
        let plain = found.cast::<PyArray1<i32>>().ok().and_then(|array| array.try_readonly().ok());
        plain.is_some_and(|array| {
            array.as_slice().is_ok_and(|found| {
                found.len() == kept.len()
                    && found.iter().zip(kept).all(|(&i, &k)| usize::try_from(i) == Ok(k))
            })
        })
    };
    let shape: (usize, usize) = matrix.getattr(intern!(py, "shape"))?.extract()?;
    let kept_pattern = shape == (kept.nrows(), kept.ncols())
        && same(matrix.getattr(intern!(py, "indptr"))?, kept.colptr())
        && same(matrix.getattr(intern!(py, "indices"))?, kept.rowidx());
    Ok(if kept_pattern { Some(matrix.getattr(intern!(py, "data"))?) } else { None })
}

/// An `orbsoc.Settings`; its attributes have the names of the fields.
pub fn settings(object: &Bound<'_, PyAny>) -> PyResult<Settings> {
    let py = object.py();
    let name: String = object.getattr(intern!(py, "ordering"))?.extract()?;
    let Some(ordering) = Ordering::named(&name) else {
        let allowed = Ordering::ALL.map(Ordering::name).join(", ");
        return Err(CoreError::new_err(format!("setting `ordering` = {name:?}: allowed is {allowed}")));
    };
    macro_rules! read {
        ($($field:ident),*) => {
            Settings { ordering, $($field: object.getattr(intern!(py, stringify!($field)))?.extract()?,)* }
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
        ruiz_passes,
        max_restarts
    ))
}
