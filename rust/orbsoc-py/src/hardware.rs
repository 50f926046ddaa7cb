//! Schedules of a pattern on an engine.

use crate::convert::{problem, refuse, settings};
use numpy::{IntoPyArray, PyArray1};
use orbsoc::{Buffer, Compiled, Module, Problem, Settings, Stage};
use orbsoc_hw::{
    interleaved, snapshots, validation_case, Causes, Code, Compressed, Configuration, Demand, Format, Gaps,
    Layout, Precision, Program, Segment, Streaming, Timing,
};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

pyo3::create_exception!(_core, HardwareError, PyValueError, "An engine that cannot be, or is too small.");

/// Cycles, units and operations.
type Issued<'py> = (Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u8>>, Bound<'py, PyArray1<u8>>);

#[allow(clippy::needless_pass_by_value)] // the shape map_err wants
pub fn unfit(error: orbsoc_hw::Error) -> PyErr {
    HardwareError::new_err(error.to_string())
}

/// Every segment of a problem's pattern, scheduled on one engine.
#[pyclass(module = "orbsoc._core", frozen)]
pub struct HardwareProgram {
    program: Program,
    /// The same segments, scheduled for few bits.
    compact: Program,
    /// Their microcode.
    compressed: Compressed,
    problem: Arc<Problem>,
    settings: Settings,
    /// Problems that every segment works on.
    copies: usize,
}

