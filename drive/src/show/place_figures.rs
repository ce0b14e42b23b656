//! Drawings of known places and of routes over them.

use rpl_drawing::{Dots, Figure, FloorPlan, Mark, MarkKind, TrackKind};
use rpl_robot::geometry::Point;
use rpl_robot::world::World;
use rpl_rupart::places::Places;
use rpl_rupart::route::{Route, Stop};

/// A building with its places, what is adjacent, and the landmarks; the regions of influence are its rooms.
pub fn building(world: &World, places: &Places) -> String {
    let mut figure = with_places(format!("{}: places of the memory", world.name), world, places);
    figure.subtitle = "a room is the region of influence of the places in it".to_string();
    let links = places.ids().flat_map(|from| {
        let onward = places.stretches[from.index()].iter().filter(move |stretch| from < stretch.to);
        onward.map(move |stretch| vec![places.at_in_map(from), places.at_in_map(stretch.to)])
    });
    figure.track(TrackKind::Link, "see each other", links.collect());
    let landmark = |pose_in_map| Mark { kind: MarkKind::Landmark, pose_in_map, radius_m: 0.0, label: String::new() };
    figure.marks = world.landmarks.iter().map(|one| landmark(one.pose_in_map)).collect();
    figure.draw()
}

/// A route, and the case it was made from: what was kept of it, and what is new.
pub fn adaptation(title: &str, world: &World, places: &Places, case: Option<&Route>, route: &Route) -> String {
    let mut figure = with_places(title, world, places);
    let of_case = |step: &[Stop]| case.is_some_and(|case| Route::new(step.to_vec()).steps_beyond(case) == 0);
    let (kept, new) = route.stops.windows(2).partition::<Vec<&[Stop]>, _>(|step| of_case(step));
    let lines = |steps: Vec<&[Stop]>| steps.into_iter().map(|step| line(places, step)).collect();
    figure.track(TrackKind::Estimate, "retrieved", case.map(|case| line(places, &case.stops)).into_iter().collect());
    figure.track(TrackKind::Truth, "kept of it", lines(kept));
    figure.track(TrackKind::Plan, "generated", lines(new));
    figure.draw()
}

/// Routes of a memory, all in one drawing.
pub fn routes<'r>(title: &str, world: &World, places: &Places, routes: impl Iterator<Item = &'r Route>) -> String {
    let mut figure = with_places(title, world, places);
    figure.track(TrackKind::Truth, "route", routes.map(|route| line(places, &route.stops)).collect());
    figure.draw()
}

fn with_places(title: impl Into<String>, world: &World, places: &Places) -> Figure<'static> {
    let plan = FloorPlan::of_world(world).naming(|_| true);
    let points_in_map = places.all.iter().map(|place| place.at_in_map).collect();
    let mut figure = Figure::new(title, plan);
    figure.dots = vec![Dots { means: "place of the memory".to_string(), points_in_map }];
    figure
}

fn line(places: &Places, stops: &[Stop]) -> Vec<Point> {
    stops.iter().map(|stop| stop.at_in_map(places)).collect()
}
