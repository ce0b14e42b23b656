//! Everything that has a name, in one table: for `rpl doc`, and for whatever completes or explains
//! names. It is put together from the tables the compiler, the library and the robot work with.
//!
//! The command documents from it, the prompt and the editor complete from it, and the grammar of editors is made of it.
//! It stands here because only this crate knows all libraries, and because the command and the editor both import this
//! crate.

mod topics;

use crate::error::SiteError;
use crate::modules;
use crate::site::Site;
use rpl_lang::code::{Code, CodeKind, GlobalKind, Program};
use rpl_lang::compile::special_forms;
use rpl_lang::reader::read;
use rpl_lang::source::Span;
use rpl_lang::suggest::suggest;
use rpl_lang::symbol::Symbols;
use rpl_lang::symbol::fold_name;
use rpl_lang::syntax::Tree;
use rpl_runtime::run::library::Library;
use rpl_runtime::state::failure::CLASSES;
use std::collections::BTreeMap;
pub use topics::{TOPICS, Topic};

/// What is known of a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The name; that of a command begins with `rpl`.
    pub name: String,
    /// What it is.
    pub kind: NameKind,
    /// How it is written.
    pub signature: String,
    /// What it means; the first sentence says it in short.
    pub doc: String,
    /// Plan text that shows it, or nothing.
    pub example: &'static str,
}

/// What has a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NameKind {
    /// A form the compiler itself understands.
    SpecialForm,
    /// A form that is written out as another.
    Macro,
    /// A function.
    Function,
    /// A plan of the library.
    Plan,
    /// A fluent.
    Fluent,
    /// A behaviour.
    Behaviour,
    /// A valve.
    Valve,
    /// A class of failures.
    FailureClass,
    /// A variable or constant.
    Variable,
    /// A command of `rpl`.
    Command,
}

impl NameKind {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            NameKind::SpecialForm => "special form",
            NameKind::Macro => "macro",
            NameKind::Function => "function",
            NameKind::Plan => "plan",
            NameKind::Fluent => "fluent",
            NameKind::Behaviour => "behaviour",
            NameKind::Valve => "valve",
            NameKind::FailureClass => "class of failures",
            NameKind::Variable => "variable",
            NameKind::Command => "command",
        }
    }
}

impl Entry {
    /// The first sentence of its documentation.
    pub fn summary(&self) -> &str {
        let line = self.doc.lines().next().unwrap_or_default();
        line.split_inclusive(". ").next().unwrap_or_default().trim_end()
    }

    /// Whether a word of its name or documentation begins with this one.
    fn mentions(&self, word: &str) -> bool {
        [self.name.as_str(), self.doc.as_str()].iter().any(|text| has_word(text, word))
    }
}

fn has_word(text: &str, beginning: &str) -> bool {
    text.to_lowercase().split(|c: char| !c.is_alphanumeric()).any(|word| word.starts_with(beginning))
}

/// All entries by name.
pub struct Reference {
    entries: BTreeMap<String, Entry>,
}

impl Reference {
    /// Puts the table together, without commands.
    ///
    /// # Errors
    /// The library does not compile.
    pub fn new() -> Result<Self, SiteError> {
        Ok(Self::of(&Site::for_checking(Vec::new())?.library))
    }

    /// The same over a library that has been compiled.
    pub fn of(library: &Library) -> Self {
        let mut reference = Self { entries: BTreeMap::new() };
        reference.add_library(library);
        for native in crate::libraries::natives() {
            let signature = call(native.name, native.parameters);
            reference.add(native.name, NameKind::Function, signature, native.doc.to_string(), "");
        }
        for form in special_forms() {
            for name in form.names {
                reference.add(name, NameKind::SpecialForm, form.form.to_string(), form.doc.to_string(), form.example);
            }
        }
        for behaviour in &modules::tables().behaviours {
            let valve =
                behaviour.valve.as_deref().map_or(String::new(), |valve| format!(" Drives with the valve `{valve}`."));
            let signature = call("activate", format!("{} {}", behaviour.name, behaviour.parameters).trim_end());
            reference.add(&behaviour.name, NameKind::Behaviour, signature, format!("{}{valve}", behaviour.doc), "");
        }
        for (name, parent, slots, doc) in CLASSES {
            let below = if parent.is_empty() { String::new() } else { format!(" below {parent}") };
            let slots = if slots.is_empty() { String::new() } else { format!(", with {}", slots.join(", ")) };
            reference.add(name, NameKind::FailureClass, format!("{name}{below}{slots}"), doc.to_string(), "");
        }
        reference
    }

    /// With an entry for a command of `rpl`, whose name begins with `rpl`.
    #[must_use]
    pub fn with_command(mut self, name: &str, signature: String, doc: String) -> Self {
        self.add(name, NameKind::Command, signature, doc, "");
        self
    }

