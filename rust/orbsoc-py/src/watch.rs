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
}

impl<'a> Watch<'a> {
    pub fn new(callback: Option<&'a Py<PyAny>>) -> Self {
        Self { callback, looked: Instant::now(), raised: None }
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
                self.raised = Some(error);
                ControlFlow::Break(())
            })
        })
    }

    /// What the callback raised.
    pub fn raised(self) -> PyResult<()> {
        self.raised.map_or(Ok(()), Err)
    }

    /// Ctrl-C ends the solve quietly, in the callback too: its status says so. Other exceptions of the callback go up.
    fn ask<'py>(
        &self,
        py: Python<'py>,
        progress: impl FnOnce(Python<'py>) -> PyResult<Bound<'py, PyDict>>,
    ) -> PyResult<ControlFlow<()>> {
        if py.check_signals().is_err() {
            return Ok(ControlFlow::Break(()));
        }
        let Some(callback) = self.callback else { return Ok(ControlFlow::Continue(())) };
        match callback.call1(py, (progress(py)?,)).and_then(|wish| wish.is_truthy(py)) {
            Ok(false) => Ok(ControlFlow::Continue(())),
            Ok(true) => Ok(ControlFlow::Break(())),
            Err(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => Ok(ControlFlow::Break(())),
            Err(error) => Err(error),
        }
    }
}
