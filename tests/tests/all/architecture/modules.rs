//! The modules of a crate as its files have them: what each defines, imports and names.

use crate::architecture::tokens::{Token, tokens};
use std::collections::{BTreeMap, BTreeSet};

/// Names as they are written one after the other, with `crate`, `self` and `super`.
pub type Path = Vec<String>;

/// The text of a file by its path from the root of the repository, if there is one.
pub type Texts<'f> = &'f dyn Fn(&str) -> Option<String>;

/// The modules of a crate without its tests. The first is its root.
pub struct Modules(pub Vec<Module>);

/// A module, which has a file or is written in one.
#[derive(Default)]
pub struct Module {
    /// From the root of the crate.
    pub path: Path,
    /// From the root of the repository.
    pub file: String,
    pub parent: Option<usize>,
    pub children: BTreeMap<String, usize>,
    /// What is defined here and has a name.
    pub definitions: BTreeSet<String>,
    pub imports: Vec<Import>,
    /// Paths of two names or more that are no imports.
    pub paths: BTreeSet<Path>,
    /// All names outside imports, but those of fields and methods.
    pub words: BTreeSet<String>,
}

/// One name of a `use`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Import {
    pub path: Path,
    /// What it is called here; `*` for all that the path has.
    pub name: String,
    /// Whether others may take it from here.
    pub is_public: bool,
}

/// What is defined by a word and the name behind it.
const KINDS: [&str; 8] = ["fn", "struct", "enum", "union", "trait", "type", "static", "const"];

/// What may stand between such a word and the name.
const BETWEEN: [&str; 3] = ["fn", "unsafe", "extern"];

const CRATE: &str = "crate";

impl Modules {
    /// Those of a crate by the file of its root.
    pub fn of_crate(root: &str, texts: Texts<'_>) -> Self {
        let mut modules = Self(Vec::new());
        let folder = root.rsplit_once('/').map_or("", |(folder, _)| folder);
        modules.read_file(Module { path: vec![CRATE.into()], file: root.into(), ..Module::default() }, folder, texts);
        modules
    }

    /// The module of a file whose children are files of a folder.
    fn read_file(&mut self, module: Module, folder: &str, texts: Texts<'_>) -> usize {
        let text = texts(&module.file).unwrap_or_else(|| panic!("{} is no text", module.file));
        self.read(module, folder, &without_tests(&tokens(&text)), texts)
    }

