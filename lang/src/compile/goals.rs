//! What can be achieved: the goals that are known, found again by the names of their plans.

use crate::source::Span;
use crate::symbol::{Symbol, Symbols};
use crate::syntax::NodeId;
use std::collections::BTreeMap;

/// With the goal's name it makes the name of its plan.
pub(super) const GOAL_PREFIX: &str = "achieve-";

/// A goal with words.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GoalPattern {
    /// What stands behind its name: words, and none for a parameter.
    pub(super) elements: Vec<Option<Symbol>>,
    /// The plan that achieves it.
    pub(super) plan: Symbol,
}

/// A goal that nothing has defined where it is to be achieved.
pub(super) struct UndefinedGoal {
    pub(super) name: Symbol,
    pub(super) span: Span,
    /// Where names stand that are elements of it.
    pub(super) elements: Vec<Span>,
}

/// The goals of one name.
#[derive(Default)]
pub(super) struct Goals {
    /// Those with words, in the order of their definition.
    pub(super) patterns: Vec<GoalPattern>,
    /// Whether there is one without words.
    pub(super) has_plain: bool,
}

/// What a plan achieves, by its name: the name of the goal, and its elements if it has words.
fn achieved(plan: &str) -> Option<(&str, Option<Vec<&str>>)> {
    let goal = plan.strip_prefix(GOAL_PREFIX)?;
    match goal.strip_prefix('(').and_then(|goal| goal.strip_suffix(')')) {
        None => Some((goal, None)),
        Some(goal) => {
            let mut elements = goal.split(' ');
            Some((elements.next()?, Some(elements.collect())))
        }
    }
}

/// Adds the goal that a plan achieves, if it achieves one.
pub(super) fn note_goal(goals: &mut BTreeMap<Symbol, Goals>, symbols: &mut Symbols, plan: Symbol) {
    let name = symbols.name(plan).to_string();
    let Some((goal, elements)) = achieved(&name) else { return };
    let goals = goals.entry(symbols.intern(goal)).or_default();
    match elements {
        None => goals.has_plain = true,
        Some(elements) => {
            let word = |element: &str| (element != "?").then(|| symbols.intern(element));
            let pattern = GoalPattern { elements: elements.into_iter().map(word).collect(), plan };
            if !goals.patterns.contains(&pattern) {
                goals.patterns.push(pattern);
            }
        }
    }
}

/// The methods a goal has so far.
pub(super) struct Methods {
    /// Plans, in the order of their definition.
    pub(super) plans: Vec<Symbol>,
    /// The parameters of the first.
    pub(super) parameters: NodeId,
}
