//! Charts as SVG, readable in black and white.

use super::calibration::Bin;
use super::over_time::OverTime;
use super::samples::{EVERY_S, POINTS};
use super::statistics::{Proportion, Summary};
use svg::Document;
use svg::node::element::{Circle, Line as Stroke, Polyline, Rectangle, Text};

/// Where the axes are on the sheet, in pixels.
const LEFT: f64 = 70.0;
const TOP: f64 = 50.0;
const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 400.0;

/// A sheet with two axes from 0.
struct Axes {
    x_max: f64,
    y_max: f64,
}

impl Axes {
    fn x(&self, value: f64) -> f64 {
        ((LEFT + WIDTH * (value / self.x_max).clamp(0.0, 1.0)) * 10.0).round() / 10.0
    }

    fn y(&self, value: f64) -> f64 {
        ((TOP + HEIGHT * (1.0 - (value / self.y_max).clamp(0.0, 1.0))) * 10.0).round() / 10.0
    }

    fn line(&self, from: (f64, f64), to: (f64, f64)) -> Stroke {
        Stroke::new()
            .set("x1", self.x(from.0))
            .set("y1", self.y(from.1))
            .set("x2", self.x(to.0))
            .set("y2", self.y(to.1))
            .set("stroke", "black")
    }

    /// The frame, five ticks on each axis, and what they mean.
    fn sheet(&self, title: &str, along: &str, up: &str) -> Document {
        let mut document = Document::new()
            .set("viewBox", (0, 0, 660, 510))
            .set("width", 660)
            .set("height", 510)
            .set("font-family", "sans-serif")
            .set("font-size", 14)
            .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white"))
            .add(text(title, LEFT + WIDTH / 2.0, 28.0).set("font-size", 17))
            .add(text(along, LEFT + WIDTH / 2.0, TOP + HEIGHT + 48.0))
            .add(text(up, 20.0, TOP + HEIGHT / 2.0).set("transform", format!("rotate(-90 20 {})", TOP + HEIGHT / 2.0)))
            .add(self.line((0.0, 0.0), (self.x_max, 0.0)))
            .add(self.line((0.0, 0.0), (0.0, self.y_max)));
        for tick in 0..=5 {
            let share = f64::from(tick) / 5.0;
            let (x, y) = (self.x(share * self.x_max), self.y(share * self.y_max));
            document = document
                .add(text(&label(share * self.x_max), x, TOP + HEIGHT + 22.0))
                .add(text(&label(share * self.y_max), LEFT - 10.0, y + 5.0).set("text-anchor", "end"));
        }
        document
    }
}

fn label(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

fn text(content: &str, x: f64, y: f64) -> Text {
    Text::new(content).set("x", x).set("y", y).set("text-anchor", "middle")
}

/// The reliability diagram: on the diagonal the robot is right as often as it says.
pub fn reliability(bins: &[Bin]) -> String {
    let axes = Axes { x_max: 1.0, y_max: 1.0 };
    let mut document = axes
        .sheet("how often the position is right", "certainty the robot says", "share of moments at which it is right")
        .add(axes.line((0.0, 0.0), (1.0, 1.0)).set("stroke-dasharray", "4 4"));
    for bin in bins {
        let (low, high) = bin.interval;
        document = document
            .add(axes.line((bin.said, low), (bin.said, high)))
            .add(Circle::new().set("cx", axes.x(bin.said)).set("cy", axes.y(bin.was)).set("r", 5));
    }
    document.to_string()
}

/// Lines of the error over time: solid, dashed, dotted, dash-dotted.
const DASHES: [&str; 4] = ["none", "9 5", "2 4", "9 4 2 4"];

/// Something over time.
pub struct Curve<'a> {
    /// What it is called.
    pub name: &'a str,
    /// In the order of time.
    pub points: Vec<CurvePoint>,
}

/// Something at a time, with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// When.
    pub time_s: f64,
    /// What it is.
    pub value: f64,
    /// Where its interval begins.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
}

/// The mean distance from the estimate to the truth over time, with 95 % bars; runs that have ended
/// keep their last error. None where nothing had an estimate.
pub fn error_over_time(rows: &[(&str, &OverTime)]) -> Option<String> {
    let points = rows.iter().filter_map(|(_, over_time)| over_time.error_points()).max()?;
    let over = |over_time: &OverTime| {
        let at = |point: usize| around((point * EVERY_S) as f64, over_time.error_m(point));
        (0..=points).map(at).collect()
    };
    let lines: Vec<Curve<'_>> = rows.iter().map(|(name, row)| Curve { name, points: over(row) }).collect();
    Some(over_time("error of the estimate, mean and 95 % interval", "error [m]", 1.0, &lines))
}

