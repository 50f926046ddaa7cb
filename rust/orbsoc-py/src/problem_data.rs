//! A Python problem's data, read in one pass and checked once: every engine takes them from here.

use crate::convert::problem;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyUntypedArray};
use orbsoc::{Cones, Csc, Problem};
use pyo3::exceptions::PyKeyError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyFloat, PyList, PyType};
use std::sync::Arc;

/// From here on a bound of a nonnegative row is no bound, as in `orbsoc.conic.problem`.
const ABSENT_FROM: f64 = 1e20;

/// Data, indices, pointers and shape of compressed columns.
type Parts<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<i32>>, (usize, usize));

/// The checked data of an `orbsoc.Problem`.
#[pyclass(module = "orbsoc._core", frozen)]
pub struct ProblemData(pub Arc<Problem>);

#[pymethods]
impl ProblemData {
    /// Of an object with the attributes of a problem, each canonical: what `orbsoc.Problem` has checked, entry by entry.
    #[new]
    fn new(checked: &Bound<'_, PyAny>) -> PyResult<Self> {
        problem(checked).map(Self)
    }

    /// Of plain arguments without a fault, with the matrices that are already as they should be held; otherwise
    /// None, and the caller finds out what is wrong, or converts.
    ///
    /// Plain are float64 arrays and lists of floats, and matrices that are dense or SciPy's in CSC, CSR or COO format
    /// with 32- or 64-bit indices and no duplicate entries.
    #[staticmethod]
    #[allow(clippy::too_many_arguments)] // the parts of a problem
    #[allow(non_snake_case)] // their names
    fn plain<'py>(
        py: Python<'py>,
        P: Option<&Bound<'py, PyAny>>,
        c: &Bound<'py, PyAny>,
        A: Option<&Bound<'py, PyAny>>,
        b: Option<&Bound<'py, PyAny>>,
        G: Option<&Bound<'py, PyAny>>,
        h: Option<&Bound<'py, PyAny>>,
        l: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
    ) -> Option<(Self, Bound<'py, PyDict>)> {
        let held = PyDict::new(py);
        let c = vector(c)?;
        let cost = match P {
            Some(P) => Some(symmetric_upper(&matrix("P", P, &held)?)?),
            None => None,
        };
        let (A, b) = rows("A", A, b, &held)?;
        let (G, h) = rows("G", G, h, &held)?;
        let cones = Cones { l: l.extract().ok()?, q: q.extract().ok()? };
        if cones.q.iter().any(|&size| size > h.len()) {
            return None; // and their sum might be too large for a sum
        }
        // A finite bound that is none becomes infinite: in a copy, which the caller makes.
        if h.get(..cones.l)?.iter().any(|h| h.is_finite() && *h >= ABSENT_FROM) {
            return None;
        }
        let checked = py.detach(|| Problem::new(cost, c, A, b, G, h, cones));
        checked.ok().map(|problem| (Self(Arc::new(problem)), held))
    }

    /// A vector by its name: c, b or h.
    fn vector<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let entries = match name {
            "c" => self.0.c(),
            "b" => self.0.b(),
            "h" => self.0.h(),
            _ => return Err(PyKeyError::new_err(format!("no vector named {name:?}"))),
        };
        Ok(PyArray1::from_slice(py, entries))
    }

    /// Data, indices, pointers and shape of a matrix by its name: P (whole), A or G.
    fn matrix<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Parts<'py>> {
        match name {
            "P" => Ok(parts(py, &mirrored(self.0.cost()))),
            "A" => Ok(parts(py, self.0.a())),
            "G" => Ok(parts(py, self.0.g())),
            _ => Err(PyKeyError::new_err(format!("no matrix named {name:?}"))),
        }
    }
}

/// 32-bit indices, as every index of a problem fits.
#[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
fn narrow<'py>(py: Python<'py>, indices: &[usize]) -> Bound<'py, PyArray1<i32>> {
    PyArray1::from_iter(py, indices.iter().map(|&i| i as i32))
}

fn parts<'py>(py: Python<'py>, matrix: &Csc) -> Parts<'py> {
    (
        PyArray1::from_slice(py, matrix.values()),
        narrow(py, matrix.rowidx()),
        narrow(py, matrix.colptr()),
        (matrix.nrows(), matrix.ncols()),
    )
}

/// Whether an object is an array, and of no subclass: that may mean more than its entries, such as a mask.
fn is_array(object: &Bound<'_, PyAny>) -> bool {
    object.get_type().is(object.py().get_type::<PyUntypedArray>())
}

/// A plain vector.
fn vector(object: &Bound<'_, PyAny>) -> Option<Vec<f64>> {
    if is_array(object) {
        let array = object.cast::<PyArray1<f64>>().ok()?.try_readonly().ok()?;
        return Some(array.as_slice().ok()?.to_vec());
    }
    let list = object.cast_exact::<PyList>().ok()?;
    list.iter().map(|item| item.cast_exact::<PyFloat>().ok().map(PyFloatMethods::value)).collect()
}

