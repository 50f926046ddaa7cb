//! The engine whose buffers have the layout of the tapes, for comparison with the RTL.

use crate::convert::{one_at_a_time, problem, refuse, settings};
use crate::engine::{borrowed, owned, raw_solution, stage_of, Point, RawSolution, DONE, NEXT, REPEAT};
use crate::hardware::HardwareError;
use numpy::{PyArray1, PyReadonlyArray1};
use orbsoc::{Buffer, Decide, Outcome};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

/// A word as its bits, the upper ones zero.
trait Word: Decide {
    fn bits(self) -> u64;
    fn of_bits(bits: u64) -> Self;
}

impl Word for f64 {
    fn bits(self) -> u64 {
        self.to_bits()
    }
    fn of_bits(bits: u64) -> Self {
        Self::from_bits(bits)
    }
}

impl Word for f32 {
    fn bits(self) -> u64 {
        u64::from(self.to_bits())
    }
    #[allow(clippy::cast_possible_truncation)] // the lower half is the word
    fn of_bits(bits: u64) -> Self {
        Self::from_bits(bits as u32)
    }
}

enum Either {
    Double(orbsoc::Engine<f64>),
    Single(orbsoc::Engine<f32>),
}

macro_rules! with {
    ($either:expr, $engine:ident => $body:expr) => {
        match $either {
            Either::Double($engine) => $body,
            Either::Single($engine) => $body,
        }
    };
}

#[pyclass(module = "orbsoc._core", frozen)]
pub struct ExactEngine(Mutex<Either>);

#[pymethods]
impl ExactEngine {
    #[new]
    fn new(
        py: Python<'_>,
        problem_: &Bound<'_, PyAny>,
        settings_: &Bound<'_, PyAny>,
        fp: u32,
    ) -> PyResult<Self> {
        let (problem, settings) = (problem(problem_)?, settings(settings_)?);
        py.detach(|| {
            let made = match fp {
                64 => Either::Double(orbsoc::Engine::exact(&problem, &settings).map_err(refuse)?),
                32 => Either::Single(orbsoc::Engine::exact(&problem, &settings).map_err(refuse)?),
                other => return Err(HardwareError::new_err(format!("`fp` = {other}: allowed is 64 or 32"))),
            };
            Ok(Self(Mutex::new(made)))
        })
    }

    /// Run one stage: NEXT, REPEAT or DONE.
    fn run(&self, stage: &str) -> PyResult<u8> {
        let stage = stage_of(stage)?;
        Ok(match with!(&mut *self.state()?, engine => engine.run(stage)) {
            Outcome::Next => NEXT,
            Outcome::Repeat => REPEAT,
            Outcome::Done(_) => DONE,
        })
    }

    /// As `Engine.interrupt`.
    fn interrupt(&self) -> PyResult<()> {
        with!(&mut *self.state()?, engine => engine.interrupt());
        Ok(())
    }

    /// The whole solve, by the loop in Rust, from `start` = (x, y, z, s) if it is given.
    #[pyo3(signature = (start=None))]
    #[allow(clippy::needless_pass_by_value)] // what the binding hands over is owned
    fn solve(&self, py: Python<'_>, start: Option<Point<'_>>) -> PyResult<RawSolution> {
        let start = start.as_ref().map(owned);
        let state = &mut *self.state()?;
        let (solution, sizes) = py.detach(|| {
            with!(state, engine => {
                let solution = match &start {
                    Some(from) => engine.solve_from(&borrowed(from)),
                    None => Ok(engine.solve()),
                };
                (solution, engine.kkt_sizes())
            })
        });
        Ok(raw_solution(py, solution.map_err(refuse)?, sizes, (Duration::ZERO, Duration::ZERO)))
    }

    /// As `Engine.start_from`.
    #[allow(clippy::needless_pass_by_value)] // what the binding hands over is owned
    fn start_from(&self, start: Point<'_>) -> PyResult<bool> {
        with!(&mut *self.state()?, engine => engine.start_from(&borrowed(&owned(&start)))).map_err(refuse)
    }

