//! What came of the tests, as `rpl test` tells it.

use rpl_drive::show::failure_report::FailureRecord;
use serde::Serialize;

/// What `--json` writes.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TestReport {
    pub tests: Vec<TestRecord>,
    pub succeeded: usize,
    pub failed: usize,
    /// Not all tests have come to their end.
    pub interrupted: bool,
    /// Files that could not be read or compiled.
    pub faulty_files: Vec<FaultyFile>,
    pub wall_s: f64,
}

impl TestReport {
    /// A line for people.
    pub fn summary(&self) -> String {
        let count = self.tests.len();
        let tests = if count == 1 { "1 test".to_string() } else { format!("{count} tests") };
        let how = match (self.failed, self.interrupted) {
            (0, false) if self.faulty_files.is_empty() => "all ok".to_string(),
            (0, false) => match self.faulty_files.len() {
                1 => "ok, but a file has errors".to_string(),
                faulty => format!("ok, but {faulty} files have errors"),
            },
            (0, true) => "then interrupted".to_string(),
            (failed, false) => format!("{failed} failed"),
            (failed, true) => format!("{failed} failed, then interrupted"),
        };
        format!("{tests}, {how}, in {:.1} s", self.wall_s)
    }
}

/// A file whose tests could not run.
#[derive(Clone, Debug, Serialize)]
pub struct FaultyFile {
    pub file: String,
    pub reason: String,
}

/// How a test went.
#[derive(Clone, Debug, Serialize)]
pub struct TestRecord {
    pub name: String,
    pub file: String,
    pub line: usize,
    pub outcome: &'static str,
    pub time_s: f64,
    pub seed: u64,
    pub world: Option<String>,
    pub failure: Option<FailureRecord>,
    pub output: Vec<String>,
    pub wall_s: f64,
    /// Why it did not succeed, for people.
    #[serde(skip)]
    pub reason: String,
}

impl TestRecord {
    pub fn has_succeeded(&self) -> bool {
        self.outcome == "succeeded"
    }
}
