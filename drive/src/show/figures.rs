//! Drawings of a mission: the map, the true and the estimated path, where the robot may be, and what it chose.

use crate::observed::{BeliefScene, Observed};
use crate::show::choice_figures;
use crate::trace::TracedPose;
use anyhow::Result;
use rpl_drawing::{Figure, FloorPlan, Mark, MarkKind, TrackKind};
use rpl_mission::sight::{PositionBelief, Sight};
use rpl_robot::active::{ActionField, Choice};
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::localization::Maximum;
use rpl_robot::simulator::PERSON_RADIUS_M;
use rpl_robot::world::World;
use rpl_shell::files::outputs::OutputFolder;
use std::path::Path;

/// The drawing of the paths.
const PATHS: &str = "paths.svg";

/// The drawing of the belief at the end.
const BELIEF: &str = "belief.svg";

/// Where the true path is drawn.
const TRUE_PATH: &str = "where it was";

/// Where the estimated path is drawn.
const ESTIMATED_PATH: &str = "where it believed it was";

/// An estimate that jumps between two looks was not driven: the line breaks there.
const JUMP_M: f64 = 0.5;

/// No estimate is driven faster.
const MAX_SPEED_M_PER_S: f64 = 2.0;

/// Robot and estimate that are nearer than this are one mark.
const APART_M: f64 = 1.0;

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
    folder.draw(PATHS, &paths(world, robot_radius_m, &track, jump_m).draw())
}

/// The paths of a mission, and where its robot may be.
pub fn mission(world: &World, robot_radius_m: f64, track: &[Sight], belief: Option<&PositionBelief>) -> String {
    Figure { belief, ..paths(world, robot_radius_m, track, JUMP_M) }.draw()
}

/// A world as it is at the start of a run: what the robot's map shows otherwise is marked.
pub fn world(world: &World, robot_radius_m: f64) -> String {
    let mut figure = Figure::new(&world.name, FloorPlan::of_world(world));
    let shown = if world.recorded.is_some() { "the recorded map" } else { "the world as it is" };
    figure.subtitle = format!("{shown}, {:.1} m by {:.1} m", world.size_m.x, world.size_m.y);
    if world.crowd > 0 {
        figure.subtitle += &format!("; {} people more walk about, drawn from the seed", world.crowd);
    }
    let at = |point: Point| Pose::new(point.x, point.y, 0.0);
    let rounds = world.people.iter().filter(|person| person.path.len() > 1).map(|person| person.path.clone());
    figure.track(TrackKind::Round, "round of a person", rounds.collect());
    let marks = &mut figure.marks;
    marks.extend(world.landmarks.iter().map(|sheet| mark(MarkKind::Landmark, sheet.pose_in_map, 0.0, "")));
    marks.extend(world.markers.iter().map(|sheet| mark(MarkKind::Marker, at(sheet.at), 0.0, "")));
    marks.extend(world.items.iter().map(|item| mark(MarkKind::Item, at(item.at), 0.0, &item.name)));
    marks.extend(world.people.iter().map(|person| mark(MarkKind::Person, at(person.path[0]), PERSON_RADIUS_M, "")));
    marks.push(mark(MarkKind::Robot, world.start_in_map, robot_radius_m, "start"));
    figure.draw()
}

/// Writes the drawings of a mission into a folder.
///
/// # Errors
/// A drawing cannot be written.
pub(crate) fn write_mission(
    folder: &mut OutputFolder,
    world: &World,
    robot_radius_m: f64,
    observed: &Observed,
    belief: Option<&PositionBelief>,
    draws_choices: bool,
) -> Result<()> {
    let track = &observed.track;
    folder.draw(PATHS, &paths(world, robot_radius_m, track, JUMP_M).draw())?;
    if belief.is_some() {
        let mut figure = Figure::new("Where the robot may be at the end", FloorPlan::of_world(world));
        figure.subtitle = driven(world, track);
        figure.belief = belief;
        if let Some(last) = track.last() {
            figure.marks = robots(last, robot_radius_m);
        }
        folder.draw(BELIEF, &figure.draw())?;
    }
    for (number, scene) in (1..).zip(observed.scenes.iter().flatten()) {
        let name = format!("belief-{number:02}-{}.svg", scene.what.name().replace(' ', "-"));
        folder.draw(&name, &scene_figure(world, robot_radius_m, scene, &track[..scene.track_length]).draw())?;
        if let (Some((choice, field)), true) = (&scene.choice, draws_choices) {
            choice_figures::write(folder, &format!("choice-{number:02}"), choice, field)?;
        }
    }
    Ok(())
}

