//! Figures of drives along hallways, like those of the paper: the contour line with what was detected (Fig. 6),
//! and the state set as it moves along the hallway (Figs. 3 to 5).

use super::course::Course;
use rpl_drawing::palette;
use rpl_drawing::writing::{FAMILY, SMALL_PX, TEXT_PX, TITLE_PX, centred, ending, rounded, text, wrap};
use rpl_lola::feature::{Feature, Side};
use rpl_lola::instruction::Goal;
use rpl_lola::state_set::{Inference, StateSet};
use svg::Document;
use svg::node::element::{Line, Polyline, Rectangle};

/// Pixels of a metre along the hallway.
const ALONG_PX: f64 = 20.0;

/// Pixels of a metre across it.
const ACROSS_PX: f64 = 22.0;

/// Around the drawing.
const LEFT_PX: f64 = 120.0;
const TOP_PX: f64 = 50.0;

/// A bar of something beside the hallway, and the one above it.
const BAR_PX: f64 = 12.0;
const BARS_PX: f64 = 14.0;

/// What is heard farther from the middle of the hallway is drawn at this distance.
const FARTHEST_M: f64 = 3.0;

/// The bars of what was perceived and of what is there stand beyond that.
const SEEN_M: f64 = 3.4;
const THERE_M: f64 = 4.0;

/// The lines of a legend are so far apart.
const LEGEND_PX: f64 = 20.0;

/// The name of a row in the name of a file.
pub fn file_name(row: &str) -> String {
    let words: Vec<&str> = row.split(|sign: char| !sign.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    words.join("-").to_lowercase()
}

/// A drawing of a drive: the contour lines of both sides, with what was perceived and what is there.
pub fn contour(name: &str, course: &Course) -> (String, String) {
    (format!("contour-{}.svg", file_name(name)), contour_lines(name, course))
}

fn contour_lines(name: &str, course: &Course) -> String {
    let middle_px = TOP_PX + (THERE_M + 0.5) * ACROSS_PX;
    let y = |aside_m: f64| rounded(middle_px - aside_m * ACROSS_PX);
    let height_px = 2.0 * (THERE_M + 0.5) * ACROSS_PX;
    let title = format!("contour lines of a hallway, {name}, seed {}", course.seed);
    let mut document = sheet(course.driven_m, height_px, LEGEND_PX, &title);
    for aside_m in [-2.0, -1.0, 0.0, 1.0, 2.0] {
        let line = level(x(0.0), x(course.driven_m), y(aside_m)).set("stroke", palette::GRID);
        let said = format!("{} m", aside_m.abs());
        document = document.add(line).add(ending(&said, x(0.0) - 9.0, y(aside_m) + 4.0, SMALL_PX));
    }
    let middle = level(x(0.0), x(course.driven_m), y(0.0)).set("stroke", palette::QUIET).set("stroke-dasharray", "6 4");
    document = document.add(middle);
    for side in Side::ALL {
        let points = course.contour.iter().filter(|point| point.side == side);
        let path: Vec<String> = points
            .map(|point| format!("{},{}", x(point.along_m), y(point.aside_m.clamp(-FARTHEST_M, FARTHEST_M))))
            .collect();
        document = document.add(line(&path));
        let (seen_px, there_px) = (y(side.sign() * SEEN_M), y(side.sign() * THERE_M));
        document = beside(document, course, side, course.driven_m, [seen_px, there_px]);
    }
    legend_of_features(document, TOP_PX + height_px).to_string()
}

/// What was perceived on a side, and what is there, up to a place, as bars in two lines.
fn beside(mut document: Document, course: &Course, side: Side, end_m: f64, lines_px: [f64; 2]) -> Document {
    let seen = course.percepts.iter().map(|percept| (percept.side, percept.from_m, percept.to_m, percept.seen));
    let there = course.truth.iter().map(|found| (found.side, found.from_m, found.to_m, found.is));
    let lines: [(&str, Vec<_>); 2] = [("perceived", seen.collect()), ("there", there.collect())];
    for ((what, found), middle_px) in lines.into_iter().zip(lines_px) {
        let label = format!("{}, {what}", side.in_words());
        document = document.add(ending(&label, LEFT_PX - 9.0, middle_px + 4.0, SMALL_PX));
        for (_, from_m, to_m, is) in found.into_iter().filter(|found| found.0 == side) {
            let (from_m, to_m) = (f64::max(from_m, 0.0), f64::min(to_m, end_m));
            if to_m > from_m {
                document = document.add(bar(x(from_m), x(to_m), middle_px, colour(is)));
                // The rest of a bar at the edge of the drawing has no room for it.
                if x(to_m) - x(from_m) >= BAR_PX {
                    let middle = (x(from_m) + x(to_m)) / 2.0;
                    document = document.add(centred(letter(is), middle, middle_px + 4.0, SMALL_PX));
                }
            }
        }
    }
    document
}

/// Closed door, open door, hallway, foyer.
fn letter(feature: Feature) -> &'static str {
    match feature {
        Feature::Wall => "",
        Feature::ClosedDoor => "C",
        Feature::OpenDoor => "O",
        Feature::Hallway => "H",
        Feature::Foyer => "F",
    }
}

