//! The names the robot brings, all taken from where they are defined.

use super::composition::Composition;
use super::module::Module;
use super::scenario::{oracle_natives, oracle_tables};
use rpl_lang::lexer::{Token, lex};
use rpl_lang::source::SourceId;

impl<M: Module> Composition<M> {
    /// Names the robot itself goes by, so that no plan may give them another meaning; its plans and
    /// functions are a library like any other.
    pub fn reserved_names(&self) -> Vec<String> {
        self.tables.names().map(str::to_string).collect()
    }

    /// Names that exist only with a robot: a plan without one is told that it needs a world.
    pub fn robot_names(&self) -> Vec<String> {
        let functions = self.functions.iter().map(|function| function.name.to_string());
        let plans = self.plans.iter().flat_map(|plan| definitions(&plan.text));
        self.reserved_names().into_iter().chain(functions).chain(plans).collect()
    }
}

/// Names that only a scenario has.
pub fn scenario_names() -> Vec<String> {
    let natives = oracle_natives().into_iter().map(|native| native.name.to_string());
    oracle_tables().names().map(str::to_string).chain(natives).collect()
}

/// What the forms of a text define: the second word of each. It is not read, so that a plan without a robot does not
/// wait for the robot's plans.
fn definitions(text: &str) -> Vec<String> {
    let (tokens, _) = lex(text, SourceId(0));
    let (mut depth, mut items, mut names) = (0usize, 0, Vec::new());
    for (token, span) in tokens.into_iter().filter(|(token, _)| !token.is_comment()) {
        if token == Token::Close {
            depth = depth.saturating_sub(1);
            continue;
        }
        items = if depth == 0 { 0 } else { items + usize::from(depth == 1) };
        if depth == 1 && items == 2 && token == Token::Symbol {
            names.push(text[span.start as usize..span.end as usize].to_string());
        }
        depth += usize::from(token == Token::Open);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::office::behaviours::office_modules;
    use std::collections::BTreeSet;

    #[test]
    fn no_name_is_given_twice() {
        for names in [office_modules().robot_names(), scenario_names()] {
            let once: BTreeSet<&String> = names.iter().collect();
            assert_eq!(once.len(), names.len(), "{names:?}");
        }
    }

    #[test]
    fn a_form_defines_its_second_word() {
        let text =
            "; (def-plan no ())\n(def-plan yes (a b) (c \"(d e)\"))\n(defstruct (none :of) it) 'this (defvar that 1)";
        assert_eq!(definitions(text), ["yes", "that"]);
    }

    #[test]
    fn the_names_are_those_of_tables_functions_and_plans() {
        let names = office_modules().robot_names();
        for name in ["navigation", "wheels", "x*", "belief-maxima", "go-to", "is-spot-at?"] {
            assert!(names.iter().any(|known| known == name), "{name}");
        }
        assert!(office_modules().reserved_names().iter().all(|name| names.contains(name)));
        assert!(!office_modules().reserved_names().iter().any(|name| name == "go-to"), "a plan may define its own");
    }
}
