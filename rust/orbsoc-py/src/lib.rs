//! `orbsoc._core`: conversions between Python objects and the solver, and nothing else.
#![allow(missing_docs)] // documented where users meet it: python/orbsoc/_core.pyi

mod batch;
mod convert;
mod engine;
mod exact_engine;
mod hardware;
mod image;
mod method;
mod mixed;
mod orbit;
mod problem_data;
mod tables;
mod watch;

use pyo3::prelude::*;

#[pymodule]
mod _core {
    #[pymodule_export]
    use super::batch::{BatchSolver, RawBatch};
    #[pymodule_export]
    use super::convert::{check_cost, CoreError};
    #[pymodule_export]
    use super::engine::{Engine, RawSolution};
    #[pymodule_export]
    use super::exact_engine::ExactEngine;
    #[pymodule_export]
    use super::hardware::{HardwareError, HardwareProgram, SegmentDemand};
    #[pymodule_export]
    use super::image::{program_image, ProgramImage};
    #[pymodule_export]
    use super::method::{
        closing, factor_shape, iteration, operation_counts, restarts, stages, startup, warm_startup,
        RestartInfo, StageInfo,
    };
    #[pymodule_export]
    use super::mixed::MixedEngine;
    #[pymodule_export]
    use super::orbit::OrbitField;
    #[pymodule_export]
    use super::problem_data::ProblemData;
    #[pymodule_export]
    use super::tables::{driver_sources, flight_mission_sources, flight_sources, pattern_tables};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("NEXT", super::engine::NEXT)?;
        module.add("REPEAT", super::engine::REPEAT)?;
        module.add("DONE", super::engine::DONE)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
