//! Map, paths and errors of the trials as SVG, readable in black and white.

use super::Timed;
use crate::drawing::{Figure, FloorPlan, TrackKind};
use rpl_robot::geometry::Point;
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::recording::PoseError;
use svg::Document;
use svg::node::element::{Group, Line, Polyline, Rectangle, Text};

/// Errors are drawn up to this; a lost robot is somewhere above.
const MOST_M: f64 = 2.0;
const MOST_DEG: f64 = 20.0;

const PLOT_WIDTH: f64 = 900.0;
const PLOT_HEIGHT: f64 = 160.0;
const LEFT: f64 = 70.0;
const ROW: f64 = 215.0;

/// The map with the paths.
pub fn paths(map: &OccupancyGrid, trials: &[Timed]) -> String {
    let mut figure = Figure::new("Where the robot was", FloorPlan::of_map(map));
    let lines = |of: fn(&Timed) -> Vec<Point>| trials.iter().map(of).collect();
    let estimate =
        |timed: &Timed| timed.trial.errors_once_found().iter().map(|at| at.estimate_in_map.point()).collect();
    let truth = |timed: &Timed| timed.trial.errors.iter().map(|at| at.true_in_map.point()).collect();
    figure.track(TrackKind::Estimate, "estimate, once found", lines(estimate));
    figure.track(TrackKind::Truth, "corrected path of the log", lines(truth));
    figure.draw()
}

/// The errors over the way, a line for each window.
pub fn errors(trials: &[Timed]) -> String {
    let length_m = trials.iter().map(|timed| timed.window.length_m).fold(0.0, f64::max);
    let positions = plot("error of the position [m]", MOST_M, length_m, trials, PoseError::position_m);
    let headings =
        plot("error of the heading [°]", MOST_DEG, length_m, trials, |error| error.heading_rad().to_degrees());
    let (width, height) = (LEFT + PLOT_WIDTH + 20.0, 2.0 * ROW + 20.0);
    Document::new()
        .set("viewBox", (0, 0, width, height))
        .set("width", width)
        .set("height", height)
        .set("font-family", "sans-serif")
        .set("font-size", 14)
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white"))
        .add(positions.set("transform", format!("translate({LEFT} 30)")))
        .add(headings.set("transform", format!("translate({LEFT} {})", ROW + 30.0)))
        .to_string()
}

fn plot(title: &str, most: f64, length_m: f64, trials: &[Timed], error: fn(&PoseError) -> f64) -> Group {
    let x = |travelled_m: f64| (travelled_m / length_m.max(1e-9)).min(1.0) * PLOT_WIDTH;
    let y = |value: f64| PLOT_HEIGHT * (1.0 - value.min(most) / most);
    let frame = Rectangle::new().set("width", PLOT_WIDTH).set("height", PLOT_HEIGHT).set("fill", "none");
    let mut group = Group::new()
        .add(frame.set("stroke", "black"))
        .add(Text::new(title).set("y", -8.0))
        .add(label("0", -8.0, PLOT_HEIGHT, "end"))
        .add(label(&format!("≥ {most}"), -8.0, 12.0, "end"))
        .add(label("0 m", 0.0, PLOT_HEIGHT + 18.0, "middle"))
        .add(label(&format!("{length_m:.0} m"), PLOT_WIDTH, PLOT_HEIGHT + 18.0, "end"));
    for quarter in [0.25, 0.5, 0.75] {
        let at = y(quarter * most);
        let line = Line::new().set("x1", 0).set("x2", PLOT_WIDTH).set("y1", at).set("y2", at);
        group = group.add(line.set("stroke", "#bbb").set("stroke-dasharray", "2 4")).add(label(
            &format!("{}", quarter * most),
            -8.0,
            at + 5.0,
            "end",
        ));
    }
    for timed in trials {
        let points: Vec<String> =
            (timed.trial.errors.iter()).map(|at| format!("{:.1},{:.1}", x(at.travelled_m), y(error(at)))).collect();
        let line = Polyline::new().set("points", points.join(" ")).set("fill", "none").set("class", "window");
        group = group.add(line.set("stroke", "black").set("stroke-opacity", 0.5));
    }
    group
}

fn label(content: &str, x: f64, y: f64, anchor: &str) -> Text {
    Text::new(content).set("x", x).set("y", y).set("text-anchor", anchor)
}
