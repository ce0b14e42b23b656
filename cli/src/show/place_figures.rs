//! Drawings of known places and of routes over them.

use crate::drawing::{Dots, Figure, FloorPlan, TrackKind};
use rpl_robot::geometry::Point;
use rpl_robot::world::World;
use rpl_rupart::places::Places;
use rpl_rupart::routes::Route;

/// A building with its places and what is adjacent; the regions of influence are its rooms.
pub fn building(world: &World, places: &Places) -> String {
    let mut figure = with_places(format!("{}: places of the memory", world.name), world, places);
    let links = places.ids().flat_map(|from| {
        let onward = places.stretches[from.index()].iter().filter(move |stretch| from < stretch.to);
        onward.map(move |stretch| vec![places.at_in_map(from), places.at_in_map(stretch.to)])
    });
    figure.track(TrackKind::Link, "see each other", links.collect());
    figure.draw()
}

/// A route, and the case it was made from.
pub fn adaptation(title: &str, world: &World, places: &Places, case: Option<&Route>, route: &Route) -> String {
    let mut figure = with_places(title, world, places);
    figure.track(TrackKind::Estimate, "case", case.map(|case| line(places, case)).into_iter().collect());
    figure.track(TrackKind::Truth, "route", vec![line(places, route)]);
    figure.draw()
}

/// Routes of a memory, all in one drawing.
pub fn routes<'r>(title: &str, world: &World, places: &Places, routes: impl Iterator<Item = &'r Route>) -> String {
    let mut figure = with_places(title, world, places);
    figure.track(TrackKind::Truth, "route", routes.map(|route| line(places, route)).collect());
    figure.draw()
}

fn with_places(title: impl Into<String>, world: &World, places: &Places) -> Figure<'static> {
    let plan = FloorPlan::of_world(world).naming(|_| true);
    let points_in_map = places.all.iter().map(|place| place.at_in_map).collect();
    let mut figure = Figure::new(title, plan);
    figure.dots = vec![Dots { means: "place of the memory".to_string(), points_in_map }];
    figure
}

fn line(places: &Places, route: &Route) -> Vec<Point> {
    route.stops.iter().map(|stop| stop.at_in_map(places)).collect()
}
