//! Drawings of a mission as SVG, readable in black and white: the map, the true and the estimated
//! path, and where the robot may be.

use crate::files::outputs::OutputFolder;
use crate::run_record::Records;
use crate::trace::TracedPose;
use anyhow::Result;
use rpl_mission::sight::{PositionBelief, Sight};
use rpl_robot::geometry::{Point, Pose};
use rpl_robot::occupancy::{Cell, OccupancyGrid};
use rpl_robot::world::{Room, World};
use std::path::Path;
use svg::Document;
use svg::node::element::{Circle, Group, Line, Polyline, Rectangle, Text};

/// Edge of a map cell in drawings of a mission.
const RESOLUTION_M: f64 = 0.1;

/// Room for the title above and the scale below.
const MARGIN_M: f64 = 1.2;

/// The drawing of the paths.
const PATHS: &str = "paths.svg";

/// The drawing of the belief at the end.
const BELIEF: &str = "belief.svg";

/// Steps of darkness of a belief: few, so that neighbouring cells make long rectangles.
const SHADES: usize = 8;

/// A robot in a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotMarker<'a> {
    /// Where.
    pub pose_in_map: Pose,
    /// Of its body.
    pub radius_m: f64,
    /// What is written beside it.
    pub label: &'a str,
    /// Whether the robot really was there; else it only believed so.
    pub is_true: bool,
}

/// What a drawing shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure<'a> {
    /// Above the drawing.
    pub title: &'a str,
    /// The map.
    pub map: &'a OccupancyGrid,
    /// Rooms whose names are written.
    pub rooms: &'a [Room],
    /// Where the robot was: solid lines.
    pub true_paths_in_map: Vec<Vec<Point>>,
    /// Where it believed it was: dashed lines.
    pub estimated_paths_in_map: Vec<Vec<Point>>,
    /// Single points.
    pub dots_in_map: Vec<Point>,
    /// Where it may be: the darker the likelier.
    pub belief: Option<&'a PositionBelief>,
    /// Robots.
    pub markers: Vec<RobotMarker<'a>>,
}

impl<'a> Figure<'a> {
    /// A map without a robot.
    pub fn of_map(title: &'a str, map: &'a OccupancyGrid, rooms: &'a [Room]) -> Self {
        Self {
            title,
            map,
            rooms,
            true_paths_in_map: Vec::new(),
            estimated_paths_in_map: Vec::new(),
            dots_in_map: Vec::new(),
            belief: None,
            markers: Vec::new(),
        }
    }

    /// Marks the robot and its estimate; two labels in one place could not be read.
    fn mark(&mut self, sight: &Sight, radius_m: f64) {
        let is_apart = sight.robot_in_map.is_none_or(|robot| robot.distance_m(sight.estimate_in_map) > 1.0);
        let label = if is_apart { "estimate" } else { "" };
        self.markers.extend(sight.robot_in_map.map(|pose_in_map| RobotMarker {
            pose_in_map,
            radius_m,
            label: "robot",
            is_true: true,
        }));
        self.markers.push(RobotMarker { pose_in_map: sight.estimate_in_map, radius_m, label, is_true: false });
    }
}

/// The folder for the drawings of a mission, tried.
///
/// # Errors
/// It cannot be written, or holds drawings that are not ours.
pub fn open_folder(path: &Path) -> Result<OutputFolder> {
    OutputFolder::open_for(path, "run", &[PATHS, BELIEF])
}

/// Writes the drawing of the paths that poses tell of.
///
/// # Errors
/// It cannot be written.
pub fn write_paths(folder: &mut OutputFolder, world: &World, robot_radius_m: f64, poses: &[TracedPose]) -> Result<()> {
    let track: Vec<Sight> = poses.iter().map(|seen| seen.sight).collect();
    let longest_us = poses.windows(2).map(|pair| pair[1].time_us - pair[0].time_us).max().unwrap_or(0);
    let jump_m = JUMP_M + MAX_SPEED_M_PER_S * longest_us as f64 / 1e6;
    folder.draw(PATHS, &draw(&paths(&world.map(RESOLUTION_M), world, robot_radius_m, &track, jump_m)))
}

/// The paths of a mission, and where its robot may be.
pub fn mission(world: &World, robot_radius_m: f64, track: &[Sight], belief: Option<&PositionBelief>) -> String {
    let map = world.map(RESOLUTION_M);
    draw(&Figure { belief, ..paths(&map, world, robot_radius_m, track, JUMP_M) })
}

/// A world without a robot.
pub fn world(world: &World) -> String {
    draw(&Figure::of_map(&world.name, &world.map(RESOLUTION_M), &world.rooms))
}

