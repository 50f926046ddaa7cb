//! Who may stop a running solve: Ctrl-C and the user's callback.

use core::ops::ControlFlow;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::{Duration, Instant};

/// How often a running solve looks for Ctrl-C; shorter iterations are grouped.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(1);

/// Watches one solve, whose thread has let go of the GIL.
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

    /// After an iteration: whether to go on. Who has a callback is shown each one.
    pub fn look(
        &mut self,
        progress: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyDict>>,
    ) -> ControlFlow<()> {
        if self.callback.is_none() && self.looked.elapsed() < SIGNAL_INTERVAL {
            return ControlFlow::Continue(());
        }
        self.looked = Instant::now();
        Python::attach(|py| {
            self.ask(py, progress).unwrap_or_else(|error| {
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

    /// Ctrl-C ends a solve quietly, in the callback too, where a status `tells` of it. Where none does, as all had ended
    /// when it came, it goes up as ever, and so do exceptions of the callback and of other signals' handlers.
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
