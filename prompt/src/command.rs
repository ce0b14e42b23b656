//! The commands of the prompt: one table for parsing, help and completion.

use rpl_lang::suggest::suggest;

/// What a command does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verb {
    Load,
    Run,
    Time,
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
    Project,
    Trace,
    Doc,
    Source,
    Edit,
    Save,
    Help,
    Quit,
}

impl Verb {
    /// Whether the run is taken into the hand, so that the clock stops.
    pub fn steers(self) -> bool {
        use Verb::{Abort, At, Back, Continue, Into, Next, Out, Run, Step, Switch, Time, Until};
        matches!(self, Run | Time | Step | Next | Into | Out | Continue | Until | Abort | Back | At | Switch)
    }
}

/// What the commands of the prompt are for, with the first of each kind, in the order of the help.
const GROUPS: &[(&str, Verb)] = &[
    ("Running", Verb::Load),
    ("Stepping", Verb::Step),
    ("Going back", Verb::Back),
    ("Looking", Verb::Why),
    ("Texts", Verb::Doc),
    ("The prompt", Verb::Help),
];

/// A command as the help shows it.
#[derive(Debug, PartialEq, Eq)]
pub struct CommandEntry {
    /// What is typed, with the colon.
    pub name: &'static str,
    /// What may follow.
    pub arguments: &'static str,
    /// What it does.
    pub doc: &'static str,
    /// The same for the program.
    pub verb: Verb,
    /// A line as it could be typed.
    pub example: &'static str,
    /// What else there is to know, or nothing.
    pub more: &'static str,
}