/// The true and the estimated path, which breaks where the estimate jumps further than this.
fn paths<'a>(map: &'a OccupancyGrid, world: &'a World, radius_m: f64, track: &[Sight], jump_m: f64) -> Figure<'a> {
    let truth = true_path(track);
    let title =
        if truth.is_empty() { "estimated path (dashed)" } else { "true path (solid) and estimated path (dashed)" };
    let mut figure = Figure::of_map(title, map, &world.rooms);
    figure.true_paths_in_map.push(truth);
    let estimated: Vec<Point> = track.iter().map(|sight| sight.estimate_in_map.point()).collect();
    figure.estimated_paths_in_map = without_jumps(&estimated, jump_m);
    if let (Some(first), Some(last)) = (track.first(), track.last()) {
        for (sight, label) in [(first, "start"), (last, "end")] {
            let pose_in_map = sight.robot_in_map.unwrap_or(sight.estimate_in_map);
            figure.markers.push(RobotMarker { pose_in_map, radius_m, label, is_true: sight.robot_in_map.is_some() });
        }
    }
    figure
}

/// Where the robot really was, as far as anybody knows.
fn true_path(track: &[Sight]) -> Vec<Point> {
    track.iter().filter_map(|sight| sight.robot_in_map).map(Pose::point).collect()
}

/// Writes the drawings of a mission into a folder.
///
/// # Errors
/// A drawing cannot be written.
pub fn write_mission(
    folder: &mut OutputFolder,
    world: &World,
    robot_radius_m: f64,
    records: &Records,
    belief: Option<&PositionBelief>,
) -> Result<()> {
    let track = &records.track;
    let map = world.map(RESOLUTION_M);
    folder.draw(PATHS, &draw(&paths(&map, world, robot_radius_m, track, JUMP_M)))?;
    if belief.is_some() {
        let mut figure = Figure::of_map("belief at the end, and the robot", &map, &world.rooms);
        figure.belief = belief;
        if let Some(last) = track.last() {
            figure.mark(last, robot_radius_m);
        }
        folder.draw(BELIEF, &draw(&figure))?;
    }
    for (number, scene) in records.scenes.iter().flatten().enumerate() {
        let title = format!("{:.1} s: {}, certainty {:.2}", scene.time_s, scene.what.name(), scene.sight.certainty);
        let mut figure = Figure::of_map(&title, &map, &world.rooms);
        figure.belief = Some(&scene.belief);
        let before = &track[..scene.track_length];
        figure.true_paths_in_map.push(true_path(before));
        figure.mark(&scene.sight, robot_radius_m);
        let name = format!("belief-{:02}-{}.svg", number + 1, scene.what.name().replace(' ', "-"));
        folder.draw(&name, &draw(&figure))?;
    }
    Ok(())
}

/// From the map frame to the drawing: y downwards, below the title.
#[derive(Clone, Copy)]
struct Sheet {
    left_m: f64,
    top_m: f64,
}

impl Sheet {
    fn x(self, x_in_map_m: f64) -> f64 {
        rounded(x_in_map_m - self.left_m)
    }

    fn y(self, y_in_map_m: f64) -> f64 {
        rounded(self.top_m - y_in_map_m + MARGIN_M)
    }
}

/// To the millimetre: more digits only make the file longer.
fn rounded(length_m: f64) -> f64 {
    (length_m * 1000.0).round() / 1000.0
}

/// The drawing as SVG text; one unit of its view box is a metre.
pub fn draw(figure: &Figure<'_>) -> String {
    let map = figure.map;
    let (width_m, height_m) = (map.columns as f64 * map.resolution_m, map.rows as f64 * map.resolution_m);
    let sheet = Sheet { left_m: map.origin_in_frame.x, top_m: map.origin_in_frame.y + height_m };
    let mut document = Document::new()
        .set("viewBox", (0, 0, rounded(width_m), rounded(height_m + 2.0 * MARGIN_M)))
        .set("width", format!("{:.0}", width_m * PIXELS_PER_M))
        .set("height", format!("{:.0}", (height_m + 2.0 * MARGIN_M) * PIXELS_PER_M))
        .set("font-family", "sans-serif")
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white"))
        .add(text(figure.title, rounded(width_m / 2.0), 0.75, 0.55));
    document = document.add(cells(map, sheet, Cell::Unknown, "#e4e4e4"));
    if let Some(belief) = figure.belief {
        document = document.add(shading(belief, sheet));
    }
    document = document.add(cells(map, sheet, Cell::Occupied, "black"));
    for room in figure.rooms {
        let centre = room.rect.centre();
        let name = text(&room.name, sheet.x(centre.x), sheet.y(centre.y), 0.4).set("fill", "#555");
        document = document.add(name);
    }
    for points_in_map in &figure.true_paths_in_map {
        document = document.add(path(points_in_map, sheet, "true-path"));
    }
    for points_in_map in &figure.estimated_paths_in_map {
        document = document.add(path(points_in_map, sheet, "estimated-path").set("stroke-dasharray", "0.25 0.15"));
    }
    for dot in &figure.dots_in_map {
        let dot = Circle::new().set("cx", sheet.x(dot.x)).set("cy", sheet.y(dot.y)).set("r", 0.07).set("class", "dot");
        document = document.add(dot.set("fill-opacity", 0.5));
    }
    for marker in &figure.markers {
        document = document.add(robot(marker, sheet));
    }
    document.add(scale_bar(rounded(height_m + 1.5 * MARGIN_M))).to_string()
}