fn colour(feature: Feature) -> &'static str {
    match feature {
        Feature::Wall => palette::PAPER,
        Feature::ClosedDoor => palette::CLOSED_DOOR,
        Feature::OpenDoor => palette::OPEN_DOOR,
        Feature::Hallway => palette::HALLWAY,
        Feature::Foyer => palette::FOYER,
    }
}

/// What the bars mean, below a drawing that ends there.
fn legend_of_features(mut document: Document, bottom_px: f64) -> Document {
    let middle_px = bottom_px + 24.0 + LEGEND_PX;
    for (feature, at) in Feature::ALL.into_iter().filter(|feature| *feature != Feature::Wall).zip(0_u8..) {
        let from_px = LEFT_PX + f64::from(at) * 110.0;
        document = document.add(bar(from_px, from_px + 20.0, middle_px - 4.0, colour(feature)));
        document = document.add(centred(letter(feature), from_px + 10.0, middle_px, SMALL_PX));
        document = document.add(text(&feature.name().replace('-', " "), from_px + 26.0, middle_px, SMALL_PX));
    }
    document
}

/// How much of the way beyond the arrival is drawn.
const BEYOND_M: f64 = 4.0;

/// The opening that is asked for in the drawing of a state set, at the most.
const DRAWN_ORDINAL: usize = 4;

/// A node of a state set is drawn so high.
const NODE_PX: f64 = 30.0;

/// A drawing of a drive whose percepts are judged so: the state set of an instruction as it moves. None if nothing can
/// be asked for.
pub fn state_set(name: &str, inference: &Inference, course: &Course) -> Option<(String, String)> {
    Some((format!("state-set-{}.svg", file_name(name)), certainties(name, inference, course)?))
}

/// What is asked for: on the left, the last of the first few openings that an instruction can lead to.
fn drawn_goal(course: &Course) -> Option<Goal> {
    let openings = course.openings(Side::Left).into_iter().take(DRAWN_ORDINAL).zip(1..);
    let goals = openings.filter(|(found, _)| matches!(found.is, Feature::Hallway | Feature::OpenDoor));
    goals.last().map(|(found, ordinal)| Goal { ordinal, side: Side::Left, kind: found.is })
}

/// Certainties of the nodes from one percept to the next.
struct Moves {
    /// From where on along the hallway they hold, and what they are.
    columns: Vec<(f64, Vec<f64>)>,
    /// Where the robot has passed the goal, as it believes.
    arrived_m: Option<f64>,
}

impl Moves {
    fn of(goal: Goal, inference: &Inference, course: &Course) -> Option<Self> {
        let mut state_set = StateSet::start(goal.instruction())?;
        let mut moves = Self { columns: vec![(0.0, state_set.certainties())], arrived_m: None };
        for percept in course.percepts.iter().filter(|percept| percept.side == goal.side) {
            state_set.progress(inference, &[*percept], &course.hidden);
            moves.columns.push((percept.to_m, state_set.certainties()));
            if state_set.arrived().is_some() {
                moves.arrived_m = Some(percept.to_m);
                break;
            }
        }
        Some(moves)
    }
}