/// The share of the runs that have succeeded by a time, with 95 % bars.
pub fn success_over_time(rows: &[(&str, &OverTime)]) -> String {
    let latest_s = rows.iter().map(|(_, row)| row.latest_s).fold(1.0, f64::max);
    let line = |row: &OverTime| -> Vec<CurvePoint> {
        let point = |point: usize| {
            let at_s = latest_s * point as f64 / POINTS as f64;
            let share = Proportion::new(row.succeeded_s.up_to(at_s), row.runs);
            let (low, high) = share.interval_95;
            CurvePoint { time_s: at_s, value: share.rate.unwrap_or(0.0), low, high }
        };
        (0..=POINTS).map(point).collect()
    };
    let lines: Vec<Curve<'_>> = rows.iter().map(|(name, row)| Curve { name, points: line(row) }).collect();
    over_time("runs that have succeeded, with 95 % interval", "share of the runs", 1.0, &lines)
}

/// Lines over time with their bars, and their names; up to a whole number, at least `least`.
pub fn over_time(title: &str, up: &str, least: f64, lines: &[Curve<'_>]) -> String {
    let points = || lines.iter().flat_map(|line| &line.points);
    let highest = points().map(|point| point.high).fold(least, f64::max);
    let latest = points().map(|point| point.time_s).fold(1.0, f64::max);
    let y_max = if least < highest { highest.ceil() } else { least };
    let axes = Axes { x_max: (latest / 50.0).ceil() * 50.0, y_max };
    let mut document = axes.sheet(title, "time [s]", up);
    for (number, Curve { name, points }) in lines.iter().enumerate() {
        let dash = DASHES[number % DASHES.len()];
        let path: Vec<String> =
            points.iter().map(|point| format!("{},{}", axes.x(point.time_s), axes.y(point.value))).collect();
        document = document.add(
            Polyline::new()
                .set("points", path.join(" "))
                .set("fill", "none")
                .set("stroke", "black")
                .set("stroke-width", 1.6)
                .set("stroke-dasharray", dash),
        );
        for &CurvePoint { time_s, value, low, high } in points {
            let bar = axes.line((time_s, low), (time_s, high)).set("stroke-width", 0.8);
            document = document.add(bar).add(mark(number, axes.x(time_s), axes.y(value)));
        }
        let y = TOP + 8.0 + 20.0 * number as f64;
        let (from, to) = (LEFT + WIDTH - 190.0, LEFT + WIDTH - 150.0);
        let sample = Stroke::new().set("x1", from).set("x2", to).set("y1", y).set("y2", y);
        document = document
            .add(sample.set("stroke", "black").set("stroke-width", 1.6).set("stroke-dasharray", dash))
            .add(mark(number, (from + to) / 2.0, y))
            .add(text(name, to + 8.0, y + 5.0).set("text-anchor", "start"));
    }
    document.to_string()
}

/// The mark of a line: full for the first, hollow for the others.
fn mark(number: usize, x: f64, y: f64) -> Circle {
    let fill = if number == 0 { "black" } else { "white" };
    Circle::new().set("cx", x).set("cy", y).set("r", 3).set("fill", fill).set("stroke", "black")
}

/// The mean of some numbers at a time.
pub fn point(time_s: f64, numbers: &[f64]) -> CurvePoint {
    around(time_s, Summary::of(numbers).map_or((0.0, 0.0), |summary| (summary.spread.mean, summary.half_95)))
}

/// A mean at a time, and half its interval.
fn around(time_s: f64, (mean, half): (f64, f64)) -> CurvePoint {
    CurvePoint { time_s, value: mean, low: mean - half, high: mean + half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::samples::ErrorTrack;
    use crate::experiment::trial::MissionTrial;

    #[test]
    fn a_bin_is_drawn_where_it_says_and_was() {
        let bin = Bin { samples: 10, range: (0.4, 0.6), said: 0.5, was: 0.25, interval: (0.1, 0.4) };
        let drawn = reliability(&[bin]);
        assert!(drawn.contains("cx=\"350\"") && drawn.contains("cy=\"350\""), "{drawn}");
    }

    #[test]
    fn success_comes_when_the_plans_end_and_never_by_those_that_fail() {
        let trial = |fault: Option<&str>, time_s: f64| MissionTrial {
            seed: 1,
            fault: fault.map(str::to_string),
            measures: vec![("time [s]".into(), Some(time_s))],
            unmeasured: None,
            error: ErrorTrack::default(),
            samples: vec![],
        };
        let trials = [trial(None, 10.0), trial(None, 40.0), trial(Some("blocked"), 5.0), trial(None, 100.0)];
        let mut over_time = OverTime::default();
        trials.iter().for_each(|trial| over_time.add(trial));
        let drawn = success_over_time(&[("mine", &over_time)]);
        let line = drawn.split("<polyline").nth(1).and_then(|rest| rest.split("points=\"").nth(1)).expect("a line");
        let shares: Vec<f64> = line
            .split('"')
            .next()
            .expect("its points")
            .split_whitespace()
            .map(|point| point.split_once(',').expect("two numbers").1.parse::<f64>().expect("a number"))
            .map(|y| 1.0 - (y - TOP) / HEIGHT)
            .collect();
        let at = |time_s: usize| shares[time_s * POINTS / 100];
        assert_eq!((at(0), at(20), at(50), at(100)), (0.0, 0.25, 0.5, 0.75), "{shares:?}");
    }
}