const PIXELS_PER_M: f64 = 30.0;

fn text(content: &str, x_m: f64, y_m: f64, size_m: f64) -> Text {
    Text::new(content).set("x", x_m).set("y", y_m).set("font-size", size_m).set("text-anchor", "middle")
}

/// Runs of equal values in a row: first column, length, value.
fn runs<T: Copy + PartialEq>(row: impl Iterator<Item = T>) -> Vec<(usize, usize, T)> {
    let mut runs: Vec<(usize, usize, T)> = Vec::new();
    for (column, value) in row.enumerate() {
        match runs.last_mut() {
            Some((_, length, last)) if *last == value => *length += 1,
            _ => runs.push((column, 1, value)),
        }
    }
    runs
}

/// All cells of a kind.
fn cells(map: &OccupancyGrid, sheet: Sheet, kind: Cell, colour: &str) -> Group {
    let mut group = Group::new().set("fill", colour).set("shape-rendering", "crispEdges");
    for row in 0..map.rows {
        for (column, length, is_kind) in runs((0..map.columns).map(|column| map.get(column, row) == kind)) {
            if is_kind {
                group = group.add(strip(map.origin_in_frame, map.resolution_m, sheet, column, row, length));
            }
        }
    }
    group
}

/// Some neighbouring cells of a row as one rectangle.
fn strip(origin_in_map: Point, resolution_m: f64, sheet: Sheet, column: usize, row: usize, length: usize) -> Rectangle {
    Rectangle::new()
        .set("x", sheet.x(origin_in_map.x + column as f64 * resolution_m))
        .set("y", sheet.y(origin_in_map.y + (row + 1) as f64 * resolution_m))
        .set("width", rounded(length as f64 * resolution_m))
        .set("height", rounded(resolution_m))
}

/// The belief as darkness; the root of the probability, so that a flat belief is seen too.
fn shading(belief: &PositionBelief, sheet: Sheet) -> Group {
    let largest = belief.cells.iter().copied().fold(0.0, f64::max);
    let mut group = Group::new().set("fill", "black").set("shape-rendering", "crispEdges").set("class", "belief");
    if largest <= 0.0 || belief.columns == 0 {
        return group;
    }
    let shade = |probability: f64| ((probability / largest).sqrt() * SHADES as f64).round() as usize;
    for (row, cells) in belief.cells.chunks(belief.columns).enumerate() {
        for (column, length, shade) in runs(cells.iter().map(|&probability| shade(probability))) {
            if shade > 0 {
                let darkness = rounded(0.75 * shade as f64 / SHADES as f64);
                let rectangle = strip(belief.origin_in_map, belief.resolution_m, sheet, column, row, length);
                group = group.add(rectangle.set("fill-opacity", darkness));
            }
        }
    }
    group
}

/// An estimate that jumps between two looks was not driven: the line breaks there.
const JUMP_M: f64 = 0.5;

/// No estimate is driven faster.
const MAX_SPEED_M_PER_S: f64 = 2.0;

fn without_jumps(points_in_map: &[Point], jump_m: f64) -> Vec<Vec<Point>> {
    points_in_map.chunk_by(|before, after| (after - before).norm() <= jump_m).map(<[Point]>::to_vec).collect()
}

fn path(points_in_map: &[Point], sheet: Sheet, class: &str) -> Polyline {
    let points: Vec<String> =
        points_in_map.iter().map(|point| format!("{},{}", sheet.x(point.x), sheet.y(point.y))).collect();
    Polyline::new()
        .set("class", class)
        .set("fill", "none")
        .set("stroke", "black")
        .set("stroke-width", 0.07)
        .set("points", points.join(" "))
}

