//! The JSON Schema of what is said, made from the types; it lies in `protocol/schema`.

use crate::host::{FromHost, ToHost};
use crate::module::message::{FromModule, ToModule};
use schemars::{Schema, schema_for};

/// Each schema, and the name of its file.
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("to-module.json", schema_for!(ToModule)),
        ("from-module.json", schema_for!(FromModule)),
        ("to-host.json", schema_for!(ToHost)),
        ("from-host.json", schema_for!(FromHost)),
    ]
}
