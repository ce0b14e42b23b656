//! Its functions.

use super::Rupart;
use super::data::{case_data, route_data};
use crate::case::{Case, Content, Kind};
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::{PlaceId, Places};
use crate::routes::{Guidance, Route, RouteProblem, Stop, TravelTimes, adapt_guided, learn_route, learn_times};
use rpl_robot::geometry::Velocity;
use rpl_robot::office::{act, board, look, model};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native, Reply};
use std::sync::Arc;

/// A robot this near to a place stands at it.
const AT_PLACE_M: f64 = 0.5;

/// The table.
pub(super) fn functions() -> Vec<Native> {
    vec![
        act(
            "retrieve-case",
            "",
            "Looks for the most similar case to the situation of the robot: its number, or nil if there is no case.",
            retrieve_case,
        ),
        look(
            "explain-case",
            "",
            "Why that case was found, as text: its distance with what each feature adds, and the runners-up.",
            explain_case,
        ),
        look(
            "adapt-route",
            "place",
            "A route from the estimated position to a place, made of remembered ones where that is quicker than to search one: a list of places and points (x y).",
            adapt_route,
        ),
        act("use-case", "case", "Drives by the parameters of the behaviour case of this number from now on.", use_case),
        act(
            "retain-case",
            "",
            "Remembers the route that `case-navigation` drove last, with the times it took, if it has steps that no other has. The value is the number of the new case, or nil.",
            retain_case,
        ),
        act("forget-case", "case", "Forgets the case of this number; whether there was one.", forget_case),
        look("cases", "", "All cases, as lists (number kind used succeeded).", cases),
    ]
}

fn retrieve_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let model = model(call)?;
    let board = board(call)?;
    let velocity = board
        .percept
        .as_ref()
        .map(|percept| Velocity { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps });
    let position = board.position.clone();
    let rupart = call.part::<Rupart>()?;
    let asked = rupart.situation(&model, &position, velocity);
    rupart.retrieval = rupart.memory.retrieve(&asked);
    rupart.has_news = true;
    let found = rupart.retrieval.as_ref().map(|retrieval| retrieval.best.number);
    Ok(Reply::Value(found.map_or(Value::Nil, |number| Value::Int(number.0.into()))))
}

fn explain_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let retrieval = call.part::<Rupart>()?.retrieval.clone();
    let retrieval =
        retrieval.ok_or_else(|| Raise::new("no-case", "no case was retrieved; call `retrieve-case` first"))?;
    let told: Vec<String> =
        std::iter::once(&retrieval.best).chain(&retrieval.runners_up).map(ToString::to_string).collect();
    Ok(Reply::Value(call.machine.heap.string(&told.join("\n"))))
}

fn adapt_route(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let model = model(call)?;
    let name = call.name(0)?;
    let here = board(call)?.position.estimate(model.map.as_ref()).pose_in_map.point();
    let rupart = call.part::<Rupart>()?;
    let places = rupart.places(&model)?;
    let goal = places.named(&name).ok_or_else(|| no_place(&model.world.place(&name)))?;
    let times =
        TravelTimes::of_routes(&places, model.limits.hallway_mps, routes(&rupart.memory).map(|(_, route)| route));
    let near = places.closest(here);
    let is_there = rpl_robot::geometry::distance_m(places.at_in_map(near), here) < AT_PLACE_M;
    let start = if is_there { Stop::Known(near) } else { Stop::At(here) };
    let problem = RouteProblem::new(&places, &times, start, Stop::Known(goal));
    let adapted = adapt_guided(&places, &times, &problem, routes(&rupart.memory), Guidance::USUAL);
    let adapted = adapted.ok_or_else(|| unreachable(&places, near, goal))?;
    let route = without_start(adapted.route);
    Ok(Reply::Value(route_data(call.machine, &route, &places)))
}

/// The robot is at the start of its route.
fn without_start(route: Route) -> Route {
    match route.stops.len() {
        0 | 1 => route,
        count => match route.stops[0] {
            Stop::At(_) => route.part(1, count - 1),
            Stop::Known(_) => route,
        },
    }
}

fn routes(memory: &CaseMemory) -> impl Iterator<Item = (CaseNumber, &Route)> {
    memory.cases_of(Kind::Route).filter_map(|(number, case)| match &case.content {
        Content::Route(route) => Some((number, route)),
        Content::Behaviour(_) | Content::Goal(_) | Content::MetaPlan(_) => None,
    })
}

fn no_place(found: &Result<&rpl_robot::world::Place, rpl_robot::world::UnknownName>) -> Raise {
    let message = match found {
        Err(unknown) => unknown.to_string(),
        Ok(place) => format!("no route leads to `{}`", place.name),
    };
    Raise::new("unreachable", message)
}

fn unreachable(places: &Places, from: PlaceId, to: PlaceId) -> Raise {
    let (from, to) = (places.name(from), places.name(to));
    Raise::new("unreachable", format!("no chain of places in sight of each other leads from `{from}` to `{to}`"))
}

/// The number that an argument is, and its case.
fn numbered(call: &mut Call<'_, '_>) -> Result<(CaseNumber, Arc<Case>), Raise> {
    let given = call.integer(0)?;
    let number = u32::try_from(given).ok().map(CaseNumber);
    let memory = &call.part::<Rupart>()?.memory;
    let found = number.and_then(|number| Some((number, memory.get(number)?.clone())));
    found.ok_or_else(|| Raise::new("no-case", format!("there is no case {given}; `(cases)` lists them")))
}

fn use_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (number, case) = numbered(call)?;
    let Content::Behaviour(parameters) = &case.content else {
        let kind = case.content.kind().name();
        return Err(Raise::type_error(format!(
            "`use-case` takes the number of a behaviour case, and {number} is a {kind} case"
        )));
    };
    let rupart = call.part::<Rupart>()?;
    rupart.drive.parameters = *parameters;
    rupart.used = Some(number);
    Ok(Reply::Value(Value::Nil))
}

fn retain_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let model = model(call)?;
    let rupart = call.part::<Rupart>()?;
    let places = rupart.places(&model)?;
    let Some(driven) = rupart.driven.take() else { return Ok(Reply::Value(Value::Nil)) };
    learn_times(&mut rupart.memory, &driven);
    let is_new = driven.stops.len() > 1 && routes(&rupart.memory).all(|(_, route)| driven.steps_beyond(route) > 0);
    let number = if is_new { learn_route(&mut rupart.memory, &places, driven) } else { None };
    Ok(Reply::Value(number.map_or(Value::Nil, |number| Value::Int(number.0.into()))))
}

fn forget_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let number = u32::try_from(call.integer(0)?).ok().map(CaseNumber);
    let memory = &mut call.part::<Rupart>()?.memory;
    Ok(Reply::Value(Value::truth(number.is_some_and(|number| memory.forget(number)))))
}

fn cases(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let all: Vec<(CaseNumber, Arc<Case>)> =
        call.part::<Rupart>()?.memory.cases().map(|(number, case)| (number, case.clone())).collect();
    call.burn(all.len());
    let data: Vec<Value> = all.iter().map(|(number, case)| case_data(call.machine, *number, case)).collect();
    Ok(Reply::Value(call.machine.heap.list(&data)))
}
