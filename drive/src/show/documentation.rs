//! What is documented of a name, a topic, or everything that mentions a word.

use anyhow::{Result, bail};
use rpl_mission::reference::{Entry, Reference, TOPICS, Topic};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;

/// Columns of the names in a list.
const NAME_COLUMNS: usize = 26;

/// The reference with an entry for each subcommand of this command line.
pub fn with_commands(reference: Reference, command_line: &clap::Command) -> Reference {
    command_line.get_subcommands().fold(reference, |reference, command| {
        let name = format!("rpl {}", command.get_name());
        let usage = command.clone().bin_name(&name).render_usage().to_string();
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        let signature = usage.trim_start_matches("Usage: ").to_string();
        reference.with_command(&name, signature, format!("{about}. `{name} --help` tells more."))
    })
}

/// Documents a name or a topic, searches for a word, or lists all names.
///
/// # Errors
/// Nothing has the name, and nothing mentions it.
pub fn document(reference: &Reference, name: Option<&str>, console: &mut Console) -> Result<Status> {
    let Some(name) = name else {
        for (at, topic) in TOPICS.iter().enumerate() {
            list_topic(reference, topic, at > 0, console)?;
        }
        return Ok(Status::Succeeded);
    };
    if let Some(entry) = reference.find(name) {
        console.explain(&entry.signature)?;
        console.explain_hanging(&explanation(entry), 0)?;
    } else if let Some(topic) = TOPICS.iter().find(|topic| topic.word == name) {
        list_topic(reference, topic, false, console)?;
    } else {
        search(reference, name, console)?;
    }
    Ok(Status::Succeeded)
}

/// Documentation, an example, and what it is.
fn explanation(entry: &Entry) -> String {
    let topic = TOPICS.iter().find(|topic| topic.names().any(|name| name == entry.name));
    let mut text = format!("  {}\n", entry.doc.replace('\n', "\n  "));
    if !entry.example.is_empty() {
        text += &format!("\n    {}\n", entry.example.replace('\n', "\n    "));
    }
    let more = topic.map_or(String::new(), |topic| format!("; more of the kind: rpl doc {}", topic.word));
    text += &format!("\n  a {}{more}", entry.kind.word());
    text
}

fn list_topic(reference: &Reference, topic: &Topic, gap: bool, console: &mut Console) -> Result<()> {
    let gap = if gap { "\n" } else { "" };
    console.explain(&format!("{gap}{}  (rpl doc {})", topic.title, topic.word))?;
    list(&reference.of_topic(topic), console)
}

fn list(entries: &[&Entry], console: &mut Console) -> Result<()> {
    for entry in entries {
        console.explain_hanging(&format!("  {:NAME_COLUMNS$} {}", entry.name, entry.summary()), NAME_COLUMNS + 1)?;
    }
    Ok(())
}

fn search(reference: &Reference, word: &str, console: &mut Console) -> Result<()> {
    let meant = reference.suggest(word).map_or(String::new(), |meant| format!("; did you mean `{meant}`?"));
    let stop = if meant.is_empty() { "." } else { "" };
    let found = reference.search(word);
    if found.is_empty() {
        let advice = if meant.is_empty() { "; `rpl doc` lists what there is" } else { &meant };
        bail!("nothing is called `{word}`{advice}");
    }
    console.explain(&format!("Nothing is called `{word}`{meant}{stop} It is mentioned by"))?;
    list(&found, console)
}
