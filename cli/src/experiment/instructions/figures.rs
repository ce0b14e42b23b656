//! Figures of drives along hallways, like those of the paper: the contour line with what was detected (Fig. 6),
//! and the state set as it moves along the hallway (Figs. 3 to 5).

use super::course::Course;
use rpl_lola::feature::{Feature, Side};
use rpl_lola::instruction::Goal;
use rpl_lola::state_set::{Inference, StateSet};
use svg::Document;
use svg::node::element::{Line, Polyline, Rectangle, Text};

/// Pixels of a metre along the hallway.
const ALONG_PX: f64 = 20.0;

/// Pixels of a metre across it.
const ACROSS_PX: f64 = 22.0;

/// Around the drawing.
const LEFT_PX: f64 = 90.0;
const TOP_PX: f64 = 50.0;

/// What is heard farther from the middle of the hallway is drawn at this distance.
const FARTHEST_M: f64 = 3.0;

/// The bars of what was perceived and of what is there stand beyond that.
const SEEN_M: f64 = 3.4;
const THERE_M: f64 = 4.0;

/// The name of a row in the name of a file.
pub fn file_name(row: &str) -> String {
    let words: Vec<&str> = row.split(|sign: char| !sign.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    words.join("-").to_lowercase()
}

/// A drawing of the first drive of each row.
pub fn contours(rows: &[(&str, Vec<Course>)]) -> Vec<(String, String)> {
    let drawn = rows.iter().filter_map(|(name, courses)| {
        let file = format!("contour-{}.svg", file_name(name));
        Some((file, contour(name, courses.first()?)))
    });
    drawn.collect()
}

/// The contour lines of both sides, with what was perceived and what is there.
fn contour(name: &str, course: &Course) -> String {
    let middle_px = TOP_PX + (THERE_M + 0.5) * ACROSS_PX;
    let y = |aside_m: f64| rounded(middle_px - aside_m.clamp(-THERE_M - 0.5, THERE_M + 0.5) * ACROSS_PX);
    let title = format!("contour lines, {name}, seed {}: heard, perceived (white), and there (grey)", course.seed);
    let mut document = sheet(course.driven_m, 2.0 * (THERE_M + 0.5) * ACROSS_PX, &title);
    for side in Side::ALL {
        let points = course.contour.iter().filter(|point| point.side == side);
        let path: Vec<String> = points
            .map(|point| format!("{},{}", x(point.along_m), y(point.aside_m.clamp(-FARTHEST_M, FARTHEST_M))))
            .collect();
        document = document.add(line(&path));
        let bar = |from_m: f64, to_m: f64, aside_m: f64, fill: &str, feature: Feature| {
            let (from_px, to_px, y_px) = (x(from_m), x(to_m), y(side.sign() * aside_m));
            let bar = Rectangle::new().set("x", from_px).set("y", y_px - 6.0).set("width", rounded(to_px - from_px));
            let bar = bar.set("height", 12).set("fill", fill).set("stroke", "black").set("stroke-width", 0.6);
            (bar, text(letter(feature), (from_px + to_px) / 2.0, y_px + 4.0))
        };
        let seen = course.percepts.iter().filter(|percept| percept.side == side);
        let seen = seen.map(|percept| bar(percept.from_m, percept.to_m, SEEN_M, "white", percept.seen));
        let there = course.truth.iter().filter(|found| found.side == side);
        let there = there.filter(|found| found.to_m > 0.0 && found.from_m < course.driven_m);
        let there = there.map(|found| bar(found.from_m.max(0.0), found.to_m, THERE_M, "#d4d4d4", found.is));
        for (bar, label) in seen.chain(there) {
            document = document.add(bar).add(label);
        }
        let label = text(side.in_words(), LEFT_PX - 45.0, y(side.sign() * SEEN_M) + 4.0);
        document = document.add(label);
    }
    document.to_string()
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

/// So much of the way beyond the arrival is drawn.
const BEYOND_M: f64 = 4.0;

/// The opening that is asked for in the drawing of a state set, at the most.
const DRAWN_ORDINAL: usize = 4;

/// A drawing of the first drive of each setting: the state set of an instruction as it moves.
pub fn state_sets(driven: &[(&str, Vec<Course>)]) -> Vec<(String, String)> {
    let drawn = driven.iter().filter_map(|(name, courses)| {
        let course = courses.first()?;
        let file = format!("state-set-{}.svg", file_name(name));
        Some((file, state_set(name, course)?))
    });
    drawn.collect()
}

/// What is asked for: on the left, the last of the first few openings that an instruction can lead to.
fn drawn_goal(course: &Course) -> Option<Goal> {
    let openings = course.openings(Side::Left).into_iter().take(DRAWN_ORDINAL).zip(1..);
    let goals = openings.filter(|(found, _)| matches!(found.is, Feature::Hallway | Feature::OpenDoor));
    goals.last().map(|(found, ordinal)| Goal { ordinal, side: Side::Left, kind: found.is })
}

/// Certainties of the nodes over the way: the darker the likelier.
fn state_set(name: &str, course: &Course) -> Option<String> {
    let goal = drawn_goal(course)?;
    let inference = Inference::of_robot(name.contains("markers"));
    let mut state_set = StateSet::start(goal.instruction())?;
    let mut columns = vec![(0.0, state_set.certainties())];
    let mut arrived_m = None;
    for percept in course.percepts.iter().filter(|percept| percept.side == goal.side) {
        state_set.progress(&inference, &[*percept], &course.hidden);
        columns.push((percept.to_m, state_set.certainties()));
        if state_set.arrived().is_some() {
            arrived_m = Some(percept.to_m);
            break;
        }
    }
    let end_m = arrived_m.map_or(course.driven_m, |arrived_m| arrived_m + BEYOND_M);
    let nodes = columns[0].1.len();
    let row_px = 34.0;
    let y = |node: usize| TOP_PX + row_px * (nodes - 1 - node) as f64;
    let title = format!("state set of \"{}\", {name}, seed {}", goal.instruction(), course.seed);
    let mut document = sheet(end_m, row_px * nodes as f64, &title);
    for node in 0..nodes {
        document = document.add(text(&node_name(node, nodes), LEFT_PX - 45.0, y(node) + row_px / 2.0 + 4.0));
    }
    let ends = columns.iter().skip(1).map(|(from_m, _)| *from_m).chain([end_m]);
    for ((from_m, certainties), to_m) in columns.iter().zip(ends) {
        for (node, certainty) in certainties.iter().enumerate() {
            let cell = Rectangle::new().set("x", x(*from_m)).set("y", y(node)).set("height", row_px);
            let cell = cell.set("width", rounded((to_m - from_m).max(0.0) * ALONG_PX)).set("fill", "black");
            document = document.add(cell.set("fill-opacity", rounded(*certainty)));
        }
        let border = Line::new().set("x1", x(*from_m)).set("x2", x(*from_m)).set("y1", TOP_PX);
        let border = border.set("y2", TOP_PX + row_px * nodes as f64).set("stroke", "black").set("stroke-width", 0.5);
        document = document.add(border);
    }
    let label = arrived_m.map(|arrived_m| text("arrived", x(arrived_m), TOP_PX - 6.0));
    Some(label.into_iter().fold(document, Document::add).to_string())
}

fn node_name(node: usize, nodes: usize) -> String {
    match nodes - node {
        1 => "beyond".to_string(),
        2 => "goal".to_string(),
        _ if node == 0 => "start".to_string(),
        _ => format!("opening {node}"),
    }
}

/// A white sheet with a title, and metres below.
fn sheet(along_m: f64, height_px: f64, title: &str) -> Document {
    let width_px = LEFT_PX + along_m * ALONG_PX + 30.0;
    let whole_px = TOP_PX + height_px + 50.0;
    let mut document = Document::new()
        .set("viewBox", (0, 0, rounded(width_px), rounded(whole_px)))
        .set("width", rounded(width_px))
        .set("height", rounded(whole_px))
        .set("font-family", "sans-serif")
        .set("font-size", 11)
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white"))
        .add(text(title, width_px / 2.0, 24.0).set("font-size", 15));
    let mut along = 0.0;
    while along <= along_m {
        document = document.add(text(&format!("{along:.0} m"), x(along), TOP_PX + height_px + 24.0));
        along += 5.0;
    }
    document
}

fn x(along_m: f64) -> f64 {
    rounded(LEFT_PX + along_m * ALONG_PX)
}

/// To the tenth of a pixel, or of certainty to the hundredth: more digits only make the file longer.
fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn line(points: &[String]) -> Polyline {
    Polyline::new().set("points", points.join(" ")).set("fill", "none").set("stroke", "black").set("stroke-width", 1.0)
}

fn text(content: &str, x_px: f64, y_px: f64) -> Text {
    Text::new(content).set("x", rounded(x_px)).set("y", rounded(y_px)).set("text-anchor", "middle")
}
