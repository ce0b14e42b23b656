//! What is known of a text that was looked at as a whole: the findings of `rpl check`, and what each name means.

use crate::surroundings::Setting;
use rpl_lang::bars::read_name;
use rpl_lang::code::{CodeKind, GlobalKind};
use rpl_lang::compile::{DefinedKind, Loader};
use rpl_lang::occurrences::{Occurrence, Target, occurrences};
use rpl_lang::source::{SourceId, Span};
use rpl_lang::symbol::{Qualifier, base_name};
use rpl_mission::reference::{NameKind, signature};
use rpl_runtime::run::library::Examined;
use std::cell::OnceCell;
use std::sync::Arc;

/// What a plan that names the robot is told by a library without one.
const NEEDS_A_WORLD: &str = "needs-a-world";

/// A text, looked at.
pub struct Analysis {
    /// What it was looked at with.
    pub setting: Arc<Setting>,
    /// Which of the libraries had all it names, or the last.
    pub library: usize,
    /// Findings, code and names.
    pub examined: Examined,
    occurrences: OnceCell<Vec<Occurrence>>,
}

/// What is said of a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Description {
    /// What it is.
    pub word: &'static str,
    /// How it is written; empty for what is only a name.
    pub signature: String,
    /// Its documentation.
    pub doc: String,
    /// Plan text that shows it, or nothing.
    pub example: &'static str,
}

impl Analysis {
    /// Looks at a text with the first library, from a number on, that has all it names. Cost: as for `rpl check`.
    pub fn of(setting: Arc<Setting>, first: usize, name: &str, text: &str, loader: &mut dyn Loader) -> Self {
        let last = setting.libraries.len() - 1;
        let places = setting.world.clone();
        let mut library = first.min(last);
        loop {
            let examined = setting.libraries[library].examine(name, text, places.as_ref(), loader);
            let lacks = examined.diagnostics.iter().any(|found| found.code == NEEDS_A_WORLD);
            if library == last || !lacks {
                return Self { setting, library, examined, occurrences: OnceCell::new() };
            }
            library += 1;
        }
    }

    /// The text and those it loads, by their numbers in the program.
    pub fn sources(&self) -> impl Iterator<Item = SourceId> + use<> {
        let program = &self.examined.program;
        (program.library_sources..program.sources.len() as u32).map(SourceId)
    }

    /// Where names stand in all these texts, in order.
    pub fn occurrences(&self) -> &[Occurrence] {
        self.occurrences.get_or_init(|| {
            let Examined { program, symbols, resolved, .. } = &self.examined;
            self.sources().flat_map(|source| occurrences(source, program, symbols, resolved)).collect()
        })
    }

    /// The occurrence that a byte of the text itself lies in or ends.
    pub fn at(&self, byte: usize) -> Option<&Occurrence> {
        let source = self.examined.source;
        let all = self.occurrences();
        let after = all.partition_point(|one| (one.whole.source, one.whole.start as usize) <= (source, byte));
        let found = all.get(after.checked_sub(1)?)?;
        (found.whole.source == source && byte <= found.whole.end as usize).then_some(found)
    }

    /// All occurrences with a target.
    pub fn of_target(&self, target: Target) -> impl Iterator<Item = &Occurrence> {
        self.occurrences().iter().filter(move |occurrence| occurrence.target == target)
    }

    /// Where a target is defined or bound, if that is in one of the texts.
    pub fn definition(&self, target: Target) -> Option<Span> {
        let binding = self.of_target(target).find(|occurrence| occurrence.is_binding).map(|binding| binding.span);
        let whole = || match target {
            Target::Local(number) => self.examined.resolved.variable(number).map(|(_, span)| span),
            Target::Global(number) => self.examined.program.globals[number as usize].span,
            Target::Macro(_) | Target::Failure(_) => None,
        };
        binding.or_else(whole).filter(|span| span.source.0 >= self.examined.program.library_sources)
    }

