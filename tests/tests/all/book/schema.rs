//! The JSON Schema of what is said to other processes is that of the types.
//!
//! `WRITE_SCHEMA=1 cargo test -p rpl-tests schema` writes it anew.

use rpl_protocol::host::{FromHost, ToHost};
use rpl_tests::repository::root;
use schemars::{Schema, schema_for};
use std::fs;

const FOLDER: &str = "protocol/schema";

fn schemas() -> [(&'static str, Schema); 2] {
    [("to-host", schema_for!(ToHost)), ("from-host", schema_for!(FromHost))]
}

#[test]
fn the_schemas_are_those_of_the_types() {
    let folder = root().join(FOLDER);
    for (name, schema) in schemas() {
        let text = format!("{}\n", serde_json::to_string_pretty(&schema).expect("a schema is JSON"));
        let path = folder.join(format!("{name}.json"));
        if std::env::var_os("WRITE_SCHEMA").is_some() {
            fs::create_dir_all(&folder).expect("the folder can be made");
            fs::write(&path, text).expect("the schema can be written");
        } else {
            let written = fs::read_to_string(&path).unwrap_or_default();
            assert!(written == text, "{FOLDER}/{name}.json is not that of the types; `WRITE_SCHEMA=1` writes it anew");
        }
    }
}
