//! The commands of the prompt: one table for parsing, help and completion.

use rpl_lang::suggest::suggest;

/// What a command does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verb {
    Load,
    Run,
    Step,
    Next,
    Into,
    Out,
    Continue,
    Until,
    Go,
    Stop,
    Break,
    Delete,
    Watch,
    Abort,
    Back,
    At,
    Fork,
    Forks,
    Switch,
    Why,
    Tasks,
    Task,
    Fluents,
    Valves,
    Map,
    Trace,
    Doc,
    Help,
    Quit,
}

impl Verb {
    /// Whether the run is taken into the hand, so that the clock stops.
    pub fn steers(self) -> bool {
        use Verb::{Abort, At, Back, Continue, Into, Next, Out, Run, Step, Switch, Until};
        matches!(self, Run | Step | Next | Into | Out | Continue | Until | Abort | Back | At | Switch)
    }
}

/// A command as the help shows it.
pub struct Entry {
    /// What is typed, with the colon.
    pub name: &'static str,
    /// What may follow.
    pub arguments: &'static str,
    /// What it does.
    pub doc: &'static str,
    /// The same for the program.
    pub verb: Verb,
}

const fn entry(name: &'static str, arguments: &'static str, doc: &'static str, verb: Verb) -> Entry {
    Entry { name, arguments, doc, verb }
}

/// All commands, in the order of the help.
pub const COMMANDS: &[Entry] = &[
    entry(":load", "FILE", "runs a file; what it defines counts from the next call on", Verb::Load),
    entry(":run", "FORM", "runs a form to its end, past all breakpoints", Verb::Run),
    entry(":step", "[FORM]", "goes to the next form, of any task; or begins with FORM", Verb::Step),
    entry(":next", "", "goes to the next form of this call, over what it calls", Verb::Next),
    entry(":into", "", "goes into what the marked form calls", Verb::Into),
    entry(":out", "", "goes to where this call was made from", Verb::Out),
    entry(":continue", "", "goes on to the end or the next breakpoint", Verb::Continue),
    entry(
        ":until",
        "TIME|LINE|NAME|(CONDITION)",
        "goes on to a time such as 12.5s, a place, or a condition",
        Verb::Until,
    ),
    entry(":go", "[FACTOR]", "goes on by the clock, FACTOR times as fast, while you type", Verb::Go),
    entry(":stop", "", "stops the clock; so does Ctrl-C on an empty line", Verb::Stop),
    entry(":break", "[NAME|LINE|FILE:LINE|(CONDITION)]", "stops there from now on; lists where it stops", Verb::Break),
    entry(":delete", "[N]", "takes back breakpoint N, or all", Verb::Delete),
    entry(":watch", "[EXPR]", "shows it at every stop; without one, shows no more", Verb::Watch),
    entry(":abort", "", "gives up the form that runs; its clean-ups run", Verb::Abort),
    entry(":back", "[N|TIME]", "goes back a step, N steps, or a time such as 10s", Verb::Back),
    entry(":at", "TIME", "goes back to an instant of the run", Verb::At),
    entry(":fork", "NAME", "keeps the run as it is now under a name", Verb::Fork),
    entry(":forks", "", "lists the runs that are kept", Verb::Forks),
    entry(":switch", "NAME", "goes to another run and keeps this one", Verb::Switch),
    entry(":why", "[PATH]", "why a task waits, or how it ended: the chain of causes", Verb::Why),
    entry(":tasks", "", "the tree of tasks, what each waits for, and its valves", Verb::Tasks),
    entry(":task", "PATH", "one task: its form, its calls, its variables", Verb::Task),
    entry(":fluents", "[WORD]", "the fluents and their values", Verb::Fluents),
    entry(":valves", "", "the valves, who holds them and who waits", Verb::Valves),
    entry(":map", "", "the world, the robot, and where it believes itself to be", Verb::Map),
    entry(":trace", "[WORD...]", "the last events, those that hold all the words", Verb::Trace),
    entry(":doc", "[NAME]", "documents a name", Verb::Doc),
    entry(":help", "", "this list", Verb::Help),
    entry(":quit", "", "ends the session; so does Ctrl-D", Verb::Quit),
];

/// The verb of a line that begins with a colon, and what follows it.
///
/// # Errors
/// There is no such command; the near one is named.
pub fn parse(line: &str) -> Result<(Verb, &str), String> {
    let line = line.trim();
    let (name, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    match COMMANDS.iter().find(|entry| entry.name == name) {
        Some(entry) => Ok((entry.verb, rest.trim())),
        None => Err(match suggest(name, COMMANDS.iter().map(|entry| entry.name)) {
            Some(near) => format!("there is no command `{name}`; did you mean `{near}`? `:help` lists them"),
            None => format!("there is no command `{name}`; `:help` lists them"),
        }),
    }
}

/// The list that `:help` shows.
pub fn help() -> Vec<String> {
    let usage = |entry: &Entry| format!("{} {}", entry.name, entry.arguments).trim_end().to_string();
    let short = |entry: &&Entry| usage(entry).chars().count() <= 18;
    let width = COMMANDS.iter().filter(short).map(|entry| usage(entry).chars().count()).max().unwrap_or(0);
    let mut lines = Vec::new();
    for entry in COMMANDS {
        let usage = usage(entry);
        if usage.chars().count() > width {
            lines.push(usage);
            lines.push(format!("{:width$}  {}", "", entry.doc));
        } else {
            lines.push(format!("{usage:width$}  {}", entry.doc));
        }
    }
    lines.push("Anything else is a form of the language; `_` is the value of the last one.".to_string());
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_command_names_the_near_one() {
        assert_eq!(parse(":back 10s"), Ok((Verb::Back, "10s")));
        let error = parse(":contineu").expect_err("there is no such command");
        assert!(error.contains("did you mean `:continue`?"), "{error}");
    }

    #[test]
    fn the_help_fits_a_narrow_terminal() {
        for line in help() {
            assert!(line.chars().count() < 80, "{line}");
        }
    }
}