    fn read(&mut self, module: Module, folder: &str, tokens: &[Token<'_>], texts: Texts<'_>) -> usize {
        let number = self.0.len();
        self.0.push(module);
        let (mut at, mut depth) = (0, 0);
        let (mut is_public, mut is_exported) = (false, false);
        while let Some(&token) = tokens.get(at) {
            let was_public = std::mem::take(&mut is_public);
            match (token, &tokens[at + 1..]) {
                (Token::Sign('(' | '[' | '{'), _) => depth += 1,
                (Token::Sign(')' | ']' | '}'), _) => depth -= 1,
                (Token::Sign(_) | Token::Literal, _) => {}
                (Token::Word("pub"), rest) => {
                    is_public = true;
                    at += visibility_len(rest);
                }
                (Token::Word("use"), rest) if rest.first() != Some(&Token::Sign('<')) => {
                    let len = rest.iter().take_while(|token| **token != Token::Sign(';')).count();
                    self.0[number].import(&[], &rest[..len], was_public);
                    at += len;
                }
                (Token::Word("mod"), [Token::Word(name), rest @ ..]) => {
                    let body = body_len(rest);
                    if depth == 0 {
                        self.read_child(number, name, folder, &rest[..body], texts);
                    }
                    at += 1 + body;
                }
                (Token::Word("macro_export"), _) => is_exported = true,
                (Token::Word("macro_rules"), [Token::Sign('!'), Token::Word(name), ..]) => {
                    self.0[number].definitions.insert((*name).into());
                    if std::mem::take(&mut is_exported) && number > 0 {
                        let path = below(&self.0[number].path, name);
                        self.0[0].imports.push(Import { path, name: (*name).into(), is_public: true });
                    }
                }
                (Token::Word(_), _) if is_member(&tokens[..at]) => {}
                (Token::Word(word), rest) => {
                    if let Some(Token::Word(name)) = rest.first()
                        && depth == 0
                        && KINDS.contains(&word)
                        && !BETWEEN.contains(name)
                    {
                        self.0[number].definitions.insert((*name).into());
                    }
                    at += self.0[number].name(word, rest);
                }
            }
            at += 1;
        }
        number
    }

    /// Reads a module within another one: the tokens of its body, or none if it has a file.
    fn read_child(&mut self, parent: usize, name: &str, folder: &str, body: &[Token<'_>], texts: Texts<'_>) {
        let folder = format!("{folder}/{name}");
        let Module { path, file, .. } = &self.0[parent];
        let child = |file: String| Module { path: below(path, name), file, parent: Some(parent), ..Module::default() };
        let number = if let [Token::Sign('{'), body @ .., Token::Sign('}')] = body {
            self.read(child(file.clone()), &folder, body, texts)
        } else {
            let [beside, within] = [format!("{folder}.rs"), format!("{folder}/mod.rs")];
            let file = if texts(&beside).is_some() { beside } else { within };
            self.read_file(child(file), &folder, texts)
        };
        self.0[parent].children.insert(name.into(), number);
    }
}

impl Module {
    /// Takes a word that a path may begin with, and what stands behind it; answers how much of that belongs to it.
    fn name(&mut self, word: &str, rest: &[Token<'_>]) -> usize {
        let mut path = vec![word.to_string()];
        for part in rest.chunks_exact(3) {
            let [Token::Sign(':'), Token::Sign(':'), Token::Word(name)] = part else {
                break;
            };
            path.push((*name).into());
        }
        let len = 3 * (path.len() - 1);
        self.words.insert(word.into());
        if path.len() > 1 {
            self.paths.insert(path);
        }
        len
    }

    /// Takes the names of one branch of a `use`.
    fn import(&mut self, before: &[String], branch: &[Token<'_>], is_public: bool) {
        let mut path = before.to_vec();
        let mut name = None;
        for (at, token) in branch.iter().enumerate() {
            match token {
                Token::Sign('{') => {
                    for branch in branches(&branch[at + 1..branch.len() - 1]) {
                        self.import(&path, branch, is_public);
                    }
                    return;
                }
                Token::Sign('*') => name = Some("*".to_string()),
                Token::Word("as") => {
                    name =
                        branch.get(at + 1).map(|token| if let Token::Word(name) = token { name } else { "_" }.into());
                    break;
                }
                Token::Word(word) => path.push((*word).into()),
                Token::Sign(_) | Token::Literal => {}
            }
        }
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        if let Some(name) = name.or_else(|| path.last().cloned()) {
            self.imports.push(Import { path, name, is_public });
        }
    }
}

fn below(path: &[String], name: &str) -> Path {
    [path, &[name.to_string()]].concat()
}

/// What stands between braces, parted by the commas that stand in no other braces.
fn branches<'b, 't>(tokens: &'b [Token<'t>]) -> Vec<&'b [Token<'t>]> {
    let mut depth = 0;
    let parted = tokens.split(|token| {
        depth += match token {
            Token::Sign('{') => 1,
            Token::Sign('}') => -1,
            Token::Sign(_) | Token::Word(_) | Token::Literal => 0,
        };
        *token == Token::Sign(',') && depth == 0
    });
    parted.filter(|branch| !branch.is_empty()).collect()
}

/// Whether a word behind these tokens goes on with them: a field, a method, or a part of a path.
fn is_member(before: &[Token<'_>]) -> bool {
    match before {
        [.., Token::Sign('.'), Token::Sign('.')] => false,
        [.., Token::Sign('.')] | [.., Token::Sign(':'), Token::Sign(':')] => true,
        _ => false,
    }
}

/// How many tokens behind `pub` say who may see it.
fn visibility_len(rest: &[Token<'_>]) -> usize {
    match rest {
        [Token::Sign('('), Token::Word("crate" | "super" | "self" | "in"), ..] => {
            1 + rest.iter().take_while(|token| **token != Token::Sign(')')).count()
        }
        _ => 0,
    }
}

/// How many tokens it is to the end of an item: a semicolon, or what closes its braces.
fn body_len(tokens: &[Token<'_>]) -> usize {
    let mut depth = 0;
    let end = tokens.iter().position(|token| {
        match token {
            Token::Sign('(' | '[' | '{') => depth += 1,
            Token::Sign(')' | ']' | '}') => depth -= 1,
            Token::Sign(_) | Token::Word(_) | Token::Literal => {}
        }
        depth == 0 && matches!(token, Token::Sign(';' | '}'))
    });
    end.map_or(tokens.len(), |end| end + 1)
}

/// The tokens but those of items that only tests have.
fn without_tests<'t>(tokens: &[Token<'t>]) -> Vec<Token<'t>> {
    use Token::{Sign, Word};
    const FOR_TESTS: [Token<'_>; 7] =
        [Sign('#'), Sign('['), Word("cfg"), Sign('('), Word("test"), Sign(')'), Sign(']')];
    let mut kept = Vec::with_capacity(tokens.len());
    let mut rest = tokens;
    while let Some((&first, behind)) = rest.split_first() {
        if let Some(item) = rest.strip_prefix(&FOR_TESTS) {
            rest = &item[body_len(item)..];
        } else {
            kept.push(first);
            rest = behind;
        }
    }
    kept
}
