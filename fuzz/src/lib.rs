//! What fuzzers compare. Each of them is a file in `targets`; how they are run stands in CONTRIBUTING.md. They are a
//! workspace by themselves, compiled to tell which code an input reaches.

pub mod forms;
