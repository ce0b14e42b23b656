//! What fuzzers compare. Each of them is a file in `targets`; how they are run stands in CONTRIBUTING.md.

pub mod forms;
