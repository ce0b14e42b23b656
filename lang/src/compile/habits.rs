//! Advice on a name that nothing defines, from how it is spelt and from where it stands: what users of other languages
//! write out of habit.

use super::compiler::Compiler;
use super::foreign;
use super::locals::Surrounding;
use crate::bars::read_name;
use crate::code::GlobalKind;
use crate::infix::{beginning, enclosing_list, infix_in};
use crate::lexer::{Token, lex};
use crate::source::Span;
use crate::symbol::Symbol;
use std::collections::BTreeSet;

/// The word that a list begins with, as far as its beginning is near.
const HEAD_BYTES: usize = 60;

/// Longer lists of names are not taken for data.
const LONGEST_LIST_BYTES: usize = 400;

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

    /// Advice on a method, `todo.append`: the name before the dot has a meaning, and functions take what they work on.
    pub(super) fn method_advice(&self, text: &str, around: Surrounding) -> Option<String> {
        let (object, method) = text.split_once('.').filter(|(_, method)| !method.is_empty())?;
        let name = self.symbols.find(object)?;
        let is_known = self.program.names.contains_key(&name) || self.locals.around(around).any(|local| local == name);
        let call = match method {
            "append" | "add" | "push" | "insert" | "push-back" => format!("(push VALUE {object})"),
            _ if self.is_called(method) => format!("({method} … {object})"),
            _ => {
                return is_known.then(|| match foreign::advice(method) {
                    Some(advice) => format!("there are no methods: {advice}"),
                    None => format!("there are no methods: a function takes what it works on, `(FUNCTION {object})`"),
                });
            }
        };
        is_known.then(|| format!("there are no methods: `{call}`"))
    }

    /// Whether a function of the text or of the library has this name.
    fn is_called(&self, text: &str) -> bool {
        let is_native = self.natives.iter().any(|native| native.name == text);
        let global = self.symbols.find(text).and_then(|name| self.program.names.get(&name));
        let is_function =
            global.is_some_and(|&global| matches!(self.program.globals[global as usize].kind, GlobalKind::Function(_)));
        is_native || is_function
    }

    /// The list that begins with an unknown name, if it stands where a value is wanted and holds nothing but names that
    /// are unknown, too, and literals: data that nobody has quoted.
    pub(super) fn unquoted_list(&self, head: Span, unknown: &BTreeSet<Symbol>) -> Option<Span> {
        let sources = &self.program.sources;
        let text = &sources.get(head.source).text;
        let start = head.start.checked_sub(1).filter(|&at| text.as_bytes()[at as usize] == b'(')?;
        let end = text.floor_char_boundary((start as usize + LONGEST_LIST_BYTES).min(text.len())) as u32;
        let (tokens, _) = lex(&text[start as usize + 1..end as usize], head.source);
        let close = tokens.iter().position(|(token, _)| *token == Token::Close)?;
        let is_unknown = |span: Span| {
            let span = Span { start: start + 1 + span.start, end: start + 1 + span.end, ..head };
            self.symbols.find(&read_name(sources.text_of(span))).is_some_and(|name| unknown.contains(&name))
        };
        let items = &tokens[..close];
        let is_data = items.iter().all(|&(token, span)| match token {
            Token::Symbol => is_unknown(span),
            Token::Int(_) | Token::Float(_) | Token::Str | Token::Keyword => true,
            _ => false,
        });
        // `(a)` and `(a 3)` are calls as well.
        let names = items.iter().filter(|(token, _)| *token == Token::Symbol).count();
        let list = Span { start, end: start + 1 + tokens[close].1.end, ..head };
        (is_data && names > 1 && self.is_value_wanted(list)).then_some(list)
    }

    /// Whether a list stands where its value is used: behind a function, or behind a name that is bound to it.
    fn is_value_wanted(&self, list: Span) -> bool {
        let sources = &self.program.sources;
        let Some(around) = enclosing_list(sources, list) else { return false };
        let before = &sources.get(list.source).text[around as usize + 1..list.start as usize];
        let mut words = before.split_whitespace();
        let Some(head) = words.next() else { return false };
        let is_form = self
            .symbols
            .find(head)
            .is_some_and(|name| self.specials.contains_key(&name) || self.program.macros.contains_key(&name));
        match head {
            "setq" | "setf" | "push" | "defvar" | "defconstant" | "def-fluent" => words.next().is_some(),
            _ => !is_form,
        }
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
