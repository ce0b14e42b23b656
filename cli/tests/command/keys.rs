//! The keys of a JSON object, and those that the page about JSON documents.

use serde_json::Value;
use std::collections::BTreeSet;

/// Failures stand in failures: their keys are documented once.
const NESTED: [&str; 2] = ["causes", "while_cleaning_up"];

/// The keys documented in the section of a command, by the beginning of its title.
pub fn documented(section: &str) -> BTreeSet<String> {
    let page = include_str!("../../../docs/json.md");
    let sections = page.split("\n## ").filter(|text| text.starts_with(section));
    let rows = sections.flat_map(|text| text.lines().filter_map(|line| line.strip_prefix("| `")));
    let keys = rows.filter_map(|row| row.split(" | ").next());
    keys.flat_map(|keys| keys.split(", ")).map(|key| key.trim_matches('`').to_string()).collect()
}

/// Every key of a value, behind the keys that lead to it: `tests[].failure.class`.
pub fn found(value: &Value) -> BTreeSet<String> {
    let mut keys = BTreeSet::new();
    add(value, "", &mut keys);
    keys
}

fn add(value: &Value, path: &str, keys: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                keys.insert(path.clone());
                if !NESTED.contains(&name.as_str()) {
                    add(value, &path, keys);
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| add(item, &format!("{path}[]"), keys)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}
