//! What does not go together, as an exception.

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

create_exception!(rpl.rpl_native, SetUpError, PyValueError, "Plan, world, robot and scenario do not go together.");

/// What was found, where, and what would be right.
pub fn wrong(error: anyhow::Error) -> PyErr {
    SetUpError::new_err(format!("{error:#}"))
}
