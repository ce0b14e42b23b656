//! `:doc` and `:help`: what the session defines, what is built in, and the prompt's own commands.

use super::guard::is_output_gone;
use super::listings::{fluent_value, value_text};
use super::{Prompt, command, definitions};
use anyhow::Result;
use rpl_drive::show::documentation::{document, with_commands};
use rpl_drive::show::why::shortened;
use rpl_drive::stopping::own_text::is_hidden;
use rpl_lang::bars::read_name;
use rpl_lang::code::{CodeKind, GlobalKind, Program};
use rpl_lang::source::Span;
use rpl_lang::suggest::suggest;
use rpl_mission::reference::{self, NameKind, Reference};
use rpl_mission::robot::Robot;
use rpl_runtime::robot::Outside;
use rpl_runtime::run::system::System;

impl Prompt<'_> {
    pub(super) fn document(&mut self, name: &str) -> Result<()> {
        if name.starts_with(':') {
            return self.help(name);
        }
        if let Some(lines) = own(&self.session.branch.system, name) {
            return self.explain(&lines);
        }
        let reference = self.reference()?;
        if reference.find(name).is_none()
            && let Some(lines) = of_module(&self.session.branch.system, name)
        {
            return self.explain(&lines);
        }
        match document(&reference, Some(name).filter(|name| !name.is_empty()), self.console) {
            Err(error) if !is_output_gone(&error) => self.wrong(&self.unknown(name)),
            done => done.map(drop),
        }
    }

    /// All that has a name, the commands included.
    pub(super) fn reference(&self) -> Result<Reference> {
        Ok(with_commands(Reference::new()?, &self.command_line))
    }

    /// What is said of a name that nothing has.
    pub(super) fn unknown(&self, name: &str) -> String {
        let system = &self.session.branch.system;
        let known = [definitions::own(system), definitions::of_library(system)].concat();
        let meant = suggest(&read_name(name), known.iter().map(|definition| definition.name.as_str()));
        let name = shortened(name);
        match meant {
            Some(meant) => format!("nothing is called `{name}`; did you mean `{meant}`?"),
            None => format!("nothing is called `{name}`; `:doc` lists what there is"),
        }
    }

    /// All commands, or one with an example.
    pub(super) fn help(&mut self, name: &str) -> Result<()> {
        if name.is_empty() {
            return self.explain(&command::help());
        }
        match command::find(name) {
            Ok(entry) => self.explain(&entry.explanation()),
            Err(reason) => self.wrong(&reason),
        }
    }
}

/// How something is called, what its documentation says, and where it is defined; none if the
/// session does not define it.
fn own(system: &System<Robot>, name: &str) -> Option<Vec<String>> {
    let program = &*system.program;
    let name = read_name(name);
    let written = definitions::own(system).into_iter().rev().find(|own| own.name == name);
    let known = KnownName::of(system, &name).filter(|known| known.span.source.0 >= program.library_sources);
    let (signature, doc, kind, span, value) = match (known, written) {
        (Some(known), _) => (known.signature, known.doc, known.kind, known.span, known.value),
        (None, Some(written)) => (written.name.clone(), None, kind_of(&written.form), written.span, None),
        (None, None) => return None,
    };
    let doc = doc.unwrap_or_else(|| "It has no documentation.".to_string());
    let place = match is_hidden(system, span) {
        true => "kept by the prompt".to_string(),
        false => format!("defined at {}", program.sources.place(span)),
    };
    let value = value.map_or(String::new(), |value| format!("; its value is {value}"));
    Some(vec![signature, format!("  {}", doc.replace('\n', "\n  ")), format!("  a {kind}, {place}{value}")])
}

/// The same of what a module adds to the robot: plans, behaviours, fluents, valves.
fn of_module(system: &System<Robot>, name: &str) -> Option<Vec<String>> {
    let name = read_name(name);
    let tables = system.outside.tables();
    let behaviour = || {
        let spec = tables.behaviours.iter().find(|spec| spec.name == name)?;
        let signature = format!("(run-behaviour {name} {})", spec.parameters);
        let valve =
            spec.valve.as_ref().map_or(String::new(), |valve| format!(", which drives with the valve `{valve}`"));
        Some((signature, spec.doc.to_string(), format!("a behaviour of a module{valve}")))
    };
    let fluent = || {
        let spec = tables.fluents.iter().find(|spec| spec.name == name)?;
        Some((name.to_string(), spec.doc.to_string(), "a fluent of a module".to_string()))
    };
    let plan = || {
        let known = KnownName::of(system, &name)?;
        let doc = known.doc.unwrap_or_else(|| "It has no documentation.".to_string());
        Some((known.signature, doc, format!("a {} of a module", known.kind)))
    };
    let (signature, doc, kind) = behaviour().or_else(fluent).or_else(plan)?;
    Some(vec![signature, format!("  {}", doc.replace('\n', "\n  ")), format!("  {kind}")])
}

/// What a form defines whose names the compiler keeps in tables of their own.
fn kind_of(form: &str) -> &'static str {
    match form {
        "def-failure" => NameKind::FailureClass.word(),
        "deftest" => "test",
        "def-goal" => "goal",
        "defstruct" => "structure",
        _ => "definition",
    }
}

/// What the compiler and the run know of a name.
struct KnownName {
    kind: &'static str,
    signature: String,
    doc: Option<String>,
    span: Span,
    value: Option<String>,
}

impl KnownName {
    fn of(system: &System<Robot>, name: &str) -> Option<Self> {
        let (program, machine) = (&*system.program, &system.machine);
        let symbol = machine.symbols.find(name)?;
        if let Some(&code) = program.macros.get(&symbol) {
            return Self::code(program, name, code, NameKind::Macro);
        }
        let &number = program.names.get(&symbol)?;
        let global = program.globals.get(number as usize)?;
        let value = || machine.globals.get(number as usize).map(|&value| value_text(system, value));
        let (kind, value) = match global.kind {
            GlobalKind::Function(code) => {
                let is_plan = program.codes.get(code as usize).is_some_and(|code| code.kind == CodeKind::Plan);
                return Self::code(program, name, code, if is_plan { NameKind::Plan } else { NameKind::Function });
            }
            GlobalKind::Variable => (NameKind::Variable.word(), value()),
            GlobalKind::Constant => ("constant", value()),
            GlobalKind::Fluent => (NameKind::Fluent.word(), fluent_value(system, number)),
            GlobalKind::Valve { .. } => (NameKind::Valve.word(), None),
            GlobalKind::Behaviour(_) => (NameKind::Behaviour.word(), None),
        };
        let doc = global.doc.as_deref().map(str::to_string);
        Some(Self { kind, signature: name.to_string(), doc, span: global.span?, value })
    }

    fn code(program: &Program, name: &str, code: u32, kind: NameKind) -> Option<Self> {
        let code = program.codes.get(code as usize)?;
        let signature = reference::signature(name, code, program);
        let doc = code.doc.as_deref().map(str::to_string);
        Some(Self { kind: kind.word(), signature, doc, span: code.span, value: None })
    }
}
