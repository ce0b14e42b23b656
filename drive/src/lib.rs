//! Runs that are driven: paced, written down, shown, stopped, and gone on with.
//!
//! A driver is a loop around the step of a system. It tells the onlookers of the run what happens, and knows none of
//! them. They change nothing in it: a run gives the same bytes with and without them.
//!
//! Read in this order:
//!
//! - `events`: the lines that a run has for a person;
//! - `show`: a run shown to a person: causes, tables, drawings;
//! - `onlooker`: what looks on at a run; `observed`: the one that keeps what a run was;
//! - `mcap`: an onlooker that writes recordings for ROS tools;
//! - `stopping`: where a run that is stepped through stands still; one rule for the prompt, debuggers and the page;
//! - `seen`: the onlooker behind the page in a browser, and the page's hand on the run;
//! - `recorded_run`: all that builds the same run again; `hosts`: robots in other processes;
//! - `trace`: lines of JSON; `journal`: the files from which a run is gone on with, its trace among them;
//! - `run_record`: what looks on at a run, writes it down, and steers it;
//! - `run_driver`: drives a system to its end; `prepared_run`: the same with everything that belongs to it.

pub mod events;
pub mod hosts;
pub mod journal;
pub mod mcap;
pub mod observed;
pub mod onlooker;
pub mod prepared_run;
pub mod recorded_run;
pub mod run_driver;
pub mod run_record;
pub mod seen;
pub mod show;
pub mod stopping;
pub mod trace;
