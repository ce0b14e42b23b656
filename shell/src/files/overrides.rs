//! `--set NAME=EXPR`: other first values for the variables of a plan.
//!
//! The first value is exchanged in the text, so that it is evaluated where and when the plan's own
//! would be, and an error in it is shown like any other.

use anyhow::{Result, bail};
use rpl_lang::bars::read_name;
use rpl_lang::compile::Loader;
use rpl_lang::diagnostic::render;
use rpl_lang::reader::read;
use rpl_lang::source::{SourceId, Sources};
use rpl_lang::suggest::suggest;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::{NodeId, Tree};

/// Forms that give a global name its first value, and so can be overridden.
const DEFINITIONS: &[&str] = &["defvar", "defconstant", "def-fluent", "global-fluent"];

/// One `NAME=EXPR`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Override {
    name: String,
    expression: String,
    used: bool,
}

impl Override {
    /// Reads `NAME=EXPR`.
    ///
    /// # Errors
    /// There is no `=`, or the expression is not one datum.
    pub fn parse(argument: &str) -> Result<Self> {
        let Some((name, expression)) = argument.split_once('=') else {
            bail!("`--set {argument}` has no value; write `--set {argument}=EXPR`");
        };
        let (mut symbols, mut tree, mut sources) = (Symbols::default(), Tree::default(), Sources::default());
        let source = sources.add("--set", expression);
        let (roots, findings) = read(expression, source, &mut symbols, &mut tree);
        if !findings.is_empty() {
            bail!("the value in `{argument}` cannot be read\n{}", render(&findings, &sources, false));
        }
        if roots.len() != 1 {
            bail!("`--set {argument}` needs one expression after the `=`, found {}", roots.len());
        }
        let name = read_name(name.trim()).into_owned();
        // The datum alone: a comment behind it would swallow what follows it in the plan.
        let expression = sources.text_of(tree.span(roots[0])).to_string();
        Ok(Self { name, expression, used: false })
    }
}

impl Override {
    fn shown(&self) -> String {
        format!("{} #| by --set |#", self.expression)
    }
}

/// The overrides of a run, applied to every text it reads.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    list: Vec<Override>,
    /// Names that could be overridden, for suggestions.
    definitions: Vec<String>,
}

impl Overrides {
    /// From the arguments of the command line.
    ///
    /// # Errors
    /// One of them is wrong.
    pub fn parse(arguments: &[String]) -> Result<Self> {
        let list = arguments.iter().map(|argument| Override::parse(argument)).collect::<Result<Vec<_>>>()?;
        for (at, given) in list.iter().enumerate() {
            if let Some(before) = list[..at].iter().find(|before| before.name == given.name) {
                let (name, first, second) = (&given.name, &before.expression, &given.expression);
                bail!("`{name}` is given twice: `--set {name}={first}` and `--set {name}={second}`; leave one away");
            }
        }
        Ok(Self { list, definitions: Vec::new() })
    }

    /// The text with its definitions exchanged. Where it is shown it says that a value was given.
    pub fn apply(&mut self, text: String) -> String {
        if self.list.is_empty() {
            return text;
        }
        let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
        // What is wrong with the text is told when it is compiled.
        let (roots, _) = read(&text, SourceId(0), &mut symbols, &mut tree);
        let mut changed = text.clone();
        for &root in roots.iter().rev() {
            let Some((name, value)) = definition(&tree, &symbols, root) else { continue };
            self.definitions.push(name.to_string());
            let Some(given) = self.list.iter_mut().find(|given| given.name == name) else { continue };
            given.used = true;
            match value {
                Some(value) => {
                    let span = tree.span(value);
                    changed.replace_range(span.start as usize..span.end as usize, &given.shown());
                }
                None => {
                    let end = tree.span(root).end as usize - 1;
                    changed.insert_str(end, &format!(" {}", given.shown()));
                }
            }
        }
        changed
    }

