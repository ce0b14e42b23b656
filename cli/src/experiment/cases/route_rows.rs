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

/// A hundred goals from the robot's home, without learning, as the paper prints it.
const LITERAL: RouteTrial = RouteTrial {
    planner: Planner::Literal,
    is_learning: false,
    start: RouteStart::Home,
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

/// All rows; the first is what the product does.
pub static ROWS: [RouteRow; 14] = [
    row("guided, learning", LEARNING),
    row("guided", GUIDED),
    row("literal", LITERAL),
    row("literal, learning", RouteTrial { is_learning: true, ..LITERAL }),
    row("literal, from the end", RouteTrial { start: RouteStart::End, ..LITERAL }),
    row("the same, learning", RouteTrial { start: RouteStart::End, is_learning: true, ..LITERAL }),
    row("unchecked, learning", RouteTrial { planner: UNCHECKED, ..LEARNING }),
    row("from scratch", RouteTrial { planner: Planner::Map, ..LITERAL }),
    row("from anywhere", RouteTrial { start: RouteStart::Anywhere, ..LEARNING }),
    row("at most 40 cases", RouteTrial { start: RouteStart::Anywhere, cap: Some(40), goals: 200, ..LEARNING }),
    RouteRow { name: "hidden costs", trial: HIDDEN, learned_on: 100 },
    RouteRow {
        name: "hidden costs, map alone",
        trial: RouteTrial { planner: Planner::Map, ..HIDDEN },
        learned_on: 100,
    },
    RouteRow {
        name: "hidden costs, from anywhere",
        trial: RouteTrial { start: RouteStart::Anywhere, ..HIDDEN },
        learned_on: 100,
    },
    RouteRow {
        name: "the same, map alone",
        trial: RouteTrial { start: RouteStart::Anywhere, planner: Planner::Map, ..HIDDEN },
        learned_on: 100,
    },
];
