//! What is asked of routes, row by row.

use rpl_rupart::routes::Guidance;
use rpl_rupart::trial::{Planner, RouteStart, RouteTrial};

/// A row: what is asked for, and of which goals the figures are.
pub struct RouteRow {
    /// What it is called.
    pub name: &'static str,
    /// What is asked for.
    pub trial: RouteTrial,
    /// Goals before which nothing counts: the memory learns.
    pub learned_on: usize,
}

/// A hundred goals from an end of the building, without learning, as the paper prints it.
///
/// The paper's robot begins in its home lab, from which it comes to "locations halfway across the length of its domain",
/// and to others that are further away: so that lab is at an end. The home lab of `olin-rice` is in the middle.
const LITERAL: RouteTrial = RouteTrial {
    planner: Planner::Literal,
    is_learning: false,
    start: RouteStart::End,
    cap: None,
    is_slow: false,
    goals: 100,
};

const GUIDANCE: Guidance = Guidance::USUAL;

const GUIDED: RouteTrial = RouteTrial { planner: Planner::Guided(GUIDANCE), ..LITERAL };

const LEARNING: RouteTrial = RouteTrial { is_learning: true, ..GUIDED };

const UNCHECKED: Planner = Planner::Guided(Guidance { poor: f64::INFINITY, ..GUIDANCE });

const HIDDEN: RouteTrial = RouteTrial { is_slow: true, goals: 200, ..LEARNING };

const fn row(name: &'static str, trial: RouteTrial) -> RouteRow {
    RouteRow { name, trial, learned_on: 0 }
}

/// The same from the robot's home.
const fn from_home(name: &'static str, trial: RouteTrial) -> RouteRow {
    row(name, RouteTrial { start: RouteStart::Home, ..trial })
}

/// Where the map says too little: what counts are the goals after those the memory has learned on.
const fn hidden(name: &'static str, trial: RouteTrial) -> RouteRow {
    RouteRow { name, trial, learned_on: 100 }
}

/// All rows; the first is what the product does.
pub static ROWS: [RouteRow; 15] = [
    row("guided, learning", LEARNING),
    row("guided", GUIDED),
    row("literal", LITERAL),
    row("literal, learning", RouteTrial { is_learning: true, ..LITERAL }),
    row("unchecked, learning", RouteTrial { planner: UNCHECKED, ..LEARNING }),
    row("from scratch", RouteTrial { planner: Planner::Map, ..LITERAL }),
    from_home("guided, learning, from home", LEARNING),
    from_home("literal, from home", LITERAL),
    from_home("literal, learning, from home", RouteTrial { is_learning: true, ..LITERAL }),
    row("from anywhere", RouteTrial { start: RouteStart::Anywhere, ..LEARNING }),
    row("at most 40 cases", RouteTrial { start: RouteStart::Anywhere, cap: Some(40), goals: 200, ..LEARNING }),
    hidden("hidden costs", HIDDEN),
    hidden("hidden costs, map alone", RouteTrial { planner: Planner::Map, ..HIDDEN }),
    hidden("hidden costs, from anywhere", RouteTrial { start: RouteStart::Anywhere, ..HIDDEN }),
    hidden("the same, map alone", RouteTrial { start: RouteStart::Anywhere, planner: Planner::Map, ..HIDDEN }),
];
