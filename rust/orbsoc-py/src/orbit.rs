//! Coasts and burns about the Earth.

use crate::convert::CoreError;
use numpy::{
    PyArray1, PyArray2, PyArray3, PyArray4, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3,
};
use orbsoc_orbit::{burn, coast, Coast, Error, Field, Layer, Thrust};
use pyo3::prelude::*;

type States = Py<PyArray3<f64>>;
type Transitions = Py<PyArray4<f64>>;

#[pyclass(module = "orbsoc._core", frozen)]
pub struct OrbitField(Field);

#[allow(clippy::needless_pass_by_value)] // the shape map_err wants
fn refuse(error: Error) -> PyErr {
    CoreError::new_err(error.to_string())
}

#[pymethods]
impl OrbitField {
    #[new]
    #[pyo3(signature = (*, mu_m3_s2, radius_m, j2, rotation_rad_s, flattening, layers))]
    fn new(
        mu_m3_s2: f64,
        radius_m: f64,
        j2: f64,
        rotation_rad_s: f64,
        flattening: f64,
        layers: &Bound<'_, PyArray2<f64>>,
    ) -> Self {
        let row = |row: numpy::ndarray::ArrayView1<'_, f64>| Layer {
            base_m: row[0],
            density_kg_m3: row[1],
            scale_m: row[2],
        };
        let layers = layers.readonly().as_array().rows().into_iter().map(row).collect();
        Self(Field { mu_m3_s2, radius_m, j2, rotation_rad_s, flattening, layers })
    }

    #[pyo3(signature = (states, times_s, kicks, ballistic_m2_kg, *, tolerance, transitions))]
    #[allow(clippy::too_many_arguments, clippy::needless_pass_by_value)] // Python's arguments
    fn coast(
        &self,
        py: Python<'_>,
        states: PyReadonlyArray2<'_, f64>,
        times_s: PyReadonlyArray1<'_, f64>,
        kicks: Option<PyReadonlyArray3<'_, f64>>,
        ballistic_m2_kg: PyReadonlyArray1<'_, f64>,
        tolerance: f64,
        transitions: bool,
    ) -> PyResult<(States, Option<Transitions>)> {
        let times = times_s.as_array().to_vec();
        let bodies: Vec<([f64; 6], Vec<[f64; 3]>, f64)> = (0..states.as_array().nrows())
            .map(|b| {
                let start = core::array::from_fn(|i| states.as_array()[(b, i)]);
                let kicks = kicks.as_ref().map_or_else(Vec::new, |kicks| {
                    (0..times.len()).map(|k| core::array::from_fn(|i| kicks.as_array()[(k, b, i)])).collect()
                });
                (start, kicks, ballistic_m2_kg.as_array()[b])
            })
            .collect();
        let run = |(start, kicks, ballistic): &([f64; 6], Vec<[f64; 3]>, f64)| {
            coast(&self.0, *ballistic, start, &times, kicks, tolerance, transitions)
        };
        let found: Vec<Coast> =
            py.detach(|| bodies.iter().map(run).collect::<Result<_, _>>()).map_err(refuse)?;
        let shape = [times.len(), found.len(), 6];
        let rows = (0..times.len()).flat_map(|k| found.iter().flat_map(move |body| body.states[k]));
        let states = PyArray1::from_iter(py, rows).reshape(shape)?.unbind();
        let matrices = transitions.then(|| {
            let rows = (0..times.len()).flat_map(|k| found.iter().flat_map(move |body| body.transitions[k]));
            PyArray1::from_iter(py, rows).reshape([shape[0], shape[1], 6, 6])
        });
        Ok((states, matrices.transpose()?.map(Bound::unbind)))
    }

    #[pyo3(signature = (state, ballistic_m2_kg, *, acceleration_m_s2, exhaust_m_s, pitch_rad, pitch_rate_rad_s, yaw_rad, duration_s, tolerance))]
    #[allow(clippy::too_many_arguments)] // Python's arguments
    fn burn(
        &self,
        py: Python<'_>,
        state: [f64; 6],
        ballistic_m2_kg: f64,
        acceleration_m_s2: f64,
        exhaust_m_s: f64,
        pitch_rad: f64,
        pitch_rate_rad_s: f64,
        yaw_rad: f64,
        duration_s: f64,
        tolerance: f64,
    ) -> PyResult<Py<PyArray1<f64>>> {
        let thrust =
            Thrust { acceleration_m_s2, exhaust_m_s, pitch_rad, pitch_rate_rad_s, yaw_rad, duration_s };
        let end = burn(&self.0, ballistic_m2_kg, &state, &thrust, tolerance).map_err(refuse)?;
        Ok(PyArray1::from_slice(py, &end).unbind())
    }
}
