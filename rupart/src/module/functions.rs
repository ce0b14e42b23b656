//! Its functions.

use super::data::{case_data, route_data};
use super::errand::Made;
use super::landmarks::can_look;
use super::state::{Driven, Rupart, Seen};
use crate::case::{Case, Content, Kind};
use crate::memory::CaseNumber;
use crate::places::{PlaceId, Places};
use crate::route::Stop;
use crate::routes::{Adapted, Guidance, RouteProblem, adapt_guided, learn_to_make};
use crate::situation::Situation;
use rpl_lang::symbol::fold_name;
use rpl_robot::geometry::{Point, distance_m};
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
            "&optional place",
            "Looks for the most similar case to the situation of the robot: its number, or nil if there is no case. With a place, to the situation in which it is to go there and has no route yet.",
            retrieve_case,
        ),
        look(
            "explain-case",
            "",
            "Why that case was found, as text: its distance with what each feature adds, and the runners-up.",
            explain_case,
        ),
        act(
            "adapt-route",
            "place &optional anew",
            "A route from the estimated position to a place, made of remembered ones where that is quicker than to search one, or ANEW on the map and the times that are known; where the robot was blocked on its way there, round what it has heard. A list of places and points (x y).",
            adapt_route,
        ),
        act("use-case", "case", "Drives by the parameters of the behaviour case of this number from now on.", use_case),
        act(
            "retain-case",
            "",
            "Remembers the route that `case-navigation` drove last, with the times it took, if it has steps that no other has; of a way round what blocked the robot, the one from the known place before. Where the case it was made from was no good, it remembers that the route is to be made anew there. The value is the number of the new route case, or nil.",
            retain_case,
        ),
        act("forget-case", "case", "Forgets the case of this number; whether there was one.", forget_case),
        look("cases", "", "All cases, as lists (number kind used succeeded).", cases),
        look(
            "landmarks",
            "",
            "The names of the landmarks that the robot can localize by: those of the world, or nil if it has no camera to see them with or no map that shows them.",
            landmarks,
        ),
    ]
}

fn retrieve_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let goal_in_map = match call.argument(0) {
        Value::Nil => None,
        _ => Some(place(call)?.1),
    };
    retrieve(call, &[], |rupart, seen| match goal_in_map {
        Some(goal_in_map) => Situation { long_term_goal_in_map: Some(goal_in_map), ..rupart.situation(seen) },
        None => rupart.situation_on_the_way(seen),
    })
}

/// The number of the most similar case to a situation, others left out.
pub(super) fn retrieve(
    call: &mut Call<'_, '_>,
    others: &[CaseNumber],
    asked: impl FnOnce(&Rupart, &Seen) -> Situation,
) -> Result<Reply, Raise> {
    let model = model(call)?;
    let board = board(call)?;
    let seen = Seen::of(&model, &board.position, board.percept.as_ref());
    let rupart = call.part::<Rupart>()?;
    let asked = asked(rupart, &seen);
    rupart.retrieval = match others {
        [] => rupart.memory.retrieve(&asked),
        others => rupart.memory.without(others).retrieve(&asked),
    };
    rupart.has_news = true;
    let found = rupart.retrieval.as_ref().map(|retrieval| retrieval.best.number);
    Ok(Reply::Value(found.map_or(Value::Nil, |number| Value::Int(number.0.into()))))
}

/// The known place that the first argument names, and where it is.
pub(super) fn place(call: &mut Call<'_, '_>) -> Result<(PlaceId, Point), Raise> {
    let model = model(call)?;
    let name = call.name(0)?;
    let places = call.part::<Rupart>()?.places(&model)?;
    let place = places.named(&name).ok_or_else(|| no_place(&model.world.place(&name)))?;
    Ok((place, places.at_in_map(place)))
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
    let (goal, goal_in_map) = place(call)?;
    let is_anew = call.argument(1) != Value::Nil;
    let here = board(call)?.position.estimate(model.map.as_ref()).pose_in_map.point();
    let rupart = call.part::<Rupart>()?;
    let places = rupart.places(&model)?;
    if let Some(detour) = rupart.blockage.detour(here, goal).filter(|_| !is_anew) {
        let (route, to_keep) = (detour.route.clone(), detour.to_keep.clone());
        let stops = route.stops.clone();
        rupart.made = Some(Made { stops, case: None, is_repaired: false, to_keep, start_in_map: here, goal_in_map });
        return Ok(Reply::Value(route_data(call.machine, &route, &places)));
    }
    let times = rupart.times(&model, &places);
    let near = places.closest(here);
    let is_there = distance_m(places.at_in_map(near), here) < AT_PLACE_M;
    let start = if is_there { Stop::Known(near) } else { Stop::At(here) };
    let problem = RouteProblem::new(&places, &times, start, Stop::Known(goal));
    let cases = rupart.memory.routes().filter(|_| !is_anew);
    let adapted = adapt_guided(&places, &times, &problem, cases, Guidance::USUAL);
    let Adapted { route, case, is_repaired, .. } = adapted.ok_or_else(|| unreachable(&places, near, goal))?;
    let route = route.from_here();
    let stops = route.stops.clone();
    rupart.made = Some(Made { stops, case, is_repaired, to_keep: None, start_in_map: here, goal_in_map });
    Ok(Reply::Value(route_data(call.machine, &route, &places)))
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

/// The number that the first argument is, and its case.
pub(super) fn numbered(call: &mut Call<'_, '_>) -> Result<(CaseNumber, Arc<Case>), Raise> {
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
    let Some(Driven { route, made }) = rupart.driven.take() else { return Ok(Reply::Value(Value::Nil)) };
    if let Some(made) = made.as_ref().filter(|made| made.is_repaired) {
        learn_to_make(&mut rupart.memory, made.start_in_map, made.goal_in_map);
        rupart.make_room(Kind::MetaPlan, &model, &places);
    }
    let number = rupart.keep(&model, &places, route, made.and_then(|made| made.to_keep));
    Ok(Reply::Value(number.map_or(Value::Nil, |number| Value::Int(number.0.into()))))
}

fn forget_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let number = u32::try_from(call.integer(0)?).ok().map(CaseNumber);
    let rupart = call.part::<Rupart>()?;
    rupart.has_news = true;
    Ok(Reply::Value(Value::truth(number.is_some_and(|number| rupart.memory.forget(number)))))
}

fn cases(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let all: Vec<(CaseNumber, Arc<Case>)> =
        call.part::<Rupart>()?.memory.cases().map(|(number, case)| (number, case.clone())).collect();
    call.burn(all.len());
    let data: Vec<Value> = all.iter().map(|(number, case)| case_data(call.machine, *number, case)).collect();
    Ok(Reply::Value(call.machine.heap.list(&data)))
}

fn landmarks(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let model = model(call)?;
    let known = if can_look(&model).is_ok() { model.world.landmarks.as_slice() } else { &[] };
    let names: Vec<Value> =
        known.iter().map(|one| Value::Symbol(call.machine.symbols.intern(&fold_name(&one.name)))).collect();
    Ok(Reply::Value(call.machine.heap.list(&names)))
}
