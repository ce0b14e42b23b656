//! Definitions as text: shown, edited in the user's editor, and saved as a file.

use super::definitions::{self, Definition};
use super::{Prompt, external_editor, is_blank};
use anyhow::Result;
use rpl_drive::stopping::halt::Until;
use rpl_lang::compile::NoFiles;
use rpl_shell::files::{inputs, outputs};
use std::path::Path;

impl Prompt<'_> {
    /// `:source`: the text of a definition.
    pub(super) fn source(&mut self, name: &str) -> Result<()> {
        if name.is_empty() {
            return self.wrong("`:source NAME`: a name is expected, such as `:source wait-for`");
        }
        let system = &self.session.branch.system;
        let Some(definition) = definitions::named(system, name) else {
            let reason = self.without_text(name)?;
            return self.wrong(&reason);
        };
        let lines = format!(
            "; {}\n{}",
            system.program.sources.place(definition.span),
            definitions::with_comments(system, &definition)
        );
        // Not laid out: it is to be copied.
        lines.lines().try_for_each(|line| self.console.print(line))?;
        Ok(())
    }

    /// Why a name has no text.
    fn without_text(&self, name: &str) -> Result<String> {
        let reference = self.reference()?;
        if let Some(entry) = reference.find(name) {
            let kind = entry.kind.word();
            return Ok(format!("`{name}` is a {kind} that is built in, without a text; `:doc {name}` documents it"));
        }
        Ok(self.unknown(name))
    }

    /// `:edit`: the last form or a definition in the user's editor; what comes back is run.
    pub(super) fn edit(&mut self, name: &str) -> Result<()> {
        let system = &self.session.branch.system;
        let text = match definitions::named(system, name) {
            _ if name.is_empty() => self.typed.clone(),
            Some(definition) => definitions::with_comments(system, &definition),
            None => {
                let reason = self.without_text(name)?;
                return self.wrong(&reason);
            }
        };
        self.console.flush()?;
        match external_editor::edited(&text, self.is_interactive) {
            Err(reason) => self.wrong(&reason),
            Ok(edited) if edited.trim() == text.trim() => {
                self.console.note("the text is as it was; nothing is run");
                Ok(())
            }
            Ok(edited) if is_blank(&edited) => {
                self.console.note("the text is empty; nothing is run");
                Ok(())
            }
            Ok(edited) => {
                self.note_typed(&edited);
                self.forms(&edited, &Until::End)
            }
        }
    }

    /// `:save`: what the session defines, as a file that loads.
    pub(super) fn save(&mut self, path: &str) -> Result<()> {
        if path.is_empty() {
            return self.wrong("`:save FILE`: the name of a file is expected, such as `:save my-plans.rpl`");
        }
        let system = &self.session.branch.system;
        let own = definitions::own(system);
        if own.is_empty() {
            return self.wrong("nothing is defined yet; there is nothing to save");
        }
        let text = file_of(system, &own);
        // What this session wrote there, and nobody has changed since, is nobody's loss.
        let is_ours =
            self.saved.get(path).is_some_and(|saved| inputs::read_text(Path::new(path)).as_ref() == Ok(saved));
        if let Err(reason) = outputs::write_new(Path::new(path), &text, is_ours) {
            return self.wrong(&format!("cannot save to `{path}`: {reason}"));
        }
        self.saved.insert(path.to_string(), text.clone());
        let count = match own.len() {
            1 => "1 definition".to_string(),
            count => format!("{count} definitions"),
        };
        self.console.note(&format!("saved {count} in `{path}`; `:load {path}` loads them"));
        if let Err(rejected) = system.library.load(path, &text, &mut NoFiles) {
            let drawn = rejected.render(self.console.colour);
            self.console.note(&format!("warning: alone the file does not load:\n{}", drawn.trim_end()));
        }
        Ok(())
    }
}

/// The definitions in the order of the latest of each. A macro that was defined anew after its last
/// use would come too late: then its text comes first.
fn file_of(system: &rpl_runtime::run::system::System<rpl_mission::robot::Robot>, own: &[Definition]) -> String {
    let text = |definitions: &[&Definition]| {
        let texts: Vec<String> =
            definitions.iter().map(|definition| definitions::with_comments(system, definition)).collect();
        texts.join("\n\n") + "\n"
    };
    let in_order = text(&own.iter().collect::<Vec<_>>());
    if system.library.load("saved", &in_order, &mut NoFiles).is_ok() {
        return in_order;
    }
    let (macros, others): (Vec<_>, Vec<_>) = own.iter().partition(|definition| definition.form == "defmacro");
    let macros_first = text(&[macros, others].concat());
    match system.library.load("saved", &macros_first, &mut NoFiles) {
        Ok(_) => macros_first,
        Err(_) => in_order,
    }
}