    /// The definition of a name in a text of the library, whole; a native function has none.
    pub fn library_definition(&self, name: &str) -> Option<Span> {
        let (program, symbols) = self.setting.libraries[self.library].names();
        let symbol = symbols.find(name)?;
        match program.macros.get(&symbol) {
            Some(&code) => Some(program.codes[code as usize].span),
            None => program.globals[*program.names.get(&symbol)? as usize].span,
        }
    }

    /// What the text itself defines, each with its whole form.
    pub fn defined(&self) -> impl Iterator<Item = (&str, Span, DefinedKind)> {
        let Examined { symbols, resolved, .. } = &self.examined;
        resolved.defined().map(|(name, span, kind)| (symbols.name(name), span, kind))
    }

    /// What kind of global a name of the text is.
    pub fn global(&self, name: &str) -> Option<&GlobalKind> {
        let Examined { program, symbols, .. } = &self.examined;
        let number = program.names.get(&symbols.find(name)?)?;
        Some(&program.globals[*number as usize].kind)
    }

    /// What is said of a name, as it is written, that the texts or the language define.
    pub fn describe(&self, name: &str) -> Option<Description> {
        let name = read_name(name);
        let qualifier = Qualifier::split(&name).map(|(qualifier, _)| qualifier);
        let name = base_name(&name);
        let own = || self.own(name).filter(|_| qualifier != Some(Qualifier::Library));
        own().or_else(|| {
            let entry = self.setting.reference.find(name).filter(|entry| entry.kind != NameKind::Command)?;
            let (signature, doc) = (entry.signature.clone(), entry.doc.clone());
            Some(Description { word: entry.kind.word(), signature, doc, example: entry.example })
        })
    }

    /// What is said of a name of the texts themselves.
    fn own(&self, name: &str) -> Option<Description> {
        let Examined { program, symbols, .. } = &self.examined;
        let symbol = symbols.find(name)?;
        let described = |word: NameKind, signature: String, doc: Option<&str>| {
            let doc = doc.unwrap_or("It has no documentation.").to_string();
            Some(Description { word: word.word(), signature, doc, example: "" })
        };
        let is_own = |span: Span| span.source.0 >= program.library_sources;
        if let Some(&code) = program.macros.get(&symbol) {
            let code = program.codes.get(code as usize).filter(|code| is_own(code.span))?;
            return described(NameKind::Macro, signature(name, code, program), code.doc.as_deref());
        }
        if let Some(&number) = program.names.get(&symbol) {
            let global = program.globals.get(number as usize).filter(|global| global.span.is_some_and(is_own))?;
            let (kind, signature) = match global.kind {
                GlobalKind::Function(code) => {
                    let code = program.codes.get(code as usize)?;
                    let kind = if code.kind == CodeKind::Plan { NameKind::Plan } else { NameKind::Function };
                    (kind, signature(name, code, program))
                }
                GlobalKind::Variable | GlobalKind::Constant => (NameKind::Variable, name.to_string()),
                GlobalKind::Fluent => (NameKind::Fluent, name.to_string()),
                GlobalKind::Valve { .. } => (NameKind::Valve, format!("(with-valve {name} FORM...)")),
                GlobalKind::Behaviour(_) => return None,
            };
            return described(kind, signature, global.doc.as_deref());
        }
        let is_class = self.defined().any(|(other, _, kind)| other == name && kind == DefinedKind::Failure);
        let class = program.failure_classes.get(&symbol).filter(|_| is_class)?;
        let parent = class.parent.map_or(String::new(), |parent| format!(" below {}", symbols.name(parent)));
        let slots: Vec<&str> = class.slots.iter().map(|&slot| symbols.name(slot)).collect();
        let with = if slots.is_empty() { String::new() } else { format!(", with {}", slots.join(", ")) };
        described(NameKind::FailureClass, format!("{name}{parent}{with}"), None)
    }
}
