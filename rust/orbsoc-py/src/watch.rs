//! Interruption of a running solve by Ctrl-C or the user's callback.

use core::ops::ControlFlow;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::{Duration, Instant};

/// Interval at which a running solve checks for Ctrl-C; shorter iterations are grouped.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(1);

/// Watches one solve, whose thread has released the GIL.
pub struct Watch<'a> {
    callback: Option<&'a Py<PyAny>>,
    looked: Instant,
    raised: Option<PyErr>,
    /// Ctrl-C has asked the solve to stop.
    interrupted: bool,
}

impl<'a> Watch<'a> {
    pub fn new(callback: Option<&'a Py<PyAny>>) -> Self {
        Self { callback, looked: Instant::now(), raised: None, interrupted: false }
    }

    /// After an iteration: whether to continue. A callback sees every iteration.
    pub fn look(
        &mut self,
        progress: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyDict>>,
    ) -> ControlFlow<()> {
        if self.callback.is_none() && self.looked.elapsed() < SIGNAL_INTERVAL {
            return ControlFlow::Continue(());
        }
        self.attached(|watch, py| watch.ask(py, progress))
    }

    /// Within an iteration: whether to continue. No callback is called.
    pub fn wait(&mut self) -> ControlFlow<()> {
        self.attached(|_, py| py.check_signals().map(ControlFlow::Continue))
    }

    fn attached(
        &mut self,
        ask: impl for<'py> FnOnce(&Self, Python<'py>) -> PyResult<ControlFlow<()>>,
    ) -> ControlFlow<()> {
        self.looked = Instant::now();
        Python::attach(|py| {
            ask(self, py).unwrap_or_else(|error| {
                if error.is_instance_of::<PyKeyboardInterrupt>(py) {
                    self.interrupted = true;
                } else {
                    self.raised = Some(error);
                }
                ControlFlow::Break(())
            })
        })
    }

    /// As [`Watch::look`], but no more often than every `SIGNAL_INTERVAL`, callback or not.
    pub fn glance(
        &mut self,
        progress: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyDict>>,
    ) -> ControlFlow<()> {
        if self.looked.elapsed() < SIGNAL_INTERVAL {
            return ControlFlow::Continue(());
        }
        self.look(progress)
    }

    /// Ctrl-C, also one in the callback, ends a solve without an exception if a status `tells` of it. Without such a status
    /// (all solves had ended) it is raised, as are exceptions of the callback and of other signals' handlers.
    pub fn conclude(self, tells: impl FnOnce() -> bool) -> PyResult<()> {
        match self.raised {
            Some(error) => Err(error),
            None if self.interrupted && !tells() => Err(PyKeyboardInterrupt::new_err(())),
            None => Ok(()),
        }
    }

    fn ask<'py>(
        &self,
        py: Python<'py>,
        progress: impl FnOnce(Python<'py>) -> PyResult<Bound<'py, PyDict>>,
    ) -> PyResult<ControlFlow<()>> {
        py.check_signals()?;
        let Some(callback) = self.callback else { return Ok(ControlFlow::Continue(())) };
        let stop = callback.call1(py, (progress(py)?,))?.is_truthy(py)?;
        Ok(if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    }
}
