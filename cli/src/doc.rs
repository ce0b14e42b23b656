//! `rpl doc [NAME]`: documentation from the tables the compiler works with.

use crate::console::Console;
use crate::mission::{self, Site};
use crate::special_forms::SPECIAL_FORMS;
use crate::status::Status;
use anyhow::{Result, bail};
use rpl_lang::code::{CodeKind, GlobalKind, Program};
use rpl_lang::compile::NoFiles;
use rpl_lang::reader::fold_name;
use rpl_lang::suggest::suggest;
use rpl_lang::symbol::Symbols;
use rpl_robot::office::{BEHAVIOURS, FLUENTS};

/// What is known of a name.
struct Entry {
    name: String,
    /// How it is written in a call, or what it is.
    form: String,
    doc: String,
    group: Group,
}

/// Chapters of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Group {
    SpecialForm,
    Macro,
    Plan,
    Function,
    Other,
}

impl Group {
    fn title(self) -> &'static str {
        match self {
            Group::SpecialForm => "Special forms",
            Group::Macro => "Macros",
            Group::Plan => "Plans",
            Group::Function => "Functions",
            Group::Other => "Fluents, valves, behaviours, variables",
        }
    }
}

/// Documents a name, lists all names, or documents the robot's behaviours.
///
/// # Errors
/// Nothing has the name.
pub fn run(name: Option<&str>, console: &mut Console) -> Result<Status> {
    match name {
        None => list(&entries()?, console)?,
        Some("behaviours") => behaviours(console)?,
        Some(name) => one(&entries()?, name, console)?,
    }
    Ok(Status::Succeeded)
}

fn one(entries: &[Entry], name: &str, console: &mut Console) -> Result<()> {
    let name = fold_name(name);
    let mut found = entries.iter().filter(|entry| entry.name == name).peekable();
    if found.peek().is_none() {
        match suggest(&name, entries.iter().map(|entry| entry.name.as_str())) {
            Some(meant) => bail!("nothing is called `{name}`; did you mean `{meant}`?"),
            None => bail!("nothing is called `{name}`; `rpl doc` lists what there is"),
        }
    }
    for entry in found {
        console.print(&format!("{}\n  {}", entry.form, entry.doc.replace('\n', "\n  ")))?;
    }
    Ok(())
}

fn list(entries: &[Entry], console: &mut Console) -> Result<()> {
    let mut group = None;
    for entry in entries {
        if group != Some(entry.group) {
            let gap = if group.is_some() { "\n" } else { "" };
            console.print(&format!("{gap}{}", entry.group.title()))?;
            group = Some(entry.group);
        }
        console.print(&format!("  {:22} {}", entry.name, first_sentence(&entry.doc)))?;
    }
    Ok(())
}

fn first_sentence(doc: &str) -> &str {
    doc.lines().next().and_then(|line| line.split_inclusive(". ").next()).unwrap_or_default().trim_end()
}

fn behaviours(console: &mut Console) -> Result<()> {
    for behaviour in BEHAVIOURS {
        let valve = behaviour.valve.map_or(String::new(), |valve| format!("\n  Drives with the valve `{valve}`."));
        let call = format!("activate {} {}", behaviour.name, behaviour.parameters);
        console.print(&format!("({})\n  {}{valve}", call.trim_end(), behaviour.doc))?;
    }
    console.print("")?;
    for fluent in FLUENTS {
        console.print(&format!("{:20} {}", fluent.name, fluent.doc))?;
    }
    Ok(())
}

/// Everything that has a name, chapter by chapter, each in alphabetical order.
fn entries() -> Result<Vec<Entry>> {
    let mut entries = Vec::new();
    for special in SPECIAL_FORMS {
        entries.extend(special.names.iter().map(|name| Entry {
            name: name.to_string(),
            form: special.form.to_string(),
            doc: special.doc.to_string(),
            group: Group::SpecialForm,
        }));
    }
    for native in mission::natives() {
        let form = call_form(native.name, native.parameters);
        entries.push(Entry {
            name: native.name.to_string(),
            form,
            doc: native.doc.to_string(),
            group: Group::Function,
        });
    }
    // A text without forms compiles to nothing but the library.
    let library = Site::for_checking()?.library;
    if let Ok(loaded) = library.load("", "", &mut NoFiles) {
        add_library(&loaded.program, &loaded.symbols, &mut entries);
    }
    entries.retain(|entry| !entry.name.starts_with('%'));
    entries.sort_by(|a, b| (a.group, &a.name).cmp(&(b.group, &b.name)));
    Ok(entries)
}

fn add_library(program: &Program, symbols: &Symbols, entries: &mut Vec<Entry>) {
    for (&name, &code) in &program.macros {
        let name = symbols.name(name).to_string();
        let code = &program.codes[code as usize];
        let doc = code.doc.as_deref().unwrap_or_default().to_string();
        entries.push(Entry { form: call_form(&name, &parameters(code, symbols)), name, doc, group: Group::Macro });
    }
    for (&name, &global) in &program.names {
        let known = &program.globals[global as usize];
        let name = symbols.name(name).to_string();
        let doc = known.doc.as_deref().unwrap_or_default().to_string();
        let (form, group) = match known.kind {
            GlobalKind::Function(code) => {
                let Some(code) = program.codes.get(code as usize) else { continue };
                let group = if code.kind == CodeKind::Plan { Group::Plan } else { Group::Function };
                (call_form(&name, &parameters(code, symbols)), group)
            }
            GlobalKind::Variable => (format!("{name} (a variable)"), Group::Other),
            GlobalKind::Constant => (format!("{name} (a constant)"), Group::Other),
            GlobalKind::Fluent => (format!("{name} (a fluent)"), Group::Other),
            GlobalKind::Valve => (format!("{name} (a valve)"), Group::Other),
            GlobalKind::Behaviour(_) => (format!("{name} (a behaviour)"), Group::Other),
        };
        entries.push(Entry { name, form, doc, group });
    }
}

fn call_form(name: &str, parameters: &str) -> String {
    if parameters.is_empty() { format!("({name})") } else { format!("({name} {parameters})") }
}

/// Compiled code keeps only the names of keyword parameters; the others are counted.
fn parameters(code: &rpl_lang::code::Code, symbols: &Symbols) -> String {
    let known = &code.parameters;
    let mut parts: Vec<String> = (1..=known.required).map(|number| format!("arg{number}")).collect();
    parts.extend((1..=known.optional).map(|number| format!("[opt{number}]")));
    if known.rest {
        parts.push("rest...".to_string());
    }
    parts.extend(known.keys.iter().map(|&key| format!("[:{} V]", symbols.name(key))));
    parts.join(" ")
}
