//! What is handed in at the prompt: files and typed forms, run at once or beside the one that runs.

use super::session::{HandedIn, kept_name};
use super::{Prompt, definitions, present};
use anyhow::Result;
use rpl_drive::show::failure_report::Reporter;
use rpl_drive::stopping::halt::Until;
use rpl_lang::code::GlobalKind;
use rpl_lang::diagnostic;
use rpl_runtime::run::library::Rejected;
use rpl_runtime::run::session::{Answer, Submitted};
use rpl_runtime::state::value::Value;
use rpl_shell::files::plans::PlanText;
use rpl_shell::status::Status;

impl Prompt<'_> {
    /// A file: its forms are run in order.
    pub(super) fn load(&mut self, plan: PlanText, until: Until) -> Result<()> {
        let PlanText { name, text, folder } = plan;
        self.session.file = Some(name.clone());
        self.hand_in(HandedIn { name, text, folder, number: None }, &until)
    }

    /// Forms that were typed.
    pub(super) fn forms(&mut self, text: &str, until: &Until) -> Result<()> {
        if let Some(name) = self.called_without_parentheses(text) {
            self.console.note(&format!("error: a call stands in parentheses: `({})`", text.trim()));
            self.console.note(&format!("`{name}` alone is the value of that name, and the rest are further forms"));
            self.worst = Status::Wrong;
            return Ok(());
        }
        self.typed = text.trim_end().to_string();
        let forms = self.session.typed(text);
        self.hand_in(forms, until)
    }

    /// The name of a function or a plan that stands before its arguments in one line: `go-to 'desk`.
    fn called_without_parentheses(&self, text: &str) -> Option<String> {
        let (head, rest) = text.trim().split_once(' ')?;
        let is_one_line =
            !rest.trim().is_empty() && !rest.contains(['\n', ';']) && !head.starts_with(['(', '\'', '`', '#']);
        let program = &self.session.branch.system.program;
        let name = self.session.branch.system.machine.symbols.find(head).filter(|_| is_one_line)?;
        let &global = program.names.get(&name)?;
        let is_function = matches!(program.globals[global as usize].kind, GlobalKind::Function(_));
        is_function.then(|| head.to_string())
    }

    fn hand_in(&mut self, forms: HandedIn, until: &Until) -> Result<()> {
        if self.session.branch.is_running {
            return self.beside(forms);
        }
        match self.session.submit(forms) {
            Ok(submitted) => {
                self.tell(&submitted);
                self.begin(until)
            }
            Err(rejected) => {
                self.reject(&rejected);
                Ok(())
            }
        }
    }

    /// A form was handed in: the clock lets it go on, if it runs.
    fn begin(&mut self, until: &Until) -> Result<()> {
        if self.clock.is_some() { Ok(()) } else { self.go_on(until) }
    }

    /// Forms typed while another one is under way: a task of their own.
    fn beside(&mut self, forms: HandedIn) -> Result<()> {
        let number = forms.number;
        let (submitted, aside) = match self.session.beside(forms) {
            Ok(beside) => beside,
            Err(rejected) => {
                self.reject(&rejected);
                return Ok(());
            }
        };
        self.tell(&submitted);
        self.session.hand_on(self.console)?;
        let system = &self.session.branch.system;
        match aside.answer {
            Some(Answer::Succeeded(value)) => self.show_value(value, number)?,
            Some(Answer::Failed(failure)) => self.show_failure(failure),
            Some(Answer::GivenUp) => {}
            None => {
                if let Some(task) = system.machine.tasks.find_alive(aside.task) {
                    let machine = &system.machine;
                    let standing = present::standing(system, &machine.wait_ends_us(), task);
                    let (path, waits) = (machine.path(task), standing.condition(machine.now_us));
                    self.console.note(&format!("{path} {waits}; it goes on with the run"));
                }
            }
        }
        let system = &self.session.branch.system;
        for &name in &aside.assigned {
            let name = system.machine.symbols.name(name);
            self.console.note(&format!("`{name}` counts from the next form on; the marked one has read its arguments"));
        }
        Ok(())
    }

    /// A value, with the name it is kept under for whoever sits at the prompt.
    pub(super) fn show_value(&mut self, value: Value, number: Option<u32>) -> Result<()> {
        let system = &self.session.branch.system;
        let text = system.machine.write(&system.program, value);
        let name = number.filter(|_| self.is_interactive && value != Value::Nil && !definitions::is_last(&self.typed));
        match name.map(kept_name) {
            Some(name) => self.console.print(&format!("{name} = {text}"))?,
            None => self.console.print(&text)?,
        }
        Ok(())
    }

    fn reject(&mut self, rejected: &Rejected) {
        self.console.note(rejected.render(self.console.colour).trim_end());
        self.worst = Status::Wrong;
    }

    /// Warnings, and what goes on in an old text.
    fn tell(&mut self, submitted: &Submitted) {
        let system = &self.session.branch.system;
        if !submitted.warnings.is_empty() {
            let sources = &system.program.sources;
            self.console.note(diagnostic::render(&submitted.warnings, sources, self.console.colour).trim_end());
        }
        for redefined in &submitted.redefined {
            let name = system.machine.symbols.name(redefined.name);
            match redefined.still_running.as_slice() {
                [] => self.console.note(&format!("`{name}` is defined anew")),
                paths => self.console.note(&format!(
                    "`{name}` is defined anew from its next call on; the old text still runs in {}",
                    paths.join(", ")
                )),
            }
        }
    }

    pub(super) fn show_failure(&mut self, failure: Value) {
        let system = &self.session.branch.system;
        let reporter = Reporter { machine: &system.machine, program: &system.program, colour: self.console.colour };
        self.console.note(reporter.text("failed: ", failure).trim_end());
        self.failure = match failure {
            Value::Failure(index) => system.machine.heap.failures.get(index).cloned(),
            _ => None,
        };
        if self.is_interactive {
            self.console.note("`:back failure` goes back to its place");
        }
        if self.worst == Status::Succeeded {
            self.worst = Status::Failed;
        }
    }
}
