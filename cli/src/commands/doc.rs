//! `rpl doc [NAME]`: documentation of a name, a topic, or everything that mentions a word.
//!
//! It documents the commands too, and so knows the command line that it is a part of: that circle is in
//! the matter.

use super::CommandLine;
use anyhow::Result;
use clap::CommandFactory;
use clap_complete::engine::ArgValueCompleter;
use rpl_drive::show::documentation::{document, with_commands};
use rpl_mission::reference::{Reference, TOPICS};
use rpl_shell::arguments::completion::{Offers, beginning_with};
use rpl_shell::pager;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::ffi::OsStr;

/// Show the documentation of a name or a topic, search for a word, or list all names
///
/// At a terminal the output goes through a pager: `RPL_PAGER`, else `PAGER`, else `less -FRX`. An empty value turns
/// paging off.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Name in the language, the library or the robot, a command, a topic such as `behaviours`, or a word to
    /// search for (default: list all names)
    #[arg(value_name = "NAME", add = ArgValueCompleter::new(documented))]
    name: Option<String>,
}

/// Documents, at a terminal through a pager.
///
/// # Errors
/// Nothing has the name, and nothing mentions it.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let reference = with_commands(Reference::new()?, &CommandLine::command());
    pager::paged(console, |console| document(&reference, arguments.name.as_deref(), console))
}

/// Whatever `rpl doc` documents.
fn documented(typed: &OsStr) -> Offers {
    let topics = TOPICS.iter().map(|topic| (topic.word, topic.title));
    // Without the library there is nothing to complete.
    let Ok(reference) = Reference::new() else { return beginning_with(typed, topics) };
    let reference = with_commands(reference, &CommandLine::command());
    let commands = reference.entries().filter_map(|entry| Some((entry.name.strip_prefix("rpl ")?, entry.summary())));
    let names = reference.names().map(|entry| (entry.name.as_str(), entry.summary()));
    beginning_with(typed, topics.chain(commands).chain(names))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_lang::compile::NoFiles;
    use rpl_mission::modules;
    use rpl_mission::reference::{Entry, NameKind};
    use rpl_mission::site::Site;
    use std::collections::BTreeMap;

    fn reference() -> Reference {
        with_commands(Reference::new().expect("the library compiles"), &CommandLine::command())
    }

    #[test]
    fn no_name_is_without_signature_and_documentation() {
        let reference = reference();
        assert!(reference.entries().count() > 300);
        for entry in reference.entries() {
            assert!(entry.signature.contains(entry.name.as_str()) || entry.kind == NameKind::SpecialForm, "{entry:?}");
            assert!(!entry.signature.is_empty() && entry.doc.len() > 10, "{entry:?}");
            let ends = entry.doc.ends_with(['.', '`']);
            assert!(ends && entry.doc.starts_with(|c: char| !c.is_lowercase()), "{entry:?}");
        }
    }

    #[test]
    fn everything_a_robot_offers_has_its_entry() {
        let reference = reference();
        let missing: Vec<&str> = modules::tables().names().filter(|name| reference.find(name).is_none()).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }

    #[test]
    fn every_name_stands_under_one_topic() {
        let reference = reference();
        let mut counts: BTreeMap<&str, usize> = reference.entries().map(|entry| (entry.name.as_str(), 0)).collect();
        for topic in TOPICS {
            assert!(reference.find(topic.word).is_none(), "`{}` means two things", topic.word);
            for name in topic.names() {
                assert!(reference.find(name).is_some(), "the topic {} names `{name}`, which is nothing", topic.word);
            }
            for entry in reference.of_topic(topic) {
                *counts.entry(entry.name.as_str()).or_default() += 1;
            }
        }
        let wrong: Vec<_> = counts.into_iter().filter(|&(_, count)| count != 1).collect();
        assert!(wrong.is_empty(), "{wrong:?}");
    }

    #[test]
    fn every_example_is_formatted_and_compiles() {
        let site = Site::for_checking(Vec::new()).expect("the library compiles");
        let reference = reference();
        let entries: Vec<&Entry> = reference.entries().filter(|entry| !entry.example.is_empty()).collect();
        assert!(entries.len() > 15);
        for entry in entries {
            if let Err(rejected) = site.library.load(&entry.name, entry.example, &mut NoFiles) {
                panic!("{}", rejected.render(false));
            }
            let source = rpl_lang::source::SourceId(0);
            let formatted = rpl_lang::formatter::format(entry.example, source).expect("it has no faults");
            assert_eq!(formatted.trim_end(), entry.example);
        }
    }
}