/// A disc of the robot's size with its heading; filled white where it really is, hollow and dashed
/// where it only believes itself to be.
fn robot(marker: &RobotMarker<'_>, sheet: Sheet) -> Group {
    let pose = marker.pose_in_map;
    let nose = pose.transform(Point::new(marker.radius_m, 0.0));
    let (x, y) = (sheet.x(pose.x_m), sheet.y(pose.y_m));
    let disc = Circle::new()
        .set("cx", x)
        .set("cy", y)
        .set("r", marker.radius_m)
        .set("fill", if marker.is_true { "white" } else { "none" });
    let disc = if marker.is_true { disc } else { disc.set("stroke-dasharray", "0.1 0.06") };
    let heading = Line::new().set("x1", x).set("y1", y).set("x2", sheet.x(nose.x)).set("y2", sheet.y(nose.y));
    let label = text(marker.label, x, rounded(y - marker.radius_m - 0.12), 0.4).set("stroke", "none");
    Group::new().set("stroke", "black").set("stroke-width", 0.06).add(disc).add(heading).add(label)
}

fn scale_bar(y_m: f64) -> Group {
    const LENGTH_M: f64 = 5.0;
    let bar = Line::new().set("x1", 0.5).set("y1", y_m).set("x2", 0.5 + LENGTH_M).set("y2", y_m);
    let label = text(&format!("{LENGTH_M} m"), 0.5 + LENGTH_M / 2.0, rounded(y_m + 0.45), 0.4).set("stroke", "none");
    Group::new().set("stroke", "black").set("stroke-width", 0.1).add(bar).add(label)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cover_a_row_once() {
        assert_eq!(runs([1, 1, 2, 1].into_iter()), [(0, 2, 1), (2, 1, 2), (3, 1, 1)]);
        assert!(runs(std::iter::empty::<u8>()).is_empty());
    }

    /// The value of an attribute in a tag of the drawing.
    fn attribute(tag: &str, name: &str) -> f64 {
        let value = tag.split(&format!(" {name}=\"")).nth(1).and_then(|rest| rest.split('"').next());
        value.and_then(|value| value.parse().ok()).unwrap_or(f64::NAN)
    }

    #[test]
    fn occupied_area_is_drawn_once_and_upright() {
        let mut map = OccupancyGrid::filled(Point::new(-1.0, 2.0), 0.5, 4, 3, Cell::Free);
        for (column, row) in [(0, 0), (1, 0), (3, 2)] {
            map.set(column, row, Cell::Occupied);
        }
        let sheet = Sheet { left_m: -1.0, top_m: 3.5 };
        let drawn = cells(&map, sheet, Cell::Occupied, "black").to_string();
        let strips: Vec<&str> = drawn.lines().filter(|line| line.starts_with("<rect")).collect();
        assert_eq!(strips.len(), 2);
        let area: f64 = strips.iter().map(|tag| attribute(tag, "width") * attribute(tag, "height")).sum();
        assert!((area - 3.0 * 0.25).abs() < 1e-9);
        // Row 0 is the lowest: on the sheet it is furthest down.
        assert_eq!(attribute(strips[0], "y"), 1.0 + MARGIN_M);
        assert_eq!(attribute(strips[1], "y"), MARGIN_M);
    }

    #[test]
    fn the_likeliest_cell_is_the_darkest() {
        let belief = PositionBelief {
            resolution_m: 1.0,
            origin_in_map: Point::origin(),
            columns: 3,
            cells: vec![0.0, 0.25, 0.75],
        };
        let drawn = shading(&belief, Sheet { left_m: 0.0, top_m: 1.0 }).to_string();
        let shades: Vec<f64> =
            drawn.lines().filter(|line| line.starts_with("<rect")).map(|tag| attribute(tag, "fill-opacity")).collect();
        assert_eq!(shades.len(), 2);
        assert!(shades[0] < shades[1] && shades[1] == 0.75);
    }

    #[test]
    fn a_world_is_drawn_with_its_names_and_paths() {
        let world = World::builtin("test-room").expect("the world is built in");
        let map = world.map(RESOLUTION_M);
        let mut figure = Figure::of_map("a <title>", &map, &world.rooms);
        figure.true_paths_in_map.push(vec![Point::new(1.0, 1.0), Point::new(2.0, 1.0)]);
        figure.markers.push(RobotMarker {
            pose_in_map: world.start_in_map,
            radius_m: 0.265,
            label: "start",
            is_true: true,
        });
        let drawn = draw(&figure);
        for part in ["a &lt;title&gt;", "west", "east", "start", "5 m", "class=\"true-path\"", "points=\"1,6.2 2,6.2\""]
        {
            assert!(drawn.contains(part), "{part} is missing");
        }
        assert_eq!(drawn, draw(&figure));
    }
}