/// The belief at a turning point, and what was chosen there.
fn scene_figure<'a>(world: &World, radius_m: f64, scene: &'a BeliefScene, before: &[Sight]) -> Figure<'a> {
    let title = format!("{:.1} s: {}", scene.time_s, scene.what.name());
    let mut figure = Figure::new(title, FloorPlan::of_world(world));
    figure.subtitle = format!("{}, certainty {:.2}", driven(world, before), scene.sight.certainty);
    figure.belief = Some(&scene.belief);
    figure.track(TrackKind::Truth, TRUE_PATH, vec![true_path(before)]);
    figure.marks.extend(scene.maxima.iter().map(maximum));
    match &scene.choice {
        Some((choice, field)) => add_choice(&mut figure, scene, radius_m, choice, field),
        None => figure.marks.extend(robots(&scene.sight, radius_m)),
    }
    figure
}

/// A maximum with its share.
fn maximum(maximum: &Maximum) -> Mark {
    mark(MarkKind::Maximum, maximum.pose_in_map, 0.0, format!("{:.0} %", 100.0 * maximum.mass))
}

/// Target points are relative to the robot: they are drawn from where it is, or where it most likely is.
fn add_choice(figure: &mut Figure<'_>, scene: &BeliefScene, radius_m: f64, choice: &Choice, field: &ActionField) {
    let robot_in_map = scene.sight.robot_in_map.unwrap_or(scene.sight.estimate_in_map);
    let in_map = |point: Point| robot_in_map.transform(point);
    let way = std::iter::once(robot_in_map.point()).chain(choice.path_in_base.iter().map(|&point| in_map(point)));
    figure.track(TrackKind::Plan, "way to the target", vec![way.collect()]);
    // Some are seen from elsewhere the robot may be, and lie outside the building from here.
    let bounds = figure.plan.bounds;
    let others = choice_figures::alternatives(choice, field).into_iter();
    let others = others.map(|(target_in_base, less)| (in_map(target_in_base), less));
    figure.marks.extend(
        others
            .filter(|(at, _)| bounds.contains(*at))
            .map(|(at, less)| mark(MarkKind::Alternative, Pose::new(at.x, at.y, 0.0), 0.0, format!("−{less:.2}"))),
    );
    let target = in_map(choice.target_in_base);
    figure.marks.push(mark(MarkKind::Target, Pose::new(target.x, target.y, 0.0), 0.0, ""));
    let kind = if scene.sight.robot_in_map.is_some() { MarkKind::Robot } else { MarkKind::Estimate };
    figure.marks.push(mark(kind, robot_in_map, radius_m, ""));
    figure.subtitle += &format!(
        "; entropy {:.2} nats, expected at the target {:.2}, way {:.1} m",
        choice.current_entropy, choice.expected_entropy, choice.cost_m
    );
}

fn mark(kind: MarkKind, pose_in_map: Pose, radius_m: f64, label: impl Into<String>) -> Mark {
    Mark { kind, pose_in_map, radius_m, label: label.into() }
}

/// The robot, and its estimate if that is elsewhere.
fn robots(sight: &Sight, radius_m: f64) -> Vec<Mark> {
    let is_apart = sight.robot_in_map.is_none_or(|robot| robot.distance_m(sight.estimate_in_map) > APART_M);
    let estimate = is_apart.then(|| mark(MarkKind::Estimate, sight.estimate_in_map, radius_m, ""));
    let robot = sight.robot_in_map.map(|pose| mark(MarkKind::Robot, pose, radius_m, ""));
    estimate.into_iter().chain(robot).collect()
}

/// The world, and how far the robot went there.
fn driven(world: &World, track: &[Sight]) -> String {
    let at = |sight: &Sight| sight.robot_in_map.unwrap_or(sight.estimate_in_map).point();
    let length_m: f64 = track.windows(2).map(|pair| distance_m(at(&pair[0]), at(&pair[1]))).sum();
    format!("{}, after {length_m:.0} m", world.name)
}

