//! The JSON Schemas of what is said to other processes are those of the types. `WRITE_SCHEMA=1 cargo test -p
//! rpl-tests schemas` writes them anew.

use rpl_protocol::schema::schemas;
use rpl_tests::repository::{root, text_of};
use std::fs;

#[test]
fn the_schemas_are_those_of_the_types() {
    for (name, schema) in schemas() {
        let file = format!("protocol/schema/{name}");
        let text = serde_json::to_string_pretty(&schema).expect("a schema is JSON") + "\n";
        if std::env::var_os("WRITE_SCHEMA").is_some() {
            fs::write(root().join(&file), &text).expect("the file can be written");
        }
        assert!(text_of(&file) == text, "{file} is not that of the types; `WRITE_SCHEMA=1` writes it anew");
    }
}