#[pymethods]
impl HardwareProgram {
    #[new]
    #[pyo3(signature = (
        problem_, settings_, *, fp, lanes, dividers, banks, address_bits, microcode_words, clusters=1, rows=None, streams=vec![],
        leaves=None, misread=None, copies=1
    ))]
    #[allow(clippy::too_many_arguments, clippy::needless_pass_by_value)] // fields of a configuration, owned by the binding
    fn new(
        py: Python<'_>,
        problem_: &Bound<'_, PyAny>,
        settings_: &Bound<'_, PyAny>,
        fp: u32,
        lanes: usize,
        dividers: usize,
        banks: usize,
        address_bits: u32,
        microcode_words: usize,
        clusters: usize,
        rows: Option<usize>,
        streams: Vec<Vec<String>>,
        leaves: Option<Vec<String>>,
        misread: Option<(String, i32)>,
        copies: u32,
    ) -> PyResult<Self> {
        let (problem, settings) = (problem(problem_)?, settings(settings_)?);
        let stages = |names: &Vec<String>| names.iter().map(|name| stage_of(name)).collect::<PyResult<_>>();
        let streams: Vec<Vec<Stage>> = streams.iter().map(stages).collect::<PyResult<_>>()?;
        let leaves: Option<Vec<Buffer>> =
            leaves.map(|names| names.iter().map(|name| buffer_of(name)).collect()).transpose()?;
        let precision = match fp {
            64 => Precision::F64,
            32 => Precision::F32,
            other => {
                return Err(HardwareError::new_err(format!(
                    "configuration `fp` = {other}: allowed is 64 or 32"
                )))
            }
        };
        let wrong = misread.map(|(unit, by)| Timing::of(precision).misread(&unit, by));
        let timing = wrong.transpose().map_err(unfit)?;
        let engine = Configuration {
            precision,
            lanes,
            dividers,
            banks,
            clusters,
            address_bits,
            rows,
            microcode_words,
            timing,
        };
        if copies == 0 {
            return Err(HardwareError::new_err("`copies` = 0: allowed is 1 or more"));
        }
        py.detach(|| {
            engine.validate().map_err(unfit)?;
            let recording = orbsoc::record_tapes(&problem, &settings).map_err(refuse)?;
            // Without the seventh module on it, the engine's storage has no place for what only that module uses.
            let other = |stage: Stage| stage.module() != Module::Statistics;
            let recording =
                if streams.iter().flatten().copied().all(other) { recording.only(other) } else { recording };
            // Before the operations of all problems are made: they may be many more than an engine could hold words of.
            let needed =
                Layout::new(&recording, &engine).map_err(unfit)?.locations().count() * copies as usize;
            let available = engine.words();
            if needed > available {
                let key = if rows.is_some() { "rows" } else { "address_bits" };
                return Err(unfit(orbsoc_hw::Error::Storage {
                    key,
                    needed_by: "buffers",
                    needed,
                    available,
                }));
            }
            let recording = interleaved(&recording, copies);
            let made = match streams.as_slice() {
                [] => Program::both(&recording, &engine),
                streams => Program::streams(&recording, &engine, streams, leaves.as_deref()),
            };
            let (program, compact) = made.map_err(unfit)?;
            let compressed = compact.compressed();
            Ok(Self { program, compact, compressed, problem, settings, copies: copies as usize })
        })
    }

    /// Words of storage: architectural locations, and the maximum that a segment uses.
    #[getter]
    fn storage_words(&self) -> (u32, u32) {
        let most = self.program.segments.iter().map(|segment| segment.schedule.storage).max();
        (self.program.layout.words(), most.unwrap_or(0))
    }

    /// Words of storage that would do for all segments, those of compressed microcode included.
    #[getter]
    fn least_storage_words(&self) -> u32 {
        let segments = self.program.segments.iter().chain(&self.compact.segments);
        segments.map(|segment| segment.schedule.least_storage).max().unwrap_or(0)
    }

    /// One dictionary for each segment.
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for (number, segment) in self.program.segments.iter().enumerate() {
            out.set_item(segment.name(), self.describe(py, number, segment)?)?;
        }
        Ok(out)
    }

    /// Cycle, unit and operation of everything that a segment issues, in its "flat" or "compressed" microcode.
    ///
    /// Cycles count from the end of the start-up; frozen ones count too. Dividers count on from the lanes. Operations
    /// are positions in `operation_names`.
    #[pyo3(signature = (stage, format="flat"))]
    fn issues<'py>(&self, py: Python<'py>, stage: &str, format: &str) -> PyResult<Issued<'py>> {
        let (format, program) = self.in_format(format, Gaps { seed: 1, level: 0 })?;
        let number = program.segments.iter().position(|segment| segment.name() == stage);
        let number = number.ok_or_else(|| PyKeyError::new_err(format!("no segment named {stage:?}")))?;
        let issues = &program.segments[number].schedule.issues;
        let lanes = u8::try_from(program.configuration.lanes)?;
        let unit = |issue: &orbsoc_hw::Issue| issue.unit + if issue.code.on_divider() { lanes } else { 0 };
        let mut cycles: Vec<u32> = issues.iter().map(|issue| issue.cycle).collect();
        if format == Format::Compressed {
            let freezes = &self.compressed.freezes[number];
            let decode = program.configuration.timing().decode;
            for cycle in &mut cycles {
                let frozen = freezes.partition_point(|word| *word <= *cycle);
                *cycle += decode + u32::try_from(frozen)?;
            }
        }
        let operations: Vec<u8> = issues.iter().map(|issue| issue.code as u8).collect();
        Ok((
            cycles.into_pyarray(py),
            issues.iter().map(unit).collect::<Vec<_>>().into_pyarray(py),
            operations.into_pyarray(py),
        ))
    }

    /// What a segment's compressed microcode asks of the memory that it is streamed from.
    fn demand(&self, stage: &str) -> PyResult<SegmentDemand> {
        let number = self.compact.segments.iter().position(|segment| segment.name() == stage);
        let number = number.ok_or_else(|| PyKeyError::new_err(format!("no segment named {stage:?}")))?;
        Ok(SegmentDemand(self.compressed.demand(number)))
    }

    /// Names of the engine's operations.
    #[staticmethod]
    fn operation_names() -> Vec<&'static str> {
        Code::ALL.iter().map(|code| code.name()).collect()
    }

    /// Busy cycles of every segment on the in-order engine.
    fn in_order<'py>(&self, py: Python<'py>, seed: u32, level: u32) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        let gaps = Gaps { seed, level };
        gaps.validate().map_err(unfit)?;
        for segment in &self.program.segments {
            let run = orbsoc_hw::run_in_order(&segment.schedule, gaps, &self.program.configuration);
            out.set_item(segment.name(), run.cycles)?;
        }
        Ok(out)
    }

    /// The text of a validation case: every stage of a module on the words of a solve, or of as many as the program's
    /// segments work on: `others` are the problems beside its own.
    #[pyo3(signature = (module, format, *, seed=1, level=0, others=vec![]))]
    #[allow(clippy::needless_pass_by_value)] // what the binding hands over is owned
    fn case(
        &self,
        py: Python<'_>,
        module: &str,
        format: &str,
        seed: u32,
        level: u32,
        others: Vec<Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        let known = Stage::ALL.iter().map(|stage| stage.module()).find(|known| known.name() == module);
        let module: Module = known.ok_or_else(|| PyKeyError::new_err("no module of that name"))?;
        let (format, program) = self.in_format(format, Gaps { seed, level })?;
        if others.len() + 1 != self.copies {
            return Err(HardwareError::new_err(format!(
                "`others`: {} given; a program of {} interleaved takes {}",
                others.len(),
                self.copies,
                self.copies - 1
            )));
        }
        let others = others.iter().map(problem).collect::<PyResult<Vec<_>>>()?;
        py.detach(|| match program.configuration.precision {
            Precision::F64 => self.written::<f64>(program, &others, module, format),
            Precision::F32 => self.written::<f32>(program, &others, module, format),
        })
    }
}

