//! How much of a work of many parts is done: a bar on a terminal, and elsewhere a line now and then.

use super::console::Console;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

/// Where there is no terminal, a line comes this often at most.
const LINE_EVERY: Duration = Duration::from_secs(60);

/// A bar of a template of `indicatif`, for `parts` parts; nobody sees it where there is no terminal.
pub fn bar(parts: u64, template: &str, console: &Console) -> ProgressBar {
    let is_shown = !console.quiet && io::stderr().is_terminal();
    let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(parts), target);
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// The runs over seeds that are done.
pub struct Runs {
    bar: ProgressBar,
    /// Where there is no terminal: what is run, and when a line came last.
    lines: Option<(String, Instant)>,
}

impl Runs {
    /// So many runs of what has this name.
    pub fn new(runs: u64, name: &str, console: &Console) -> Self {
        let bar = bar(runs, "{msg:18} {bar:30} {pos}/{len} {eta}", console);
        bar.set_message(name.to_string());
        let has_lines = !console.quiet && !io::stderr().is_terminal();
        Self { bar, lines: has_lines.then(|| (name.to_string(), Instant::now())) }
    }

    /// One more is done.
    pub fn one_more(&mut self, console: &mut Console) {
        self.bar.inc(1);
        if let Some((name, told)) = &mut self.lines
            && told.elapsed() >= LINE_EVERY
        {
            *told = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            console.note(&format!("{name}: {done} of {all} runs"));
        }
    }

    /// All are done, or no more will be.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }
}