/// The true and the estimated path, which breaks where the estimate jumps further than this.
fn paths(world: &World, radius_m: f64, track: &[Sight], jump_m: f64) -> Figure<'static> {
    let truth = true_path(track);
    let title = if truth.is_empty() { "Where the robot believed it was" } else { "Where the robot was" };
    let mut figure = Figure::new(title, FloorPlan::of_world(world));
    figure.subtitle = driven(world, track);
    let estimated: Vec<Point> = track.iter().map(|sight| sight.estimate_in_map.point()).collect();
    figure.track(TrackKind::Estimate, ESTIMATED_PATH, without_jumps(&estimated, jump_m));
    figure.track(TrackKind::Truth, TRUE_PATH, vec![truth]);
    if let (Some(first), Some(last)) = (track.first(), track.last()) {
        for (sight, label) in [(first, "start"), (last, "end")] {
            let (kind, pose) = match sight.robot_in_map {
                Some(pose) => (MarkKind::Robot, pose),
                None => (MarkKind::Estimate, sight.estimate_in_map),
            };
            figure.marks.push(mark(kind, pose, radius_m, label));
        }
    }
    figure
}

/// Where the robot really was, as far as anybody knows.
fn true_path(track: &[Sight]) -> Vec<Point> {
    track.iter().filter_map(|sight| sight.robot_in_map).map(Pose::point).collect()
}

fn without_jumps(points_in_map: &[Point], jump_m: f64) -> Vec<Vec<Point>> {
    points_in_map.chunk_by(|before, after| distance_m(*before, *after) <= jump_m).map(<[Point]>::to_vec).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::geometry::Vector;

    #[test]
    fn a_world_is_drawn_with_names_path_legend_and_scale() {
        let world = World::builtin("test-room").expect("the world is built in");
        let mut start_in_map = world.start_in_map;
        let track: Vec<Sight> = (0..20)
            .map(|step| {
                start_in_map.x_m += 0.05 * f64::from(step % 2);
                Sight {
                    robot_in_map: Some(start_in_map),
                    estimate_in_map: start_in_map,
                    certainty: 1.0,
                    velocity: None,
                    battery: None,
                }
            })
            .collect();
        let drawn = mission(&world, 0.265, &track, None);
        for part in [
            "\nWhere the robot was\n",
            "\nwest\n",
            "\neast\n",
            "\nstart\n",
            "\nend\n",
            "class=\"true-path\"",
            "class=\"scale\"",
            "class=\"walls\"",
            "\nwhere it believed it was\n",
            "\nwall\n",
        ] {
            assert!(drawn.contains(part), "{part} is missing in {drawn}");
        }
        assert_eq!(drawn, mission(&world, 0.265, &track, None));
    }

    #[test]
    fn a_world_is_drawn_as_it_is_with_what_the_map_shows_otherwise() {
        let text = "name = \"w\"\nsize = [8.0, 5.0]\nstart = [1.0, 1.0, 0]\n\
                    [[wall]]\nline = [[0, 3], [8, 3]]\nthickness = 0.2\n\
                    [[room]]\nname = \"r\"\nrect = [0, 3.1, 4, 5]\n\
                    [[door]]\nroom = \"r\"\nat = [1, 3]\nwidth = 1\naxis = \"x\"\nopen = false\nmapped_open = true\n\
                    [[door]]\nroom = \"r\"\nat = [3, 3]\nwidth = 1\naxis = \"x\"\nopen = true\nmapped_open = false\n\
                    [[object]]\nname = \"box\"\nrect = [2, 0.5, 2.4, 0.9]\nmapped = false\n\
                    [[person]]\npath = [[5, 0.5], [5, 2]]\nspeed = 1\n\
                    [[marker]]\nat = [3.5, 1.5]\ncolour = \"green\"\n\
                    [[item]]\nname = \"parcel\"\nat = [7, 1]\n\
                    [[place]]\nname = \"dock\"\npose = [6.5, 2.2, 0]\ncharges = true\n";
        let drawn = world(&World::parse(text, "w.toml").expect("no faults"), 0.265);
        for part in [
            "the world as it is, 8.0 m by 5.0 m",
            "open, but closed in the robot",
            "closed, but open in the robot",
            "furniture not in the robot",
            "place where the robot is charged",
            "round of a person",
            "person, where the round begins",
            "marker on the floor",
            "thing that can be carried",
            "\nparcel\n",
            "\ndock\n",
            "\nstart\n",
        ] {
            assert!(drawn.contains(part), "{part} is missing in {drawn}");
        }
        assert!(!world(&World::builtin("test-room").expect("it is built in"), 0.265).contains("person"));
    }

    #[test]
    fn a_jump_of_the_estimate_is_no_line() {
        let point = Point::origin();
        let points = [point, point + Vector::new(0.4, 0.0), point + Vector::new(4.0, 0.0)];
        assert_eq!(without_jumps(&points, JUMP_M).iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
    }
}
