//! The JSON Schema of what is said, made from the types; it lies in `protocol/schema`.

use crate::host::{FromHost, ToHost};
use crate::module::message::{FromModule, ToModule};
use crate::value::Spoken;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema, schema_for};
use std::borrow::Cow;

/// Each schema, and the name of its file.
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("to-module.json", schema_for!(ToModule)),
        ("from-module.json", schema_for!(FromModule)),
        ("to-host.json", schema_for!(ToHost)),
        ("from-host.json", schema_for!(FromHost)),
    ]
}

impl JsonSchema for Spoken {
    fn schema_name() -> Cow<'static, str> {
        "Value".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let inner = generator.subschema_for::<Spoken>();
        json_schema!({
            "description": "A value of plans: nil, t, an integer, a float, a text, a symbol, a list; lists are at most 64 deep.",
            "anyOf": [
                { "type": ["null", "boolean", "number", "string"] },
                {
                    "type": "object",
                    "properties": { "symbol": { "type": "string" } },
                    "required": ["symbol"],
                    "additionalProperties": false
                },
                { "type": "array", "items": inner }
            ]
        })
    }
}
