//! Advice on a name that nothing defines, from how it is spelt and from where it stands: what users of other languages
//! write out of habit.

use super::compiler::Compiler;
use crate::infix::{beginning, enclosing_list, infix_in};
use crate::source::Span;

/// The word that a list begins with, as far as its beginning is near.
const HEAD_BYTES: usize = 60;

impl Compiler<'_> {
    /// Advice that the spelling of a name gives.
    pub(super) fn spelling_advice(&self, text: &str) -> Option<String> {
        if text.contains(['“', '”', '„', '‘', '’']) {
            return Some("quotation marks are straight: `\"text\"`".into());
        }
        if let Some(name) = text.strip_suffix(':').filter(|name| !name.is_empty()) {
            return Some(format!("the colon of a keyword stands first: `:{name}`"));
        }
        if let Some((name, value)) = text.split_once('=')
            && name.starts_with(char::is_alphabetic)
            && name.chars().all(|c| c.is_alphanumeric() || c == '-')
            && !value.is_empty()
        {
            return Some(format!("a keyword and its value are two words: `:{name} {value}`"));
        }
        if text.ends_with(".rpl") {
            return Some(format!(
                "a file is loaded by its name as a text: `(load \"{text}\")`; at the prompt `:load {text}` runs it"
            ));
        }
        if let Some(of) = text.strip_suffix(".message").filter(|of| !of.is_empty()) {
            return Some(format!("write `(failure-message {of})`"));
        }
        let class = self.symbols.find(text).filter(|class| self.program.failure_classes.contains_key(class));
        class.map(|_| {
            format!(
                "`{text}` is a class of failure: it stands in a clause of `with-failure-handling`, `(({text} (f) …))`"
            )
        })
    }

    /// Advice that the two lists around a name give: the name stands where a form has a list of another shape.
    pub(super) fn shape_of_list_advice(&self, span: Span, text: &str) -> Option<String> {
        let sources = &self.program.sources;
        let list = enclosing_list(sources, span)?;
        let around = enclosing_list(sources, Span { start: list, end: list, ..span })?;
        let whole = &sources.get(span.source).text;
        let before = whole.get(list as usize + 1..span.start as usize)?.trim();
        let head = whole.get(around as usize + 1..list as usize)?.trim();
        let is_global = |text: &str| self.symbols.find(text).is_some_and(|name| self.program.names.contains_key(&name));
        // It is the only item of its list, and is used behind it.
        let is_parameter = || {
            let behind = whole.get(span.end as usize..).and_then(|rest| rest.strip_prefix(')'));
            let behind = behind.map(|rest| &rest[..rest.floor_char_boundary(HEAD_BYTES)]);
            behind.is_some_and(|rest| {
                rest.split(|c: char| c.is_whitespace() || "()".contains(c)).any(|word| word == text)
            })
        };
        match (head, before) {
            ("n-times", "") => Some(format!("`(dotimes ({text} COUNT) FORM...)` counts with a variable")),
            ("dolist" | "dotimes", _) if is_global(before) => {
                Some(format!("the variable comes first: `({head} ({text} {before}) FORM...)`"))
            }
            (_, "") if is_global(head) && is_parameter() => {
                Some(format!("a function is written `(lambda ({text}) FORM...)`"))
            }
            _ => None,
        }
    }

    /// Advice that the place of a name gives, in the list around it.
    pub(super) fn place_advice(&self, span: Span, text: &str) -> Option<String> {
        let sources = &self.program.sources;
        let list = enclosing_list(sources, span)?;
        let before = sources.get(span.source).text.get(list as usize + 1..span.start as usize)?;
        // The name stands directly behind the head.
        let head = before.strip_suffix(char::is_whitespace).unwrap_or(before).trim();
        match head {
            "with-valve" | "request-valve" | "release-valve" | "with-valves" => {
                Some(format!("define it: `(def-valve {text})`"))
            }
            "incf" | "decf" => Some(format!("define it first: `(defvar {text} 0)`")),
            "setq" | "setf" | "pop" => {
                Some(format!("define it first: `(defvar {text} nil)`, or bind it: `(let (({text} nil)) …)`"))
            }
            "value" | "wait-for" | "whenever" | "pulse" => {
                let robots = self.robots_own(text).map(|near| format!("did you mean `{near}`?"));
                let missing = text.ends_with('*').then(|| {
                    "the robot has no such fluent; at the prompt `:fluents *` lists those that it has".to_string()
                });
                robots.or(missing).or_else(|| Some(format!("define it: `(def-fluent {text} nil)`")))
            }
            "evaporate" | "suspend" | "with-task-suspended" | "status" | "begin-task" | "end-task" => {
                Some(format!("no tag around it is called `{text}`: `(:tag {text} FORM...)` gives a task one"))
            }
            _ => self.robots_own(text).map(|near| format!("did you mean `{near}`?")),
        }
    }

    /// A fluent of the robot that is called by a word of the name: `battery*` for `battery-level`.
    fn robots_own(&self, text: &str) -> Option<String> {
        let words = text.trim_end_matches('*').split('-').filter(|word| word.len() > 2);
        let fluents = words.map(|word| format!("{word}*"));
        fluents.into_iter().find(|fluent| {
            let is_global = self.symbols.find(fluent).is_some_and(|name| self.program.names.contains_key(&name));
            fluent != text && (is_global || self.robot_names.contains(fluent))
        })
    }

    /// The list around an unknown name, by where it begins: of a list that was told of as foreign nothing more is said.
    pub(super) fn list_around(&self, span: Span) -> Option<(u32, u32)> {
        let list = enclosing_list(&self.program.sources, span)?;
        (span.start.saturating_sub(list) as usize <= HEAD_BYTES).then_some((span.source.0, list))
    }

    /// Advice on a form that is not of the form it should be.
    pub(super) fn shape_advice(&self, span: Span, form: &str) -> Option<String> {
        let is_binding = form.starts_with("`(NAME VALUE");
        if let Some(infix) = infix_in(&self.program.sources, span, if is_binding { 1 } else { 2 }) {
            return Some(match infix.operator == "=" && form.contains("VALUE") {
                true => "leave out the `=`".to_string(),
                false => infix.advice(),
            });
        }
        let text = beginning(&self.program.sources, span);
        let advice = match form {
            _ if form.starts_with("`(if ") && text.split_whitespace().any(|word| word == "else") => {
                "`if` has no word `else`: the third part is what is done otherwise"
            }
            _ if form.starts_with("`(if ") => {
                "`(seq FORM...)` makes one form of several, and `cond` has several branches"
            }
            _ if form.starts_with("`(retry)`") && text.starts_with("(retry ") => {
                "so many times: `(with-retry-counters ((tries 3)) (with-failure-handling ((CLASS (f) (do-retry tries (retry)) (refail))) FORM...))`"
            }
            _ if is_binding => "the bindings stand in a list of their own: `((NAME VALUE) (NAME VALUE))`",
            _ if form.starts_with("`(let ((") => {
                let behind = text.split_once(char::is_whitespace)?.1.trim_start();
                if !behind.starts_with(|c: char| c.is_alphabetic()) {
                    return None;
                }
                let name = behind.split(|c: char| c.is_whitespace() || c == '(').next()?;
                return Some(format!(
                    "the bindings come first; a loop that calls itself is `(labels (({name} (PARAMETER...) FORM...)) ({name} VALUE...))`"
                ));
            }
            _ => return listless_option(text, form),
        };
        Some(advice.to_string())
    }
}

/// Advice on an option that takes a list and was given one of its items.
fn listless_option(text: &str, form: &str) -> Option<String> {
    let options = form.split(['(', '[', ' ']).filter(|word| word.len() > 1 && word.starts_with(':'));
    options.into_iter().find_map(|option| {
        form.contains(&format!("{option} (")).then_some(())?;
        let value = text.split_once(&format!("{option} "))?.1.trim_start();
        let item = value.split(|c: char| c.is_whitespace() || c == ')').next()?;
        let is_item = !item.is_empty() && !item.starts_with('(');
        is_item.then(|| format!("`{option}` takes a list: `{option} ({item})`"))
    })
}