    /// # Errors
    /// A name was given that no text defines.
    pub fn check_all_used(&self) -> Result<()> {
        let Some(unused) = self.list.iter().find(|given| !given.used) else { return Ok(()) };
        let name = &unused.name;
        match suggest(name, self.definitions.iter().map(String::as_str)) {
            Some(meant) => bail!("the plan has no variable `{name}` to set; did you mean `{meant}`?"),
            None if self.definitions.is_empty() => {
                bail!("the plan has no variable `{name}` to set; it has none at all")
            }
            None => bail!("the plan has no variable `{name}` to set; it has {}", self.definitions.join(", ")),
        }
    }
}

/// The names in a text that can be overridden, in the order of their definitions.
pub(crate) fn definitions(text: &str) -> Vec<String> {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (roots, _) = read(text, SourceId(0), &mut symbols, &mut tree);
    roots.iter().filter_map(|&root| Some(definition(&tree, &symbols, root)?.0.to_string())).collect()
}

/// Name and first value of a definition that can be overridden.
fn definition<'s>(tree: &Tree, symbols: &'s Symbols, root: NodeId) -> Option<(&'s str, Option<NodeId>)> {
    let head = symbols.name(tree.head(root)?);
    if !DEFINITIONS.contains(&head) {
        return None;
    }
    let items = tree.proper_list(root)?;
    let name = symbols.name(tree.symbol(*items.get(1)?)?);
    Some((name, items.get(2).copied()))
}

/// A loader whose texts are overridden too.
pub struct OverridingLoader<'a> {
    /// Finds the texts.
    pub inner: &'a mut dyn Loader,
    /// What is exchanged in them.
    pub overrides: &'a mut Overrides,
}

impl Loader for OverridingLoader<'_> {
    fn load(&mut self, from: &str, path: &str) -> Result<(String, String), String> {
        let (name, text) = self.inner.load(from, path)?;
        Ok((name, self.overrides.apply(text)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn overridden(text: &str, arguments: &[&str]) -> (String, Overrides) {
        let arguments: Vec<String> = arguments.iter().map(ToString::to_string).collect();
        let mut overrides = Overrides::parse(&arguments).expect("the arguments are right");
        let text = overrides.apply(text.to_string());
        (text, overrides)
    }

    #[test]
    fn first_values_are_exchanged_and_nothing_else() {
        let plan = "(defvar speed 1 \"how fast\") (def-fluent goal)\n(print speed) (defvar other (+ speed 1))";
        let (text, overrides) = overridden(plan, &["SPEED=(+ 1 2)", "goal='home", "other=7"]);
        assert_eq!(
            text,
            "(defvar speed (+ 1 2) #| by --set |# \"how fast\") (def-fluent goal 'home #| by --set |#)\n(print speed) (defvar other 7 #| by --set |#)"
        );
        assert!(overrides.check_all_used().is_ok());
    }

    #[test]
    fn a_name_the_plan_does_not_have_is_an_error_with_a_suggestion() {
        let (_, overrides) = overridden("(defvar speed 1)", &["sped=2"]);
        let error = overrides.check_all_used().expect_err("`sped` is not there");
        assert!(error.to_string().contains("did you mean `speed`?"));
    }

    #[test]
    fn a_name_is_given_once_and_a_comment_swallows_nothing() {
        let twice = Overrides::parse(&["speed=1".into(), "other=2".into(), "SPEED=(+ 1 1)".into()]);
        let error = twice.expect_err("`speed` is given twice").to_string();
        assert!(error.contains("`speed` is given twice: `--set speed=1` and `--set speed=(+ 1 1)`"), "{error}");
        let (text, _) = overridden("(defvar speed 1) (print speed)", &["speed=2 ; faster"]);
        assert_eq!(text, "(defvar speed 2 #| by --set |#) (print speed)");
    }

    #[test]
    fn what_is_no_expression_is_refused() {
        for argument in ["speed", "speed=", "speed=1 2", "speed=(1"] {
            assert!(Override::parse(argument).is_err(), "{argument}");
        }
    }
}
