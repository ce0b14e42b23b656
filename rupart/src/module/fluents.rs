//! Its fluents.

use super::errand::Errand;
use super::state::Rupart;
use crate::case::Kind;
use rpl_lang::symbol::fold_name;
use rpl_robot::office::{OfficeModel, Telling, fluent, fluent_number};
use rpl_runtime::robot::FluentSpec;
use rpl_runtime::robot::reading::{Reading, ReadingList};

/// What it tells plans.
pub(super) const FLUENTS: &[FluentSpec] = &[
    fluent("case*", "The number of the case that was retrieved last, or nil."),
    fluent("case-kind*", "Its kind: behaviour, route, goal or meta-plan; or nil."),
    fluent("case-distance*", "How far from the situation it was, or nil."),
    fluent("short-term-goal*", "The place, or the point (x y), that case-navigation is driving to, or nil."),
    fluent(
        "progressing?*",
        "Whether case-navigation got nearer to its short-term goal in the last seconds; nil while it does not drive.",
    ),
    fluent("goals*", "How many goals are remembered, to be gone to."),
    fluent("landmark*", "The landmark that the camera has in view, as far as the robot knows which it is, or nil."),
];

const CASE: usize = fluent_number(FLUENTS, "case*");
const CASE_KIND: usize = fluent_number(FLUENTS, "case-kind*");
const CASE_DISTANCE: usize = fluent_number(FLUENTS, "case-distance*");
const SHORT_TERM_GOAL: usize = fluent_number(FLUENTS, "short-term-goal*");
const PROGRESSING: usize = fluent_number(FLUENTS, "progressing?*");

const GOALS: usize = fluent_number(FLUENTS, "goals*");
const LANDMARK: usize = fluent_number(FLUENTS, "landmark*");

const NIL: Reading = Reading::Truth(false);

impl Rupart {
    /// Tells plans how things stand.
    pub(super) fn tell(&self, model: &OfficeModel, tell: &mut Telling<'_>) {
        let found = self.retrieval.as_ref().map(|retrieval| &retrieval.best);
        tell.fluent(CASE, found.map_or(NIL, |found| Reading::Int(found.number.0.into())));
        tell.fluent(CASE_KIND, found.map_or(NIL, |found| Reading::Symbol(found.kind.name().to_string())));
        tell.fluent(CASE_DISTANCE, found.map_or(NIL, |found| Reading::Float(found.distance)));
        tell.fluent(SHORT_TERM_GOAL, self.errand.as_ref().map_or(NIL, short_term_goal));
        tell.fluent(GOALS, Reading::Int(self.memory.cases_of(Kind::Goal).count() as i64));
        tell.fluent(PROGRESSING, Reading::Truth(self.errand.is_some() && self.drive.progress.is_made()));
        let in_view = self.looking.in_view(model);
        tell.fluent(LANDMARK, in_view.map_or(NIL, |landmark| Reading::Symbol(fold_name(&landmark.name).into_owned())));
    }
}

fn short_term_goal(errand: &Errand) -> Reading {
    if let Some(name) = errand.next_name() {
        return Reading::Symbol(fold_name(name).into_owned());
    }
    let point =
        errand.underway.next_in_map().and_then(|at| ReadingList::new([at.x, at.y].map(Reading::Float).to_vec()).ok());
    point.map_or(NIL, Reading::List)
}
