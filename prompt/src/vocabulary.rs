//! What can be typed: the words that Tab completes, each where it fits.

use super::command::{COMMANDS, Verb};
use super::session::Session;
use anyhow::Result;
use rpl_drive::stopping::breakpoint;
use rpl_drive::stopping::breakpoint::FAILURE;
use rpl_lang::code::GlobalKind;
use rpl_lang::lexer::{Token, lex};
use rpl_lang::source::SourceId;
use rpl_mission::examples;
use rpl_mission::reference::{self, Reference};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What the library knows, for the whole session.
pub struct LibraryWords {
    /// How each name is written, and the first sentence about it.
    names: BTreeMap<String, String>,
    keywords: BTreeSet<String>,
}

/// What the session knows, and the world: it changes from line to line.
#[derive(Clone, Debug, Default)]
pub struct Vocabulary {
    names: BTreeMap<String, String>,
    /// Plans, functions and tags a run can stop at.
    stops: Vec<String>,
    tasks: Vec<String>,
    forks: Vec<String>,
    /// Rooms and places of the world.
    places: Vec<String>,
}

impl LibraryWords {
    /// What is built in.
    ///
    /// # Errors
    /// The library does not compile.
    pub fn new() -> Result<Self> {
        let reference = Reference::new()?;
        let names: BTreeMap<String, String> =
            reference.names().map(|entry| (entry.name.clone(), one_line(&entry.signature, entry.summary()))).collect();
        let keywords = reference.names().flat_map(|entry| keywords_of(&entry.signature)).collect();
        Ok(Self { names, keywords })
    }
}

fn one_line(signature: &str, summary: &str) -> String {
    let signature = signature.split_whitespace().collect::<Vec<_>>().join(" ");
    format!("{signature}  {summary}")
}

/// The keywords a signature names: those behind `&key`, and those it writes out.
fn keywords_of(signature: &str) -> Vec<String> {
    let bare = |word: &str| word.trim_matches(|c: char| "()[].".contains(c)).to_string();
    let words: Vec<String> = signature.split_whitespace().map(bare).collect();
    let after_key = words.iter().skip_while(|word| *word != "&key").skip(1).take_while(|word| !word.starts_with('&'));
    let named = after_key.map(|word| format!(":{word}"));
    let written = words.iter().filter(|word| word.starts_with(':')).cloned();
    named.chain(written).filter(|word| word.len() > 1).collect()
}

impl Vocabulary {
    /// What can be typed now.
    pub fn of(session: &Session, places: &[String]) -> Self {
        let system = &session.branch.system;
        let (program, machine) = (&system.program, &system.machine);
        let own = program.globals.iter().skip(program.library_globals as usize);
        let names = own.filter(|global| !machine.symbols.name(global.name).starts_with(['%', '#'])).map(|global| {
            let name = machine.symbols.name(global.name).to_string();
            let code = match global.kind {
                GlobalKind::Function(code) => program.codes.get(code as usize),
                _ => None,
            };
            let signature = code.map_or_else(String::new, |code| reference::signature(&name, code, program));
            let doc = global.doc.as_deref().and_then(|doc| doc.lines().next()).unwrap_or_default();
            (name, one_line(&signature, doc))
        });
        let alive = machine.tasks.iter().filter(|(index, task)| *index != 0 && !task.state().is_dead());
        Self {
            names: names.collect(),
            stops: breakpoint::known_names(system),
            tasks: alive.map(|(index, _)| machine.path(index)).collect(),
            forks: session.others.keys().cloned().collect(),
            places: places.to_vec(),
        }
    }

    /// What is said of a name.
    pub fn hint<'a>(&'a self, library: &'a LibraryWords, name: &str) -> Option<&'a str> {
        let name = name.to_lowercase();
        self.names.get(&name).or_else(|| library.names.get(&name)).map(|hint| hint.trim())
    }

