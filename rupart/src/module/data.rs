//! Routes and cases as plans have them.

use crate::case::Case;
use crate::memory::CaseNumber;
use crate::places::Places;
use crate::route::{Route, Stop};
use rpl_lang::symbol::fold_name;
use rpl_robot::geometry::Point;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;

/// A list of the names of places and of points (x y).
pub(super) fn route_data(machine: &mut Machine, route: &Route, places: &Places) -> Value {
    let stops: Vec<Value> = route.stops.iter().map(|&stop| stop_data(machine, stop, places)).collect();
    machine.heap.list(&stops)
}

fn stop_data(machine: &mut Machine, stop: Stop, places: &Places) -> Value {
    match stop {
        Stop::Known(place) => Value::Symbol(machine.symbols.intern(&fold_name(places.name(place)))),
        Stop::At(point) => machine.heap.list(&[Value::Float(point.x), Value::Float(point.y)]),
    }
}

/// The stops of such a list.
///
/// # Errors
/// It is none, it is empty, or the world has no such place.
pub(super) fn stops_of(machine: &Machine, data: Value, places: &Places) -> Result<Vec<Stop>, Raise> {
    let wrong = || {
        let found = machine.described(data);
        Raise::type_error(format!("{found} is no route; it is a list of places and points `(x y)`, at least one"))
    };
    let elements = machine.heap.elements(data).map_err(|_| wrong())?;
    if elements.is_empty() {
        return Err(wrong());
    }
    let stop = |element: Value| match element {
        Value::Symbol(symbol) => {
            let name = machine.symbols.name(symbol);
            let place = places.named(name).ok_or_else(|| {
                Raise::new("unreachable", format!("the world has no place `{name}`; `rpl worlds NAME` lists them"))
            })?;
            Ok(Stop::Known(place))
        }
        point => {
            let numbers: Option<Vec<f64>> =
                machine.heap.elements(point).map_err(|_| wrong())?.into_iter().map(Value::as_f64).collect();
            match numbers.as_deref() {
                Some(&[x, y]) if x.is_finite() && y.is_finite() => Ok(Stop::At(Point::new(x, y))),
                _ => Err(wrong()),
            }
        }
    };
    elements.into_iter().map(stop).collect()
}

/// A list (number kind used succeeded).
pub(super) fn case_data(machine: &mut Machine, number: CaseNumber, case: &Case) -> Value {
    let kind = Value::Symbol(machine.symbols.intern(case.content.kind().name()));
    let counts = [case.counts.used, case.counts.succeeded].map(|count| Value::Int(count.into()));
    machine.heap.list(&[Value::Int(number.0.into()), kind, counts[0], counts[1]])
}
