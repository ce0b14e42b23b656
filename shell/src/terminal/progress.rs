//! A bar that says how much of a work of many parts is done, on a terminal only.

use super::console::Console;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};

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

/// The bar of runs over seeds, with the name of what is run.
pub fn runs(runs: u64, name: &str, console: &Console) -> ProgressBar {
    let bar = bar(runs, "{msg:18} {bar:30} {pos}/{len} {eta}", console);
    bar.set_message(name.to_string());
    bar
}
