//! New definitions that a run has been given while it stood still. Calls that are made from then on are of the new
//! ones; what is running goes on as it was written.

use super::head::KeptRun;
use super::kept_file::KeptFile;
use anyhow::{Context, Result, anyhow, bail};
use rpl_lang::compile::NoFiles;
use rpl_lang::reader::read;
use rpl_lang::source::SourceId;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::Tree;
use rpl_link::journal::{frames, own_file};
use rpl_mission::robot::Robot;
use rpl_runtime::run::system::System;
use rpl_shell::files::inputs;
use rpl_shell::files::shown::Shown;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::Path;

/// The file that has them.
pub const CHANGES: &str = "changes";

/// Forms whose effect is on later calls alone.
const TAKEN: [&str; 5] = ["def-plan", "def-interp-proc", "def-resume", "defun", "defmacro"];

/// New definitions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// The files as they were then.
    pub files: Vec<KeptFile>,
    /// The texts they replaced something in, by their names, whole.
    pub texts: Vec<(String, String)>,
    /// What is new in each.
    definitions: Vec<(String, String)>,
    /// The instant at whose end they took effect; none as long as they have not.
    pub instant: Option<u32>,
}

/// The changes of a journal, in their order.
///
/// # Errors
/// They cannot be read.
pub fn of_journal(journal: &Path) -> Result<Vec<Change>> {
    let shown = journal.shown();
    let bytes = match own_file::read(&journal.join(CHANGES)) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => bail!("cannot read `{CHANGES}` of the journal `{shown}`: {error}"),
    };
    let found = frames::read(&bytes);
    if found.torn(&bytes) > 0 {
        bail!("the journal `{shown}` is damaged: the file `{CHANGES}` was changed or cut off");
    }
    let read = found.whole.into_iter().map(|change| serde_json::from_slice(change).map_err(anyhow::Error::from));
    read.collect::<Result<_>>().with_context(|| format!("the file `{CHANGES}` of the journal `{shown}` cannot be read"))
}

/// Changes as they stand in their file.
pub fn written(changes: &[Change]) -> serde_json::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    for change in changes {
        frames::push(&mut bytes, &serde_json::to_vec(change)?);
    }
    Ok(bytes)
}

impl Change {
    /// What is new in some files of a run, which has had these changes; and what of it has no effect, for a person.
    ///
    /// # Errors
    /// One of the files is no text of a plan.
    pub fn in_files(kept: &KeptRun, before: &[Change], files: &[&Path]) -> Result<(Self, Vec<String>)> {
        let mut change = Self { files: Vec::new(), texts: Vec::new(), definitions: Vec::new(), instant: None };
        let mut without_effect = Vec::new();
        for &path in files {
            let shown = path.shown();
            let of_plan = kept.head.plan_texts().find(|(name, _)| path.ends_with(name.trim_start_matches("./")));
            let Some((name, first)) = of_plan else {
                bail!("`{shown}` changed since the run began, and only the texts of its plan may; put it back");
            };
            let text = inputs::read_text(path).map_err(|why| anyhow!("cannot read `{shown}`: {why}"))?;
            let replaced = before.iter().rev().flat_map(|change| &change.texts).find(|(known, _)| known == name);
            let old = replaced.map_or(first, |(_, text)| text);
            let (new, others) = difference(old, &text);
            without_effect.extend(others.into_iter().map(|form| format!("`{name}`: {form}")));
            change.files.extend(KeptFile::now(path));
            change.definitions.push((name.to_string(), new));
            change.texts.push((name.to_string(), text));
        }
        Ok((change, without_effect))
    }

    /// Gives them to the run.
    ///
    /// # Errors
    /// They do not compile into it.
    pub fn apply(&self, system: &mut System<Robot>) -> Result<()> {
        for (name, definitions) in &self.definitions {
            match system.inspect(name, definitions, &[], &mut NoFiles) {
                Ok((_, Ok(_))) => {}
                Ok((_, Err(failure))) => {
                    bail!("the new `{name}` fails: {}", system.machine.write(&system.program, failure))
                }
                Err(rejected) => bail!("{}", rejected.render(false).trim_end()),
            }
        }
        Ok(())
    }
}

/// Files of a run that are there, and not what they were when it last took something from them.
pub fn changed_files<'k>(kept: &'k KeptRun, changes: &[Change]) -> Vec<&'k Path> {
    let is_changed = |file: &&KeptFile| {
        let taken = changes.iter().rev().flat_map(|change| &change.files).find(|taken| taken.path == file.path);
        let then = taken.unwrap_or(file).checksum;
        KeptFile::now(&file.path).is_some_and(|now| now.checksum != then)
    };
    kept.head.files.iter().filter(is_changed).map(|file| &*file.path).collect()
}

/// Definitions in a text that an older one does not have, and the beginnings of other forms that are new in it.
fn difference(old: &str, new: &str) -> (String, Vec<String>) {
    let known: Vec<String> = forms(old).into_iter().map(|(_, form)| form).collect();
    let (mut definitions, mut others) = (Vec::new(), Vec::new());
    for (head, form) in forms(new).into_iter().filter(|(_, form)| !known.contains(form)) {
        if TAKEN.contains(&&*head) {
            definitions.push(form);
        } else {
            others.push(form.lines().next().unwrap_or_default().to_string());
        }
    }
    (definitions.join("\n"), others)
}

/// The forms of a text, with what each begins with.
fn forms(text: &str) -> Vec<(String, String)> {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    // What is wrong with the text is told when it is compiled.
    let (roots, _) = read(text, SourceId(0), &mut symbols, &mut tree);
    let form = |&root: &_| {
        let span = tree.span(root);
        let head = tree.head(root).map_or("", |head| symbols.name(head));
        (head.to_string(), text[span.start as usize..span.end as usize].to_string())
    };
    roots.iter().map(form).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_new_is_found_form_by_form() {
        let old = "; old\n(defvar speed 1)\n(defun a () 1)\n(def-plan b () (a))\n(b)";
        let new = "(defvar speed 2)\n(defun a () 1) ; moved\n(def-plan b () (a) (a))\n(defun c () 3)\n(b)";
        let (definitions, others) = difference(old, new);
        assert_eq!(definitions, "(def-plan b () (a) (a))\n(defun c () 3)");
        assert_eq!(others, ["(defvar speed 2)"]);
        assert_eq!(difference(old, old), (String::new(), Vec::new()));
    }
}