/// All commands, in the order of the help.
pub const COMMANDS: &[CommandEntry] = &[
    CommandEntry {
        name: ":load",
        arguments: "FILE",
        doc: "runs a file; what it defines counts from the next call on",
        verb: Verb::Load,
        example: ":load delivery.rpl",
        more: "FILE is a plan file or a built-in example. While a form is under way the file is run beside it, so that a plan can be changed in the midst of its run.",
    },
    CommandEntry {
        name: ":run",
        arguments: "FORM",
        doc: "runs a form to its end, past all breakpoints",
        verb: Verb::Run,
        example: ":run (greet 'ann)",
        more: "The breakpoints are there again afterwards.",
    },
    CommandEntry {
        name: ":time",
        arguments: "FORM",
        doc: "runs a form, and tells what it cost",
        verb: Verb::Time,
        example: ":time (sort (list 3 1 2) #'<)",
        more: "Computing is told in seconds of the clock on the wall, steps are calls and turns of loops, and the time of the plan is that of `now`.",
    },
    CommandEntry {
        name: ":step",
        arguments: "[FORM]",
        doc: "goes to the next form, of any task; or begins with FORM",
        verb: Verb::Step,
        example: ":step (greet 'ann)",
        more: "It stands before forms that call, wait, assign or start tasks, in your own text: what the library does is stepped over. An empty line does the same again.",
    },
    CommandEntry {
        name: ":next",
        arguments: "",
        doc: "goes to the next form of this call, over what it calls",
        verb: Verb::Next,
        example: ":next",
        more: "An empty line does the same again.",
    },
    CommandEntry {
        name: ":into",
        arguments: "",
        doc: "goes into what the marked form calls, also into the library",
        verb: Verb::Into,
        example: ":into",
        more: "Inside the library `:step` and `:next` go on in it, and `:out` leaves it.",
    },
    CommandEntry {
        name: ":out",
        arguments: "",
        doc: "goes to where this call was made from",
        verb: Verb::Out,
        example: ":out",
        more: "",
    },
    CommandEntry {
        name: ":continue",
        arguments: "",
        doc: "goes on to the end or the next breakpoint",
        verb: Verb::Continue,
        example: ":continue",
        more: "",
    },
    CommandEntry {
        name: ":until",
        arguments: "TIME|LINE|NAME|(CONDITION)",
        doc: "goes on to a time such as 12.5s, a place, or a condition",
        verb: Verb::Until,
        example: ":until (> level 2)",
        more: "It takes what `:break` takes, for once, or a time of the run.",
    },
    CommandEntry {
        name: ":go",
        arguments: "[FACTOR]",
        doc: "goes on by the clock, FACTOR times as fast, while you type",
        verb: Verb::Go,
        example: ":go 10",
        more: "",
    },
    CommandEntry {
        name: ":stop",
        arguments: "",
        doc: "stops the clock; so does Ctrl-C on an empty line",
        verb: Verb::Stop,
        example: ":stop",
        more: "",
    },
    CommandEntry {
        name: ":break",
        arguments: "[NAME|LINE|FILE:LINE|(CONDITION)|failure]",
        doc: "stops there from now on; lists where it stops",
        verb: Verb::Break,
        example: ":break (< pos-certainty* 0.5)",
        more: "NAME is a plan, a function or a tag. A condition stops the run when it becomes true, `failure` at the failure that ends a form, with everything alive as it was.",
    },
    CommandEntry {
        name: ":delete",
        arguments: "[N]",
        doc: "takes back breakpoint N, or all",
        verb: Verb::Delete,
        example: ":delete 1",
        more: "",
    },
    CommandEntry {
        name: ":watch",
        arguments: "[EXPR]",
        doc: "shows it at every stop; without one, shows no more",
        verb: Verb::Watch,
        example: ":watch (value level)",
        more: "",
    },
    CommandEntry {
        name: ":abort",
        arguments: "",
        doc: "gives up the form that runs; its clean-ups run",
        verb: Verb::Abort,
        example: ":abort",
        more: "",
    },
    CommandEntry {
        name: ":back",
        arguments: "[N|TIME|failure]",
        doc: "goes back a step, N steps, a time, or to the last failure",
        verb: Verb::Back,
        example: ":back 10s",
        more: "All is as it was then, definitions included; what came after is forgotten. `:fork` keeps it.",
    },
    CommandEntry {
        name: ":at",
        arguments: "TIME",
        doc: "goes back to an instant of the run",
        verb: Verb::At,
        example: ":at 12.5s",
        more: "",
    },
    CommandEntry {
        name: ":fork",
        arguments: "NAME",
        doc: "keeps the run as it is now under a name",
        verb: Verb::Fork,
        example: ":fork before",
        more: "",
    },
    CommandEntry {
        name: ":forks",
        arguments: "",
        doc: "lists the runs that are kept",
        verb: Verb::Forks,
        example: ":forks",
        more: "",
    },
    CommandEntry {
        name: ":switch",
        arguments: "NAME",
        doc: "goes to another run and keeps this one",
        verb: Verb::Switch,
        example: ":switch before",
        more: "",
    },
    CommandEntry {
        name: ":why",
        arguments: "[PATH]",
        doc: "why a task waits, or how it ended: the chain of causes",
        verb: Verb::Why,
        example: ":why main/greet",
        more: "PATH is the path of a task or its end; without one it is the main task.",
    },
    CommandEntry {
        name: ":tasks",
        arguments: "",
        doc: "the tree of tasks, what each waits for, and its valves",
        verb: Verb::Tasks,
        example: ":tasks",
        more: "",
    },
    CommandEntry {
        name: ":task",
        arguments: "[PATH]",
        doc: "one task: its form, its calls, its variables",
        verb: Verb::Task,
        example: ":task main/greet",
        more: "",
    },
    CommandEntry {
        name: ":fluents",
        arguments: "[WORD]",
        doc: "the fluents and their values",
        verb: Verb::Fluents,
        example: ":fluents nav",
        more: "",
    },
    CommandEntry {
        name: ":valves",
        arguments: "",
        doc: "the valves, who holds them and who waits",
        verb: Verb::Valves,
        example: ":valves",
        more: "",
    },
    CommandEntry {
        name: ":map",
        arguments: "",
        doc: "the world, the robot, and where it believes itself to be",
        verb: Verb::Map,
        example: ":map",
        more: "",
    },
    CommandEntry {
        name: ":project",
        arguments: "[:simulated] [FORM]",
        doc: "how a form, or what is under way, would probably go",
        verb: Verb::Project,
        example: ":project (go-to 'library)",
        more: "It tells what follows from what the robot knows now, in 60 runs of at most an hour: in events, or, with `:simulated` before the form, step by step. Nothing is done.",
    },
    CommandEntry {
        name: ":trace",
        arguments: "[WORD...]",
        doc: "the last events, those that hold all the words",
        verb: Verb::Trace,
        example: ":trace navigation gives",
        more: "",
    },
    CommandEntry {
        name: ":doc",
        arguments: "[NAME]",
        doc: "documents a name, your own or one of the library",
        verb: Verb::Doc,
        example: ":doc with-policy",
        more: "",
    },
    CommandEntry {
        name: ":source",
        arguments: "NAME",
        doc: "shows the text of a definition, the library's too",
        verb: Verb::Source,
        example: ":source for-each",
        more: "",
    },
    CommandEntry {
        name: ":edit",
        arguments: "[NAME]",
        doc: "edits the last form or a definition, and runs it",
        verb: Verb::Edit,
        example: ":edit greet",
        more: "The editor is the one that VISUAL or EDITOR names. What it leaves is run if it is another text than before; a text that is wrong is there again at the next `:edit`.",
    },
    CommandEntry {
        name: ":save",
        arguments: "FILE",
        doc: "saves what this session defines as a file that loads",
        verb: Verb::Save,
        example: ":save my-plans.rpl",
        more: "It holds the latest text of each definition, typed or loaded, not the values of variables. A file that is there is not overwritten, unless this session wrote it.",
    },
    CommandEntry {
        name: ":help",
        arguments: "[COMMAND]",
        doc: "this list, or a command with an example",
        verb: Verb::Help,
        example: ":help back",
        more: "",
    },
    CommandEntry {
        name: ":quit",
        arguments: "",
        doc: "ends the session; so does Ctrl-D",
        verb: Verb::Quit,
        example: ":quit",
        more: "",
    },
];

