//! Writing a case file.

use super::lines::{Head, Line, LineContent, LineRoute, LineStop, VERSION};
use crate::case::{Case, Content};
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::Places;
use crate::route::{Route, Stop};
use serde::Serialize;
use serde_json::Value;

/// The text of a memory, by kind and then by number. What is missing is left out.
pub fn memory_text(memory: &CaseMemory, world: &str, places: Option<&Places>) -> String {
    let mut text = line(&Head { rpl_cases: VERSION, world: world.to_string(), next: memory.next_number().0 });
    for (number, case) in memory.cases() {
        text.push_str(&line(&written(number, case, places)));
    }
    text
}

fn line(of: &impl Serialize) -> String {
    // Maps with texts for keys and finite numbers can always be written.
    let mut value = serde_json::to_value(of).unwrap_or_default();
    leave_out_missing(&mut value);
    format!("{value}\n")
}

fn leave_out_missing(value: &mut Value) {
    if let Value::Object(object) = value {
        object.retain(|_, value| !value.is_null());
        object.values_mut().for_each(leave_out_missing);
    }
}

fn written(number: CaseNumber, case: &Case, places: Option<&Places>) -> Line {
    let content = match &case.content {
        Content::Behaviour(parameters) => LineContent::Behaviour(*parameters),
        Content::Route(route) => LineContent::Route(written_route(route, places)),
        Content::Goal(goal) => LineContent::Goal(*goal),
        Content::MetaPlan(plan) => LineContent::MetaPlan(*plan),
    };
    Line { case: number.0, counts: case.counts, index: case.index.clone(), content }
}

fn written_route(route: &Route, places: Option<&Places>) -> LineRoute {
    let stop = |stop: &Stop| match (stop, places) {
        (Stop::At(point), _) => LineStop::At(*point),
        (Stop::Known(place), Some(places)) => LineStop::Known(places.name(*place).to_string()),
        // Without places there are no known ones in any route.
        (Stop::Known(place), None) => LineStop::Known(place.0.to_string()),
    };
    let is_driven = route.times_s.iter().any(Option::is_some);
    LineRoute {
        stops: route.stops.iter().map(stop).collect(),
        times_s: if is_driven { route.times_s.clone() } else { Vec::new() },
    }
}