    /// The bits of the words of a buffer at `indices`; without them, of all words.
    #[pyo3(signature = (buffer, indices=None))]
    #[allow(clippy::needless_pass_by_value)] // what the binding hands over is owned
    fn words<'py>(
        &self,
        py: Python<'py>,
        buffer: &str,
        indices: Option<PyReadonlyArray1<'py, u32>>,
    ) -> PyResult<Bound<'py, PyArray1<u64>>> {
        let buffer = buffer_of(buffer)?;
        let all = with!(&*self.state()?, engine => bits(engine.buffer(buffer)));
        let some = match indices {
            None => Some(all),
            Some(indices) => {
                indices.as_array().iter().map(|&index| all.get(index as usize).copied()).collect()
            }
        };
        some.map(|words| PyArray1::from_vec(py, words)).ok_or_else(|| out_of_range(buffer))
    }

    /// Replace some words of a buffer by their bits.
    #[allow(clippy::needless_pass_by_value)] // what the binding hands over is owned
    fn set_words(
        &self,
        buffer: &str,
        indices: PyReadonlyArray1<'_, u32>,
        bits: PyReadonlyArray1<'_, u64>,
    ) -> PyResult<()> {
        let buffer = buffer_of(buffer)?;
        let (indices, bits) = (indices.as_array(), bits.as_array());
        let pairs = indices.iter().copied().zip(bits.iter().copied());
        let fits = indices.len() == bits.len()
            && with!(&mut *self.state()?, engine => set(engine.buffer_mut(buffer), pairs));
        if fits {
            Ok(())
        } else {
            Err(out_of_range(buffer))
        }
    }

    fn buffer_words<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (state, words) = (self.state()?, PyDict::new(py));
        for &buffer in Buffer::ALL {
            words.set_item(buffer.name(), with!(&*state, engine => engine.buffer(buffer).len()))?;
        }
        Ok(words)
    }

    fn events(&self) -> PyResult<Vec<(&'static str, u32)>> {
        let state = self.state()?;
        let events = with!(&*state, engine => engine.events());
        Ok(events.iter().map(|event| (event.stage.name(), event.iteration)).collect())
    }

    /// Take over the outcome of an attempt that ran elsewhere from the words that it left in these buffers.
    fn take_over(&self) -> PyResult<()> {
        with!(&mut *self.state()?, engine => engine.take_over());
        Ok(())
    }

    /// As `Engine.begin_again`.
    fn begin_again(&self) -> PyResult<bool> {
        Ok(with!(&mut *self.state()?, engine => {
            let solution = engine.conclude();
            engine.restart(&solution)
        }))
    }

    /// The solution of a finished attempt.
    fn finish(&self, py: Python<'_>) -> PyResult<RawSolution> {
        let state = self.state()?;
        let (solution, sizes) = with!(&*state, engine => (engine.conclude(), engine.kkt_sizes()));
        Ok(raw_solution(py, solution, sizes, (Duration::ZERO, Duration::ZERO)))
    }
}

impl ExactEngine {
    fn state(&self) -> PyResult<MutexGuard<'_, Either>> {
        one_at_a_time(&self.0)
    }
}

fn bits<T: Word>(words: &[T]) -> Vec<u64> {
    words.iter().map(|word| word.bits()).collect()
}

/// Set words by their bits. Whether every index is in range.
fn set<T: Word>(words: &mut [T], pairs: impl Iterator<Item = (u32, u64)>) -> bool {
    for (index, bits) in pairs {
        match words.get_mut(index as usize) {
            Some(word) => *word = T::of_bits(bits),
            None => return false,
        }
    }
    true
}

fn buffer_of(name: &str) -> PyResult<Buffer> {
    let buffer = Buffer::ALL.iter().find(|buffer| buffer.name() == name);
    buffer.copied().ok_or_else(|| PyKeyError::new_err(format!("no buffer named {name:?}")))
}

fn out_of_range(buffer: Buffer) -> PyErr {
    PyValueError::new_err(format!("buffer {:?} does not have these words", buffer.name()))
}
