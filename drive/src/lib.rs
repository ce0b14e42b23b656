//! Runs that are driven: paced, written down, shown, stopped, and gone on with.
//!
//! `run_driver` drives a system to its end, and `prepared_run` what belongs to one. Onlookers of a run are `trace`
//! (lines of JSON), `mcap` (recordings for ROS tools), `journal` (what a run is gone on with from), and `seen` (the page
//! in a browser); `run_record` is what is kept of it. `show` says what a person is told of a run. `stopping` says where a
//! run that is stepped through stands still, for the prompt, debuggers and the page. `recorded_run` and `hosts` are runs
//! that are repeated, and robots in other processes.

pub mod hosts;
pub mod journal;
pub mod mcap;
pub mod prepared_run;
pub mod recorded_run;
pub mod run_driver;
pub mod run_record;
pub mod seen;
pub mod show;
pub mod stopping;
pub mod trace;
