//! Navigation plans as data: what the topological planner found, written as an RPL plan.

use super::words::mode_name;
use crate::planning::{NavigationPlan, Target};
use crate::world::TravelMode;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;

/// A way as a structured navigation plan: the target points, under a policy for
/// each kind of region on the way that sets the travel mode when the robot enters it. Without a
/// patience it is the one navigation has by itself.
pub(super) fn navigation_plan(plan: &NavigationPlan, machine: &mut Machine, patience_s: Option<f64>) -> Value {
    let mut modes: Vec<TravelMode> = Vec::new();
    for region in &plan.regions {
        if !modes.contains(&region.mode) {
            modes.push(region.mode);
        }
    }
    let targets: Vec<Value> = plan.targets.iter().map(|target| target_datum(machine, target)).collect();
    let targets = machine.heap.list(&targets);
    let quoted = form(machine, "quote", &[targets]);
    let mut key = |name| Value::Keyword(machine.symbols.intern(name));
    let mut arguments = vec![key("targets"), quoted];
    arguments.extend(patience_s.into_iter().flat_map(|patience_s| [key("patience"), Value::Float(patience_s)]));
    let navigation = symbol(machine, "navigation");
    let drive = form(machine, "run-behaviour", &[&[navigation], &arguments[..]].concat());
    if modes.is_empty() {
        return drive;
    }
    let policies: Vec<Value> = modes.into_iter().map(|mode| mode_policy(machine, mode)).collect();
    let policies = machine.heap.list(&policies);
    form(machine, "with-policies", &[policies, drive])
}

/// `(whenever (eq region* 'MODE) (set-travel-mode 'MODE))`
fn mode_policy(machine: &mut Machine, mode: TravelMode) -> Value {
    let name = symbol(machine, mode_name(mode));
    let quoted = form(machine, "quote", &[name]);
    let region = symbol(machine, "region*");
    let condition = form(machine, "eq", &[region, quoted]);
    let quoted = form(machine, "quote", &[name]);
    let action = form(machine, "set-travel-mode", &[quoted]);
    form(machine, "whenever", &[condition, action])
}

/// Coordinates to the centimetre, headings to a thousandth of a radian: more would only make the
/// printed plan hard to read.
fn target_datum(machine: &mut Machine, target: &Target) -> Value {
    let rounded = |value: f64, parts: f64| Value::Float(libm::round(value * parts) / parts);
    let mut numbers = vec![rounded(target.point_in_frame.x, 100.0), rounded(target.point_in_frame.y, 100.0)];
    numbers.extend(target.heading_rad.map(|heading_rad| rounded(heading_rad, 1000.0)));
    machine.heap.list(&numbers)
}

fn symbol(machine: &mut Machine, name: &str) -> Value {
    Value::Symbol(machine.symbols.intern(name))
}

fn form(machine: &mut Machine, head: &str, rest: &[Value]) -> Value {
    let head = symbol(machine, head);
    let tail = machine.heap.list(rest);
    machine.heap.cons(head, tail)
}
