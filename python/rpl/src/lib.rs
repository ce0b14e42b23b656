//! Missions for Python: what the package `rpl` is made of, beside the Python in `rpl/`.
//!
//! Rust keeps the run, steps it without the interpreter's lock, and hands out what is in it; exceptions, data frames and
//! experiments are made of that in Python.
//!
//! Read in this order: `place`, `module`, `history`, `mission`.

mod history;
mod mission;
mod module;
mod place;

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rpl_command::embedded;
use rpl_robot::geometry::Pose;
use std::ffi::OsString;

create_exception!(rpl.rpl_native, SetUpError, PyValueError, "Plan, world, robot and scenario do not go together.");

/// A pose as Python has it: x and y in metres, the heading in radians.
type PoseTuple = (f64, f64, f64);

fn tuple(pose: Pose) -> PoseTuple {
    (pose.x_m, pose.y_m, pose.heading_rad)
}

/// What was found, where, and what would be right.
fn wrong(error: anyhow::Error) -> PyErr {
    SetUpError::new_err(format!("{error:#}"))
}

/// Does what the command `rpl` does with these words, of which the first is its own name. Answers its exit status.
#[pyfunction]
fn command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| embedded::command(words))
}

/// What `rpl check` finds in a plan, as JSON.
#[pyfunction]
fn check(py: Python<'_>, name: String, text: Option<String>) -> PyResult<String> {
    py.detach(|| Ok(embedded::findings(&mission::text_of(name, text, embedded::plan)?)?.to_string())).map_err(wrong)
}

#[pymodule]
fn rpl_native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<mission::Mission>()?;
    module.add_class::<place::World>()?;
    module.add_class::<place::Robot>()?;
    module.add("SetUpError", module.py().get_type::<SetUpError>())?;
    module.add("BUILD", embedded::BUILD)?;
    module.add_function(wrap_pyfunction!(command, module)?)?;
    module.add_function(wrap_pyfunction!(check, module)?)?;
    Ok(())
}
