//! Its functions about what to do next: goals, which wait to be gone to, and meta-plans.

use super::functions::{numbered, place, retrieve};
use super::state::Rupart;
use crate::case::{Case, Content, Goal, Kind};
use crate::forgetting::Capacity;
use crate::memory::CaseNumber;
use crate::situation::Situation;
use rpl_lang::symbol::fold_name;
use rpl_robot::office::{act, look, model};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native, Reply};

/// How important a goal is, if nothing else is said.
const USUAL_PRIORITY: f64 = 0.5;

/// The table.
pub(super) fn functions() -> Vec<Native> {
    vec![
        act(
            "retain-goal",
            "place &optional priority deadline",
            "Remembers that the robot is to go to a place: how important that is, from 0 to 1, without 0.5, and by what time of the plan. The value is the number of the new case. Fails with too-many-goals if a thousand wait.",
            retain_goal,
        ),
        act(
            "retrieve-next-case",
            "&optional list",
            "Looks for what to do next, whatever the robot is driving to: the most similar case to a situation of the highest priority at this time and place, of all but those whose numbers are in LIST. Its number, or nil if there is no case.",
            retrieve_next_case,
        ),
        look(
            "retrieved-case",
            "kind",
            "The number of the most similar case of a kind among those that were retrieved last, the runners-up included, or nil.",
            retrieved_case,
        ),
        look(
            "case-goal",
            "case",
            "The place that a goal case is about, or nil if the case of this number is no goal.",
            case_goal,
        ),
        look(
            "case-plan",
            "case",
            "What a meta-plan says is to be done first: make-route, train-behaviour or localize-first; nil if the case of this number is no meta-plan.",
            case_plan,
        ),
        act("note-case", "case value", "Notes a use of a case, and whether it has led to the goal.", note_case),
    ]
}

fn retain_goal(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (_, place_in_map) = place(call)?;
    let priority = match call.argument(1) {
        Value::Nil => USUAL_PRIORITY,
        _ => call.number(1)?,
    };
    let time_s = match call.argument(2) {
        Value::Nil => None,
        _ => Some(call.number(2)?),
    };
    if !(0.0..=1.0).contains(&priority) || time_s.is_some_and(|time_s| !time_s.is_finite()) {
        let message = "a goal has a priority from 0 to 1 and a deadline in seconds, as `(retain-goal 'lab 0.8 10min)`";
        return Err(Raise::type_error(message.to_string()));
    }
    let index =
        Situation { place_in_map: Some(place_in_map), priority: Some(priority), time_s, ..Situation::default() };
    let rupart = call.part::<Rupart>()?;
    let most = Capacity::USUAL.goals;
    if rupart.memory.count(Kind::Goal) >= most {
        let message =
            format!("{most} goals wait already; reach some by `(reach-goals)`, or forget one by `forget-case`");
        return Err(Raise::new("too-many-goals", message));
    }
    let number = rupart.memory.retain(Case::new(index, Content::Goal(Goal { place_in_map })));
    rupart.has_news = true;
    Ok(Reply::Value(Value::Int(number.0.into())))
}

fn retrieve_next_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let now_s = call.machine.now_s();
    let others = case_numbers(call)?;
    retrieve(call, &others, |rupart, seen| Situation {
        priority: Some(1.0),
        time_s: Some(now_s),
        ..rupart.situation(seen)
    })
}

/// The numbers of cases in the list that the first argument is, those of forgotten ones included.
fn case_numbers(call: &mut Call<'_, '_>) -> Result<Vec<CaseNumber>, Raise> {
    let wrong =
        |found: String| Raise::type_error(format!("{found} is no list of numbers of cases; `(cases)` lists them"));
    let data = call.argument(0);
    let elements = call.machine.heap.elements(data).map_err(|_| wrong(call.machine.described(data)))?;
    call.burn(elements.len());
    let number = |&element: &Value| match element {
        Value::Int(number) => u32::try_from(number).ok().map(CaseNumber),
        _ => None,
    };
    let numbers: Option<Vec<CaseNumber>> = elements.iter().map(number).collect();
    numbers.ok_or_else(|| wrong(call.machine.described(data)))
}

fn retrieved_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let name = call.name(0)?;
    let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
        let kinds = Kind::ALL.map(Kind::name).join(", ");
        Raise::type_error(format!("`{name}` is no kind of case; there are {kinds}"))
    })?;
    let retrieval = call.part::<Rupart>()?.retrieval.as_ref();
    let mut found = retrieval.into_iter().flat_map(|found| std::iter::once(&found.best).chain(&found.runners_up));
    let number = found.find(|found| found.kind == kind).map(|found| found.number);
    Ok(Reply::Value(number.map_or(Value::Nil, |number| Value::Int(number.0.into()))))
}

fn case_goal(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let model = model(call)?;
    let (_, case) = numbered(call)?;
    let Content::Goal(goal) = &case.content else { return Ok(Reply::Value(Value::Nil)) };
    let places = call.part::<Rupart>()?.places(&model)?;
    let name = fold_name(places.name(places.closest(goal.place_in_map)));
    Ok(Reply::Value(Value::Symbol(call.machine.symbols.intern(&name))))
}

fn case_plan(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (_, case) = numbered(call)?;
    let Content::MetaPlan(plan) = &case.content else { return Ok(Reply::Value(Value::Nil)) };
    Ok(Reply::Value(Value::Symbol(call.machine.symbols.intern(plan.name()))))
}

fn note_case(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (number, _) = numbered(call)?;
    let succeeded = call.argument(1) != Value::Nil;
    call.part::<Rupart>()?.memory.change(number, |case| case.counts.note(succeeded));
    Ok(Reply::Value(Value::Nil))
}
