//! Map, paths and errors of the trials as SVG.

use super::windows::Timed;
use rpl_drawing::palette::{self, SERIES};
use rpl_drawing::writing::{FAMILY, SMALL_PX, TEXT_PX, TITLE_PX, centred, ending, rounded, text};
use rpl_drawing::{Figure, FloorPlan, TrackKind};
use rpl_robot::geometry::Point;
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::recording::{PoseError, RIGHT_M, RIGHT_RAD, SURE};
use svg::Document;
use svg::node::element::{Group, Line, Polyline, Rectangle};

/// Errors are drawn up to this; a lost robot is somewhere above.
const MOST_M: f64 = 2.0;
const MOST_DEG: f64 = 20.0;

const PLOT_WIDTH: f64 = 860.0;
const PLOT_HEIGHT: f64 = 150.0;
const LEFT: f64 = 70.0;
/// Title and legend.
const TOP: f64 = 92.0;
/// From one plot to the next.
const ROW: f64 = 190.0;

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

/// What is drawn of each scan, over the way.
struct Plot {
    title: &'static str,
    most: f64,
    /// On the near side of this an estimate is right, or the filter is sure.
    bound: f64,
    of: fn(&PoseError) -> f64,
}

/// The errors over the way and how certain the filter was, a line for each window.
pub fn errors(trials: &[Timed]) -> String {
    let length_m = trials.iter().map(|timed| timed.window.length_m).fold(0.0, f64::max);
    let plots = [
        Plot { title: "position off [m]", most: MOST_M, bound: RIGHT_M, of: PoseError::position_m },
        Plot {
            title: "heading off [°]",
            most: MOST_DEG,
            bound: RIGHT_RAD.to_degrees(),
            of: |error| error.heading_rad().to_degrees(),
        },
        Plot { title: "certainty", most: 1.0, bound: SURE, of: |error| error.certainty },
    ];
    let (width, height) = (LEFT + PLOT_WIDTH + 24.0, TOP + plots.len() as f64 * ROW + 14.0);
    let mut document = Document::new()
        .set("viewBox", (0, 0, width, height))
        .set("width", width)
        .set("height", height)
        .set("font-family", FAMILY)
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", palette::PAPER))
        .add(text("How far off the estimate was, and how certain", 18.0, 28.0, TITLE_PX).set("font-weight", "bold"))
        .add(legend(trials.len()));
    for (row, plot) in plots.iter().enumerate() {
        let at = format!("translate({LEFT} {})", TOP + row as f64 * ROW);
        document = document.add(plot.drawn(length_m, trials).set("transform", at));
    }
    document.add(centred("way in the window [m]", LEFT + PLOT_WIDTH / 2.0, height - 10.0, TEXT_PX)).to_string()
}

fn legend(windows: usize) -> Group {
    let stroke = |from: f64| Line::new().set("x1", from).set("x2", from + 34.0).set("y1", 48).set("y2", 48);
    let windows = if windows == 1 { "the window".to_string() } else { format!("one of {windows} windows") };
    Group::new()
        .add(stroke(18.0).set("stroke", SERIES[0]).set("stroke-width", 1.5))
        .add(text(&windows, 60.0, 52.0, SMALL_PX))
        .add(stroke(240.0).set("stroke", palette::INK).set("stroke-dasharray", "5 4"))
        .add(text("below it the estimate counts as right; above it, in the last plot, as sure", 282.0, 52.0, SMALL_PX))
}

impl Plot {
    fn drawn(&self, length_m: f64, trials: &[Timed]) -> Group {
        let x = |travelled_m: f64| rounded((travelled_m / length_m.max(1e-9)).min(1.0) * PLOT_WIDTH);
        let y = |value: f64| rounded(PLOT_HEIGHT * (1.0 - value.min(self.most) / self.most));
        let across =
            |value: f64| Line::new().set("x1", 0).set("x2", PLOT_WIDTH).set("y1", y(value)).set("y2", y(value));
        let mut group = Group::new().add(text(self.title, 0.0, -8.0, TEXT_PX));
        for quarter in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let value = quarter * self.most;
            let from = if quarter == 1.0 && self.most > 1.0 { "≥ " } else { "" };
            group = group.add(across(value).set("stroke", palette::GRID)).add(ending(
                &format!("{from}{value}"),
                -8.0,
                y(value) + 4.0,
                SMALL_PX,
            ));
        }
        for fifth in 0..=5 {
            let at_m = length_m * f64::from(fifth) / 5.0;
            let written = format!("{at_m:.1}").trim_end_matches(".0").to_string();
            group = group.add(centred(&written, x(at_m), PLOT_HEIGHT + 16.0, SMALL_PX));
        }
        for timed in trials {
            let at = |error: &PoseError| format!("{},{}", x(error.travelled_m), y((self.of)(error)));
            let points: Vec<String> = timed.trial.errors.iter().map(at).collect();
            let line = Polyline::new().set("points", points.join(" ")).set("fill", "none").set("class", "window");
            group = group.add(line.set("stroke", SERIES[0]).set("stroke-opacity", 0.55));
        }
        group.add(across(self.bound).set("stroke", palette::INK).set("stroke-dasharray", "5 4"))
    }
}