/// Certainties of the nodes over the way: the darker the likelier.
fn certainties(name: &str, inference: &Inference, course: &Course) -> Option<String> {
    let goal = drawn_goal(course)?;
    let Moves { columns, arrived_m } = Moves::of(goal, inference, course)?;
    let end_m = arrived_m.map_or(course.driven_m, |arrived_m| (arrived_m + BEYOND_M).min(course.driven_m));
    let nodes = columns[0].1.len();
    let top_px = TOP_PX + 3.0 * BARS_PX;
    let bottom_px = top_px + NODE_PX * nodes as f64;
    let y = |node: usize| top_px + NODE_PX * (nodes - 1 - node) as f64;
    let title = format!("state set of \"{}\", {name}, seed {}", goal.instruction(), course.seed);
    let mut document = sheet(end_m, bottom_px - TOP_PX, LEGEND_PX + NODE_PX, &title);
    document = beside(document, course, goal.side, end_m, [TOP_PX + 1.5 * BARS_PX, TOP_PX + 0.5 * BARS_PX]);
    for node in 0..nodes {
        let name = node_name(node, nodes);
        document = document.add(ending(&name, LEFT_PX - 9.0, y(node) + NODE_PX / 2.0 + 4.0, SMALL_PX));
    }
    let ends = columns.iter().skip(1).map(|(from_m, _)| *from_m).chain([end_m]);
    for ((from_m, certainties), to_m) in columns.iter().zip(ends) {
        for (node, certainty) in certainties.iter().enumerate() {
            document = cell(document, x(*from_m), x(to_m), y(node), *certainty);
        }
    }
    if let Some(arrived_m) = arrived_m {
        let border = Line::new().set("x1", x(arrived_m)).set("x2", x(arrived_m)).set("y1", top_px - 10.0);
        document = document.add(border.set("y2", bottom_px).set("stroke", palette::TARGET).set("stroke-width", 2.5));
        document = document.add(text("arrived", x(arrived_m) + 5.0, top_px - 4.0, SMALL_PX));
    }
    document = legend_of_features(document, bottom_px);
    let legend_px = bottom_px + 34.0 + 2.0 * LEGEND_PX;
    document = document.add(ending("certainty", LEFT_PX - 9.0, legend_px, SMALL_PX));
    for at in 0_u8..=4 {
        let from_px = LEFT_PX + f64::from(at) * 50.0;
        document = cell(document, from_px, from_px + 50.0, legend_px - 4.0 - NODE_PX / 2.0, f64::from(at) / 4.0);
    }
    Some(document.to_string())
}

/// A certainty as a box, which says what it is if there is room for it.
fn cell(document: Document, from_px: f64, to_px: f64, top_px: f64, certainty: f64) -> Document {
    // The sum of no certainties is −0.
    let certainty = certainty.abs();
    let width_px = (to_px - from_px).max(0.0);
    let shade = Rectangle::new().set("x", from_px).set("y", top_px).set("width", rounded(width_px));
    let shade = shade.set("height", NODE_PX).set("fill", palette::shade(certainty));
    let document = document.add(shade.set("stroke", palette::GRID).set("stroke-width", 0.5));
    if width_px < 26.0 {
        return document;
    }
    let ink = if certainty > 0.5 { palette::PAPER } else { palette::INK };
    let middle_px = (from_px + to_px) / 2.0;
    let said = centred(&format!("{certainty:.2}"), middle_px, top_px + NODE_PX / 2.0 + 4.0, SMALL_PX);
    document.add(said.set("fill", ink))
}

fn node_name(node: usize, nodes: usize) -> String {
    match nodes - node {
        1 => "beyond, unseen".to_string(),
        2 => "goal".to_string(),
        _ if node == 0 => "start".to_string(),
        _ => format!("opening {node}"),
    }
}

/// A sheet with a title, metres below, and room for a legend below them.
fn sheet(along_m: f64, height_px: f64, legend_px: f64, title: &str) -> Document {
    let width_px = (LEFT_PX + along_m * ALONG_PX + 30.0).max(LEAST_WIDTH_PX);
    let bottom_px = TOP_PX + height_px;
    let whole_px = bottom_px + 40.0 + legend_px;
    let mut document = Document::new()
        .set("viewBox", (0, 0, rounded(width_px), rounded(whole_px)))
        .set("width", rounded(width_px))
        .set("height", rounded(whole_px))
        .set("font-family", FAMILY)
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", palette::PAPER));
    for (line, at) in wrap(title, TITLE_PX, width_px - 36.0).iter().zip(0_u8..) {
        let y = 24.0 + 20.0 * f64::from(at);
        document = document.add(text(line, 18.0, y, TITLE_PX).set("font-weight", "bold"));
    }
    let mut along = 0.0;
    while along <= along_m {
        document = document.add(centred(&format!("{along:.0} m"), x(along), bottom_px + 18.0, TEXT_PX));
        along += 5.0;
    }
    document
}

/// The least width for the legend.
const LEAST_WIDTH_PX: f64 = 600.0;

fn x(along_m: f64) -> f64 {
    rounded(LEFT_PX + along_m * ALONG_PX)
}

fn line(points: &[String]) -> Polyline {
    Polyline::new()
        .set("points", points.join(" "))
        .set("fill", "none")
        .set("stroke", palette::INK)
        .set("stroke-width", 1.2)
}

fn level(from_px: f64, to_px: f64, y_px: f64) -> Line {
    Line::new().set("x1", from_px).set("x2", to_px).set("y1", y_px).set("y2", y_px)
}

fn bar(from_px: f64, to_px: f64, middle_px: f64, fill: &str) -> Rectangle {
    let bar = Rectangle::new().set("x", from_px).set("y", rounded(middle_px - BAR_PX / 2.0));
    let bar = bar.set("width", rounded(to_px - from_px)).set("height", BAR_PX);
    bar.set("fill", fill).set("stroke", palette::INK).set("stroke-width", 0.6)
}