/// A matrix and its right-hand side, both given or both absent.
fn rows(
    name: &'static str,
    matrix_: Option<&Bound<'_, PyAny>>,
    side: Option<&Bound<'_, PyAny>>,
    held: &Bound<'_, PyDict>,
) -> Option<(Option<Csc>, Vec<f64>)> {
    match (matrix_, side) {
        (None, None) => Some((None, Vec::new())),
        (Some(rows), Some(side)) => Some((Some(matrix(name, rows, held)?), vector(side)?)),
        _ => None,
    }
}

/// How SciPy stores a matrix.
#[derive(Clone, Copy, PartialEq)]
enum Format {
    /// In the class that a problem holds.
    Held,
    Columns,
    Rows,
    Coordinates,
}

/// SciPy's classes that are read here, once it has been imported.
static CLASSES: PyOnceLock<Vec<(Py<PyType>, Format)>> = PyOnceLock::new();

fn format_of(object: &Bound<'_, PyAny>) -> Option<Format> {
    let py = object.py();
    let classes = CLASSES.get_or_try_init(py, || -> PyResult<_> {
        let loaded = py.import("sys")?.getattr("modules")?.get_item("scipy.sparse")?;
        let class = |name: &str, format| {
            Ok((loaded.getattr(name)?.cast_into::<PyType>().map_err(PyErr::from)?.unbind(), format))
        };
        [
            ("csc_array", Format::Held),
            ("csr_array", Format::Rows),
            ("coo_array", Format::Coordinates),
            ("csc_matrix", Format::Columns),
            ("csr_matrix", Format::Rows),
            ("coo_matrix", Format::Coordinates),
        ]
        .map(|(name, format)| class(name, format))
        .into_iter()
        .collect()
    });
    let class = object.get_type();
    classes.ok()?.iter().find(|(known, _)| class.is(known)).map(|&(_, format)| format)
}

/// A plain matrix in compressed columns; `held` takes the object if it is what a problem holds.
fn matrix(name: &'static str, object: &Bound<'_, PyAny>, held: &Bound<'_, PyDict>) -> Option<Csc> {
    let py = object.py();
    if is_array(object) {
        return dense(name, object.cast::<PyArray2<f64>>().ok()?);
    }
    let format = format_of(object)?;
    let part = |name| object.getattr(name).ok();
    let shape: (usize, usize) = part(intern!(py, "shape"))?.extract().ok()?;
    if i32::try_from(shape.0.max(shape.1)).is_err() {
        return None;
    }
    let values = part(intern!(py, "data"))?;
    let values = is_array(&values).then(|| vector(&values))??;
    if format == Format::Coordinates {
        let (rows, columns) = (indices(&part(intern!(py, "row"))?)?, indices(&part(intern!(py, "col"))?)?);
        return coordinates(name, shape, (&rows, &columns), &values);
    }
    let (pointers_, indices_) = (part(intern!(py, "indptr"))?, part(intern!(py, "indices"))?);
    let (pointers, indices) = (indices(&pointers_)?, indices(&indices_)?);
    if format == Format::Rows {
        return from_rows(name, shape, (&pointers, &indices), &values);
    }
    let columns = Csc::new(name, shape, pointers, indices, values).ok()?;
    let narrow = |array: &Bound<'_, PyAny>| array.cast::<PyArray1<i32>>().is_ok();
    if format == Format::Held && narrow(&pointers_) && narrow(&indices_) {
        held.set_item(name, object).ok()?;
    }
    Some(columns)
}

/// Compressed columns of compressed rows, whose entries may be in any order within a row.
fn from_rows(
    name: &'static str,
    shape: (usize, usize),
    (pointers, indices): (&[usize], &[usize]),
    values: &[f64],
) -> Option<Csc> {
    let ends = (*pointers.first()?, *pointers.last()?);
    let fits = pointers.len() == shape.0 + 1 && ends == (0, values.len()) && indices.len() == values.len();
    if !(fits && pointers.is_sorted()) {
        return None;
    }
    by_columns(name, shape, || {
        let places = (0..shape.0).flat_map(|i| (pointers[i]..pointers[i + 1]).map(move |k| (i, k)));
        places.map(|(i, k)| (i, indices[k], values[k]))
    })
}

/// Plain indices, none negative.
fn indices(object: &Bound<'_, PyAny>) -> Option<Vec<usize>> {
    fn read<T: numpy::Element + Copy + TryInto<usize>>(
        array: &PyReadonlyArray1<'_, T>,
    ) -> Option<Vec<usize>> {
        array.as_slice().ok()?.iter().map(|&i| i.try_into().ok()).collect()
    }
    if !is_array(object) {
        return None;
    }
    match object.cast::<PyArray1<i32>>() {
        Ok(array) => read(&array.try_readonly().ok()?),
        Err(_) => read(&object.cast::<PyArray1<i64>>().ok()?.try_readonly().ok()?),
    }
}

