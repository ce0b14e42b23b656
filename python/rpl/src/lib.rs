//! Missions for Python: what the package `rpl` is made of, beside the Python in `rpl/`.
//!
//! Rust keeps the run, steps it without the interpreter's lock, and hands out what is in it; exceptions, data frames and
//! experiments are made of that in Python.
//!
//! Read in this order: `place`, `module`, `history`, `mission`.

mod fault;
mod history;
mod mission;
mod module;
mod place;

use fault::{SetUpError, wrong};
use pyo3::prelude::*;
use rpl_command::embedded;
use std::ffi::OsString;

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