    /// Whether a name means something.
    pub fn knows(&self, library: &LibraryWords, name: &str) -> bool {
        let name = name.to_lowercase();
        self.names.contains_key(&name) || library.names.contains_key(&name)
    }

    /// The words that can stand at the end of a text, and where they begin.
    pub fn complete(&self, library: &LibraryWords, text: &str) -> (usize, Vec<String>) {
        let start = word_start(text);
        let (before, word) = (&text[..start], text[start..].to_lowercase());
        let typed = before.trim_start();
        if typed.is_empty() && word.starts_with(':') {
            return (start, fitting(COMMANDS.iter().map(|entry| entry.name), &word));
        }
        // At the beginning of a line that goes on, everything would fit.
        if word.is_empty() && before.rsplit_once('\n').is_some_and(|(_, line)| line.trim().is_empty()) {
            return (start, Vec::new());
        }
        let command = typed.split_whitespace().next().filter(|name| name.starts_with(':'));
        let verb = command.and_then(|name| COMMANDS.iter().find(|entry| entry.name == name)).map(|entry| entry.verb);
        let names = self.names.keys().chain(library.names.keys()).map(String::as_str);
        let found = match verb {
            Some(Verb::Load) => {
                let start = text.rfind(char::is_whitespace).map_or(0, |at| at + 1);
                return (start, plans(&text[start..]));
            }
            Some(Verb::Save) => {
                let start = text.rfind(char::is_whitespace).map_or(0, |at| at + 1);
                return (start, files(&text[start..]));
            }
            Some(Verb::Help) => {
                let commands = COMMANDS.iter().map(|entry| entry.name);
                let bare = commands.clone().map(|name| &name[1..]);
                fitting(
                    if word.starts_with(':') { commands.collect() } else { bare.collect::<Vec<_>>() }.into_iter(),
                    &word,
                )
            }
            Some(Verb::Why | Verb::Task) => fitting(self.tasks.iter().map(String::as_str), &word),
            Some(Verb::Switch) => fitting(self.forks.iter().map(String::as_str), &word),
            Some(Verb::Break) if !typed.contains('(') => {
                fitting(self.stops.iter().map(String::as_str).chain([FAILURE]), &word)
            }
            Some(Verb::Until) if !typed.contains('(') => fitting(self.stops.iter().map(String::as_str), &word),
            Some(Verb::Back) => fitting([FAILURE].into_iter(), &word),
            _ if word.starts_with(':') => fitting(library.keywords.iter().map(String::as_str), &word),
            // Behind a quote a place is meant, and only where none fits any other name.
            _ if before.ends_with('\'') => match fitting(self.places.iter().map(String::as_str), &word) {
                places if places.is_empty() => fitting(names, &word),
                places => places,
            },
            _ => fitting(names, &word),
        };
        (start, found)
    }
}

fn fitting<'a>(words: impl Iterator<Item = &'a str>, beginning: &str) -> Vec<String> {
    let found: BTreeSet<&str> = words.filter(|word| word.starts_with(beginning)).collect();
    found.into_iter().map(str::to_string).collect()
}

/// Where the word that ends a text begins.
fn word_start(text: &str) -> usize {
    let is_border = |c: char| c.is_whitespace() || matches!(c, '(' | ')' | '\'' | '`' | ',' | '"');
    text.rfind(is_border).map_or(0, |at| at + text[at..].chars().next().map_or(1, char::len_utf8))
}