/// The entries of a dense matrix that are not zero.
fn dense(name: &'static str, array: &Bound<'_, PyArray2<f64>>) -> Option<Csc> {
    let array = array.try_readonly().ok()?;
    let view = array.as_array();
    if i32::try_from(view.len()).is_err() {
        return None;
    }
    let shape = view.dim();
    let whole = view.as_slice().filter(|_| shape.1 > 0);
    let Some(whole) = whole else {
        let all = || view.indexed_iter().map(|((i, j), &value)| (i, j, value));
        return by_columns(name, shape, || all().filter(|&(.., value)| value != 0.0));
    };
    let mut pointers = vec![0; shape.1 + 1];
    for row in whole.chunks_exact(shape.1) {
        for (count, &value) in pointers[1..].iter_mut().zip(row) {
            *count += usize::from(value != 0.0);
        }
    }
    for j in 0..shape.1 {
        pointers[j + 1] += pointers[j];
    }
    let mut next = pointers.clone();
    let (mut rows, mut values) = (vec![0; pointers[shape.1]], vec![0.0; pointers[shape.1]]);
    for (i, row) in whole.chunks_exact(shape.1).enumerate() {
        for (next, &value) in next.iter_mut().zip(row).filter(|(_, &value)| value != 0.0) {
            (rows[*next], values[*next]) = (i, value);
            *next += 1;
        }
    }
    Csc::new(name, shape, pointers, rows, values).ok()
}

/// Compressed columns of entries (row, column, value) that come row by row; None for what is no matrix, as with two
/// entries at one place.
fn by_columns<I: Iterator<Item = (usize, usize, f64)>>(
    name: &'static str,
    shape: (usize, usize),
    entries: impl Fn() -> I,
) -> Option<Csc> {
    let mut pointers = vec![0; shape.1 + 1];
    for (_, j, _) in entries() {
        *pointers.get_mut(j + 1)? += 1;
    }
    for j in 0..shape.1 {
        pointers[j + 1] += pointers[j];
    }
    let mut next = pointers.clone();
    let (mut rows, mut values) = (vec![0; pointers[shape.1]], vec![0.0; pointers[shape.1]]);
    for (i, j, value) in entries() {
        (rows[next[j]], values[next[j]]) = (i, value);
        next[j] += 1;
    }
    Csc::new(name, shape, pointers, rows, values).ok()
}

/// Compressed columns of coordinates in any order.
fn coordinates(
    name: &'static str,
    shape: (usize, usize),
    (rows, columns): (&[usize], &[usize]),
    values: &[f64],
) -> Option<Csc> {
    if rows.len() != values.len() || columns.len() != values.len() {
        return None;
    }
    let mut pointers = vec![0; shape.0 + 1];
    for &i in rows {
        *pointers.get_mut(i + 1)? += 1;
    }
    for i in 0..shape.0 {
        pointers[i + 1] += pointers[i];
    }
    let mut order = vec![0; values.len()];
    for (k, &i) in rows.iter().enumerate() {
        order[pointers[i]] = k;
        pointers[i] += 1;
    }
    by_columns(name, shape, || order.iter().map(|&k| (rows[k], columns[k], values[k])))
}

/// The upper triangle of a matrix that is exactly symmetric; None for another.
fn symmetric_upper(whole: &Csc) -> Option<Csc> {
    let upper = whole.upper_triangle("P").ok()?;
    let (pointers, rows, values) = (whole.colptr(), whole.rowidx(), whole.values());
    // Entries below the diagonal of a column, in order, are those above it of the later columns.
    let below = |j: usize| pointers[j] + rows[pointers[j]..pointers[j + 1]].partition_point(|&i| i <= j);
    let mut next: Vec<usize> = (0..whole.ncols()).map(below).collect();
    for (i, j, value) in upper.triplets().filter(|&(i, j, _)| i < j) {
        let k = next[i];
        if k == pointers[i + 1] || rows[k] != j || values[k] != value {
            return None;
        }
        next[i] += 1;
    }
    (next == pointers[1..]).then_some(upper)
}

/// The symmetric matrix of an upper triangle.
fn mirrored(upper: &Csc) -> Csc {
    let order = upper.ncols();
    if upper.triplets().all(|(i, j, _)| i == j) {
        return upper.clone();
    }
    let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); order];
    for (i, j, value) in upper.triplets() {
        columns[j].push((i, value));
        // Entries above the diagonal come column by column: below it, each column's rows ascend, after those above.
        if i != j {
            columns[i].push((j, value));
        }
    }
    let mut pointers = vec![0; order + 1];
    for (j, column) in columns.iter().enumerate() {
        pointers[j + 1] = pointers[j] + column.len();
    }
    let (rows, values) = columns.into_iter().flatten().unzip();
    Csc::new("P", (order, order), pointers, rows, values).unwrap_or_else(|_| upper.clone())
}