impl CommandEntry {
    fn usage(&self) -> String {
        format!("{} {}", self.name, self.arguments).trim_end().to_string()
    }

    /// What it does, with an example.
    pub fn explanation(&self) -> Vec<String> {
        let mut lines = vec![self.usage(), format!("  {}.", self.doc)];
        if !self.more.is_empty() {
            lines.push(format!("  {}", self.more));
        }
        lines.push(format!("    {}", self.example));
        lines
    }
}

/// The command of a name, with or without its colon.
///
/// # Errors
/// There is no such command; the near one is named.
pub fn find(name: &str) -> Result<&'static CommandEntry, String> {
    let bare = name.strip_prefix(':').unwrap_or(name);
    let named = |entry: &&CommandEntry| &entry.name[1..] == bare;
    COMMANDS.iter().find(named).ok_or_else(|| {
        let known = COMMANDS.iter().map(|entry| entry.name);
        match suggest(&format!(":{bare}"), known) {
            Some(near) => format!("there is no command `:{bare}`; did you mean `{near}`? `:help` lists them"),
            None => format!("there is no command `:{bare}`; `:help` lists them"),
        }
    })
}

/// Characters of a name, a path or a time, at most.
const LONGEST_WORD: usize = 4096;

/// The verb of a line that begins with a colon, and what follows it.
///
/// # Errors
/// There is no such command, and the near one is named; or what follows can be nothing that is
/// meant, and would only disturb the terminal if it were named.
pub fn parse(line: &str) -> Result<(Verb, &str), String> {
    let line = line.trim();
    if let Some(control) = line.chars().find(|c| c.is_control() && !c.is_whitespace()) {
        let code = u32::from(control);
        return Err(format!("the line holds the control character U+{code:04X}, which no name and no form has"));
    }
    if line.split_whitespace().any(|word| word.len() > LONGEST_WORD) {
        return Err(format!("the line holds a word of more than {LONGEST_WORD} characters; `:load` takes long texts"));
    }
    let (name, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    Ok((find(name)?.verb, rest.trim()))
}

/// The list that `:help` shows.
pub fn help() -> Vec<String> {
    let short = |entry: &&CommandEntry| entry.usage().chars().count() <= 18;
    let width = COMMANDS.iter().filter(short).map(|entry| entry.usage().chars().count()).max().unwrap_or(0) + 2;
    let mut lines = Vec::new();
    for entry in COMMANDS {
        if let Some((group, _)) = GROUPS.iter().find(|(_, first)| *first == entry.verb) {
            lines.push((*group).to_string());
        }
        let usage = format!("  {}", entry.usage());
        if usage.chars().count() > width {
            lines.push(usage);
            lines.push(format!("{:width$}  {}", "", entry.doc));
        } else {
            lines.push(format!("{usage:width$}  {}", entry.doc));
        }
    }
    lines.push("Anything else is a form of the language; `_` is the value of the last one.".to_string());
    lines.push("`:help COMMAND` tells more of a command and shows an example.".to_string());
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_command_names_the_near_one() {
        assert_eq!(parse(":back 10s"), Ok((Verb::Back, "10s")));
        assert!(parse(":back \x1b[31m").is_err_and(|error| error.contains("U+001B")));
        assert!(parse(&format!(":{}", "x".repeat(5000))).is_err_and(|error| error.len() < 200));
        let error = parse(":contineu").expect_err("there is no such command");
        assert!(error.contains("did you mean `:continue`?"), "{error}");
    }

    #[test]
    fn every_command_is_explained_with_an_example_that_is_one() {
        for entry in COMMANDS {
            let lines = entry.explanation();
            assert_eq!(parse(entry.example).map(|(verb, _)| verb), Ok(entry.verb), "{lines:?}");
            assert_eq!(find(&entry.name[1..]), Ok(entry));
        }
    }

    #[test]
    fn the_page_has_a_row_for_every_command() {
        let page = include_str!("../../docs/prompt.md");
        for entry in COMMANDS {
            let row = format!("| `{}` | {} |", entry.usage().replace('|', "\\|"), entry.doc);
            assert!(page.contains(&row), "docs/prompt.md lacks\n{row}");
        }
    }

    #[test]
    fn the_help_fits_a_narrow_terminal() {
        for line in help() {
            assert!(line.chars().count() < 80, "{line}");
        }
    }
}
