//! Memory image of a scheduled program.

use crate::hardware::{unfit, HardwareProgram};
use numpy::{IntoPyArray, PyArray1};
use orbsoc_hw::{Configuration, Format, Gaps, Image};
use pyo3::prelude::*;
use std::collections::BTreeMap;

type Array<T> = Py<PyArray1<T>>;

#[pyclass(module = "orbsoc._core", frozen)]
pub struct ProgramImage {
    #[pyo3(get)]
    templates: Vec<String>,
    #[pyo3(get)]
    microcode: Vec<String>,
    /// By segment: first line, busy cycles.
    #[pyo3(get)]
    entries: BTreeMap<String, (usize, u32)>,
    /// Addresses, bits.
    #[pyo3(get)]
    literals: (Array<u32>, Array<u64>),
    /// By buffer: indices of the words that have an architectural location, addresses.
    #[pyo3(get)]
    homes: BTreeMap<&'static str, (Array<u32>, Array<u32>)>,
    /// Of the engine that it was made for.
    #[pyo3(get)]
    identity: u32,
    engine: (Configuration, u32),
}

#[pymethods]
impl ProgramImage {
    /// Raise unless an engine has the identity that this program was made for.
    fn require_identity(&self, there: u32) -> PyResult<()> {
        self.engine.0.require_identity(self.engine.1, there).map_err(unfit)
    }
}

/// What is loaded into microcode memory and storage before the first segment, and the addresses of the buffers.
/// `stream`: ports of streamed microcode, compressed; 0: it is loaded.
#[pyfunction]
#[pyo3(signature = (program, format, *, seed=1, level=0, stream=0))]
pub fn program_image(
    py: Python<'_>,
    program: &HardwareProgram,
    format: &str,
    seed: u32,
    level: u32,
    stream: u32,
) -> PyResult<ProgramImage> {
    let (format, program) = program.in_format(format, Gaps { seed, level })?;
    let engine = (program.configuration, u32::from(matches!(format, Format::Compressed)) + 2 * stream);
    let image = py.detach(|| Image::new(program, format));
    let mut homes: BTreeMap<&'static str, (Vec<u32>, Vec<u32>)> = BTreeMap::new();
    for (buffer, index, address) in program.layout.locations() {
        let (indices, addresses) = homes.entry(buffer.name()).or_default();
        indices.push(index);
        addresses.push(address);
    }
    let (addresses, bits): (Vec<u32>, Vec<u64>) = image.literals.into_iter().unzip();
    let pair = |(indices, addresses): (Vec<u32>, Vec<u32>)| (array(py, indices), array(py, addresses));
    Ok(ProgramImage {
        templates: image.templates,
        microcode: (0..image.microcode.len()).map(|line| image.microcode.hex(line)).collect(),
        entries: image.entries.into_iter().map(|(name, at)| (name, (at.start, at.cycles))).collect(),
        literals: (array(py, addresses), array(py, bits)),
        homes: homes.into_iter().map(|(name, words)| (name, pair(words))).collect(),
        identity: engine.0.identity(engine.1),
        engine,
    })
}

fn array<T: numpy::Element>(py: Python<'_>, words: Vec<T>) -> Array<T> {
    words.into_pyarray(py).unbind()
}