    /// The entry of a name, or of a command's name without `rpl`.
    pub fn find(&self, name: &str) -> Option<&Entry> {
        let name = fold_name(name);
        self.entries.get(name.as_ref()).or_else(|| self.entries.get(&format!("rpl {name}")))
    }

    /// All entries, by name.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.entries.values()
    }

    /// All names that can stand in a plan.
    pub fn names(&self) -> impl Iterator<Item = &Entry> {
        self.entries.values().filter(|entry| entry.kind != NameKind::Command)
    }

    /// The entries of a topic, in the order of reading.
    pub fn of_topic(&self, topic: &Topic) -> Vec<&Entry> {
        let kind = match topic.word {
            topics::COMMANDS => Some(NameKind::Command),
            topics::FAILURE_CLASSES => Some(NameKind::FailureClass),
            _ => None,
        };
        match kind {
            Some(kind) => self.entries.values().filter(|entry| entry.kind == kind).collect(),
            None => topic.names().filter_map(|name| self.entries.get(name)).collect(),
        }
    }

    /// The entries that mention a word, or the beginning of one; those with it in their name first.
    pub fn search(&self, word: &str) -> Vec<&Entry> {
        let word = word.to_lowercase();
        let mut found: Vec<&Entry> = self.entries.values().filter(|entry| entry.mentions(&word)).collect();
        found.sort_by_key(|entry| !has_word(&entry.name, &word));
        found
    }

    /// The name nearest to a mistyped one.
    pub fn suggest(&self, name: &str) -> Option<&str> {
        let topics = TOPICS.iter().map(|topic| topic.word);
        suggest(&fold_name(name), self.entries.keys().map(String::as_str).chain(topics))
    }

    /// Adds a name unless it is internal to the library.
    fn add(&mut self, name: &str, kind: NameKind, signature: String, doc: String, example: &'static str) {
        if name.starts_with('%') {
            return;
        }
        let entry = Entry { name: name.to_string(), kind, signature, doc, example };
        self.entries.insert(entry.name.clone(), entry);
    }

    fn add_library(&mut self, library: &Library) {
        let (program, symbols) = library.names();
        for (&name, &code) in &program.macros {
            let name = symbols.name(name);
            let code = &program.codes[code as usize];
            let doc = code.doc.as_deref().unwrap_or_default();
            let (signature, doc) = match written_signature(doc) {
                Some((signature, doc)) => (signature.to_string(), capitalized(doc)),
                None => (signature(name, code, program), doc.to_string()),
            };
            self.add(name, NameKind::Macro, signature, doc, "");
        }
        for (&name, &global) in &program.names {
            let known = &program.globals[global as usize];
            let name = symbols.name(name);
            let (kind, signature) = match known.kind {
                GlobalKind::Function(code) => {
                    let Some(code) = program.codes.get(code as usize) else { continue };
                    let kind = if code.kind == CodeKind::Plan { NameKind::Plan } else { NameKind::Function };
                    (kind, signature(name, code, program))
                }
                GlobalKind::Variable | GlobalKind::Constant => (NameKind::Variable, name.to_string()),
                GlobalKind::Fluent => (NameKind::Fluent, name.to_string()),
                GlobalKind::Valve { .. } => (NameKind::Valve, call("with-valve", &format!("{name} FORM..."))),
                GlobalKind::Behaviour(_) => continue,
            };
            self.add(name, kind, signature, known.doc.as_deref().unwrap_or_default().to_string(), "");
        }
    }
}

/// The form a macro's documentation begins with, if it does: its parameters say less.
fn written_signature(doc: &str) -> Option<(&str, &str)> {
    doc.strip_prefix('`')?.split_once("`: ")
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// How a function or plan of a program is called.
pub fn signature(name: &str, code: &Code, program: &Program) -> String {
    call(name, &parameters(code, program))
}

fn call(name: &str, parameters: &str) -> String {
    if parameters.is_empty() { format!("({name})") } else { format!("({name} {parameters})") }
}

/// What stands at a place of a text that is read by itself.
fn text_at(text: &str, span: Span) -> &str {
    text.get(span.start as usize..span.end as usize).unwrap_or_default()
}

/// The parameters as the definition writes them: compiled code keeps only their number.
fn parameters(code: &Code, program: &Program) -> String {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let text = program.sources.text_of(code.span);
    let (roots, _) = read(text, code.span.source, &mut symbols, &mut tree);
    let items = roots.first().map_or(&[][..], |&root| tree.items(root));
    let Some(&list) = items.get(2) else { return String::new() };
    tree.items(list).iter().map(|&item| text_at(text, tree.span(item))).collect::<Vec<_>>().join(" ")
}
