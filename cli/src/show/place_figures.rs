//! Drawings of known places and of routes over them.

use super::figures::{Figure, draw};
use rpl_robot::geometry::Point;
use rpl_robot::world::World;
use rpl_rupart::places::Places;
use rpl_rupart::routes::Route;

/// Edge of a cell of the map in these drawings.
const RESOLUTION_M: f64 = 0.1;

/// A building with its places and what is adjacent; the regions of influence are its rooms.
pub fn building(world: &World, places: &Places) -> String {
    let map = world.map(RESOLUTION_M);
    let title = format!("{}: places, and lines between those that see each other", world.name);
    let mut figure = Figure::of_map(&title, &map, &world.rooms);
    for from in places.ids() {
        let onward = places.stretches[from.index()].iter().filter(|stretch| from < stretch.to);
        figure
            .true_paths_in_map
            .extend(onward.map(|stretch| vec![places.at_in_map(from), places.at_in_map(stretch.to)]));
    }
    figure.dots_in_map = places.all.iter().map(|place| place.at_in_map).collect();
    draw(&figure)
}

/// A route, solid, and the case it was made from, dashed.
pub fn adaptation(title: &str, world: &World, places: &Places, case: Option<&Route>, route: &Route) -> String {
    let map = world.map(RESOLUTION_M);
    let title = format!("{title} (the case dashed)");
    let mut figure = Figure::of_map(&title, &map, &world.rooms);
    figure.true_paths_in_map.push(line(places, route));
    figure.estimated_paths_in_map.extend(case.map(|case| line(places, case)));
    figure.dots_in_map = places.all.iter().map(|place| place.at_in_map).collect();
    draw(&figure)
}

/// Routes of a memory, all in one drawing.
pub fn routes<'r>(title: &str, world: &World, places: &Places, routes: impl Iterator<Item = &'r Route>) -> String {
    let map = world.map(RESOLUTION_M);
    let mut figure = Figure::of_map(title, &map, &world.rooms);
    figure.true_paths_in_map = routes.map(|route| line(places, route)).collect();
    figure.dots_in_map = places.all.iter().map(|place| place.at_in_map).collect();
    draw(&figure)
}

fn line(places: &Places, route: &Route) -> Vec<Point> {
    route.stops.iter().map(|stop| stop.at_in_map(places)).collect()
}