/// The name that is being called where a text ends: the first word of the innermost list that is open there, once
/// something stands behind it. None within what is quoted, or within a string.
pub fn called(text: &str) -> Option<&str> {
    let (tokens, _) = lex(text, SourceId(0));
    // What stands in front of the next list, and each open list: whether it is quoted, and its first word.
    let mut is_quoted = false;
    let mut open: Vec<(bool, Option<&str>)> = Vec::new();
    for (token, span) in tokens {
        let word = text.get(span.start as usize..span.end as usize)?;
        match token {
            Token::Unterminated => return None,
            Token::Open => open.push((is_quoted || open.last().is_some_and(|(is_quoted, _)| *is_quoted), None)),
            Token::Close => drop(open.pop()),
            Token::LineComment | Token::BlockComment | Token::DatumComment => continue,
            _ => {
                if let Some((_, first @ None)) = open.last_mut() {
                    *first = Some(word);
                }
            }
        }
        is_quoted = matches!(token, Token::Prefix(_)) && matches!(word, "'" | "`");
    }
    let (is_quoted, first) = open.last()?;
    // A word behind its parenthesis is still being typed.
    let is_typed = |word: &&str| text.strip_suffix(*word).is_some_and(|before| before.ends_with('('));
    first.filter(|word| !is_quoted && !is_typed(word))
}

/// Plan files and folders that a path may go on to, and the built-in examples.
fn plans(path: &str) -> Vec<String> {
    let built_in = examples::names().filter(|name| name.starts_with(path)).map(str::to_string);
    files(path).into_iter().chain(built_in).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Plan files and folders that a path may go on to.
fn files(path: &str) -> Vec<String> {
    let (folder, beginning) = path.rsplit_once('/').map_or(("", path), |(folder, name)| (folder, name));
    let prefix = &path[..path.len() - beginning.len()];
    let looked_at = match (folder, prefix) {
        ("", "") => Path::new("."),
        ("", _) => Path::new("/"),
        (folder, _) => Path::new(folder),
    };
    let entries = std::fs::read_dir(looked_at).into_iter().flatten().flatten();
    let files = entries.filter_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        let fits = name.starts_with(beginning) && !name.starts_with('.') && (is_folder || name.ends_with(".rpl"));
        fits.then(|| format!("{prefix}{name}{}", if is_folder { "/" } else { "" }))
    });
    files.collect::<BTreeSet<_>>().into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn completed(text: &str) -> Vec<String> {
        let vocabulary = Vocabulary {
            names: BTreeMap::from([("greet".to_string(), "(greet who)".to_string())]),
            stops: vec!["greet".to_string()],
            tasks: vec!["main/greet".to_string()],
            forks: vec!["before".to_string()],
            places: vec!["mail-slots".to_string()],
        };
        vocabulary.complete(&LibraryWords::new().expect("the library compiles"), text).1
    }

    #[test]
    fn each_word_is_completed_where_it_fits() {
        for (text, expected) in [
            (":contin", ":continue"),
            (":break gr", "greet"),
            (":why main/", "main/greet"),
            (":switch be", "before"),
            (":load deliv", "delivery.rpl"),
            (":help contin", "continue"),
            (":doc gre", "greet"),
            (":back f", "failure"),
            (":break fai", "failure"),
            (":source wheneve", "whenever"),
            (":edit gre", "greet"),
            ("(go-to 'mail", "mail-slots"),
            ("(go-to '", "mail-slots"),
            ("(describe 'wheneve", "whenever"),
            ("(run-behaviour gripper :gras", ":grasp"),
            (":step (gre", "greet"),
            ("(def-pla", "def-plan"),
        ] {
            assert_eq!(completed(text), [expected], "{text}");
        }
    }

    #[test]
    fn nothing_is_offered_before_the_first_word_of_a_line() {
        assert!(completed("(list 1\n       ").is_empty());
        assert!(completed("(list 1\n       (").len() > 100);
    }

    #[test]
    fn what_is_called_is_the_name_behind_the_parenthesis() {
        assert_eq!(called("(print (wait-for "), Some("wait-for"));
        // Through all arguments, and again behind an inner list.
        assert_eq!(called("(print who "), Some("print"));
        assert_eq!(called("(deliver 'mail 'a (list 1 2) "), Some("deliver"));
        assert_eq!(called("(go-to 'mail"), Some("go-to"));
        assert_eq!(called("(print"), None);
        assert_eq!(called("(print 1) "), None);
        assert_eq!(called("(dolist (x '(a b"), None);
        assert_eq!(called("(print \"so (far "), None);
    }
}
