//! `rpl examples [NAME]`: the built-in plans, and the text of one.

use anyhow::{Result, bail};
use clap_complete::engine::ArgValueCompleter;
use rpl_lang::suggest::suggest;
use rpl_mission::examples::{all, find, names};
use rpl_shell::arguments::completion;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;

/// List the built-in plans, or show one
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Built-in plan
    #[arg(value_name = "NAME", add = ArgValueCompleter::new(completion::built_in))]
    name: Option<String>,
}

/// Lists, or shows.
///
/// # Errors
/// No example has the name.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    match arguments.name.as_deref() {
        None => {
            let width = names().map(str::len).max().unwrap_or(0);
            for (name, purpose) in all() {
                console.explain_hanging(&format!("{name:width$}  {purpose}"), width + 2)?;
            }
        }
        Some(name) => match find(name) {
            Some((_, text)) => console.print(text.trim_end())?,
            None => match suggest(name, names()).or_else(|| suggest(&format!("{name}.rpl"), names())) {
                Some(meant) => bail!("no example is called `{name}`; did you mean `{meant}`?"),
                None => bail!("no example is called `{name}`; `rpl examples` lists them"),
            },
        },
    }
    Ok(Status::Succeeded)
}