/// The items of a segment's compressed microcode.
#[pyclass(module = "orbsoc._core", frozen)]
pub struct SegmentDemand(Demand);

#[pymethods]
impl SegmentDemand {
    /// Busy cycles where the lines come from memory, by `ports` with beats of `beat_bits`; a burst comes `latency` cycles
    /// after its address, and `beats` beats in `per` cycles.
    #[pyo3(signature = (*, ports, beat_bits, latency, beats, per))]
    fn cycles(
        &self,
        py: Python<'_>,
        ports: usize,
        beat_bits: usize,
        latency: u32,
        beats: u32,
        per: u32,
    ) -> PyResult<u32> {
        let memory = Streaming { ports, beat_bits, latency, beats, per };
        py.detach(|| self.0.cycles(memory)).map_err(unfit)
    }
}

impl HardwareProgram {
    fn written<T: Compiled>(
        &self,
        program: &Program,
        others: &[Arc<Problem>],
        module: Module,
        format: Format,
    ) -> PyResult<String> {
        let problems = core::iter::once(&self.problem).chain(others);
        let solves: Result<Vec<_>, _> =
            problems.map(|problem| snapshots::<T>(problem, &self.settings)).collect();
        validation_case(program, &solves.map_err(refuse)?, module, format).map_err(unfit)
    }
}

fn stage_of(name: &str) -> PyResult<Stage> {
    let found = Stage::ALL.iter().find(|stage| stage.name() == name);
    found
        .copied()
        .ok_or_else(|| HardwareError::new_err(format!("stage `{name}`: there is none of that name")))
}

fn buffer_of(name: &str) -> PyResult<Buffer> {
    let found = Buffer::ALL.iter().find(|buffer| buffer.name() == name);
    found
        .copied()
        .ok_or_else(|| HardwareError::new_err(format!("buffer `{name}`: there is none of that name")))
}

impl HardwareProgram {
    /// A format by its name, and its schedules.
    pub fn in_format(&self, name: &str, gaps: Gaps) -> PyResult<(Format, &Program)> {
        gaps.validate().map_err(unfit)?;
        match name {
            "flat" => Ok((Format::Flat, &self.program)),
            "compressed" => Ok((Format::Compressed, &self.compact)),
            "in_order" => Ok((Format::InOrder(gaps), &self.program)),
            _ => Err(PyKeyError::new_err("no format of that name")),
        }
    }

    fn describe<'py>(
        &self,
        py: Python<'py>,
        number: usize,
        segment: &Segment,
    ) -> PyResult<Bound<'py, PyDict>> {
        let schedule = &segment.schedule;
        let compressed = self.compressed.segments[number];
        let out = PyDict::new(py);
        out.set_item("module", segment.stage.module().name())?;
        out.set_item("cycles", schedule.cycles)?;
        out.set_item("lower_bound", segment.schedule.bounds.cycles())?;
        out.set_item("bottleneck", segment.schedule.bounds.bottleneck())?;
        out.set_item("operations", schedule.issues.len())?;
        out.set_item("lane_operations", schedule.lane_operations)?;
        out.set_item("utilisation", schedule.utilisation(&self.program.configuration))?;
        out.set_item("words", schedule.words)?;
        out.set_item("flat_bits", u64::from(schedule.words) * self.program.configuration.flat_bits() as u64)?;
        out.set_item("compressed_bits", compressed.bits)?;
        out.set_item("compressed_cycles", compressed.cycles)?;
        let mut causes_compressed = self.compact.segments[number].schedule.causes;
        causes_compressed.fetch += compressed.cycles - self.compact.segments[number].schedule.cycles;
        out.set_item("compressed_causes", causes(py, &causes_compressed)?)?;
        out.set_item("causes", causes(py, &schedule.causes)?)?;
        out.set_item("lane_causes", causes(py, &schedule.slots)?)?;
        Ok(out)
    }
}

fn causes<'py>(py: Python<'py>, causes: &Causes) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    for (name, cycles) in causes.named() {
        out.set_item(name, cycles)?;
    }
    Ok(out)
}
