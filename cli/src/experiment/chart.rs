//! Charts as SVG, readable in black and white.

use super::calibration::Bin;
use super::statistics::{Proportion, Summary};
use super::trial::MissionTrial;
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

/// Seconds between two points of the error over time.
const EVERY_S: usize = 10;

/// Samples of a trial in a second.
const SAMPLES_PER_S: usize = 10;

/// Points of a line at most.
const POINTS: usize = 30;

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
/// keep their last error.
pub fn error_over_time(rows: &[(&str, Vec<MissionTrial>)]) -> String {
    let longest = rows.iter().flat_map(|(_, trials)| trials).map(|trial| trial.samples.len()).max().unwrap_or(0);
    let points = (longest / (EVERY_S * SAMPLES_PER_S)).clamp(1, POINTS);
    let over = |trials: &[MissionTrial]| (0..=points).map(|point| error_at(trials, point * EVERY_S)).collect();
    let lines: Vec<Curve<'_>> = rows.iter().map(|(name, trials)| Curve { name, points: over(trials) }).collect();
    over_time("error of the estimate, mean and 95 % interval", "error [m]", 1.0, &lines)
}

/// The share of the runs that have succeeded by a time, with 95 % bars.
pub fn success_over_time(rows: &[(&str, Vec<MissionTrial>)]) -> String {
    let time_s = |trial: &MissionTrial| trial.measure("time [s]").unwrap_or(0.0);
    let latest_s = rows.iter().flat_map(|(_, trials)| trials).map(time_s).fold(1.0, f64::max);
    let line = |trials: &[MissionTrial]| -> Vec<CurvePoint> {
        let done_s: Vec<f64> = trials.iter().filter(|trial| trial.succeeded()).map(time_s).collect();
        let at = |point: usize| latest_s * point as f64 / POINTS as f64;
        let share = |at_s: f64| Proportion::new(done_s.iter().filter(|&&done_s| done_s <= at_s).count(), trials.len());
        let point = |at_s: f64| {
            let Proportion { rate, interval_95: (low, high), .. } = share(at_s);
            CurvePoint { time_s: at_s, value: rate.unwrap_or(0.0), low, high }
        };
        (0..=POINTS).map(at).map(point).collect()
    };
    let lines: Vec<Curve<'_>> = rows.iter().map(|(name, trials)| Curve { name, points: line(trials) }).collect();
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

/// The mean error at a time.
fn error_at(trials: &[MissionTrial], time_s: usize) -> CurvePoint {
    let errors: Vec<f64> = trials
        .iter()
        .filter_map(|trial| trial.samples.get(time_s * SAMPLES_PER_S).or(trial.samples.last()))
        .map(|sample| f64::from(sample.off_m))
        .collect();
    point(time_s as f64, &errors)
}

/// The mean of some numbers at a time.
pub fn point(time_s: f64, numbers: &[f64]) -> CurvePoint {
    let (mean, half) = Summary::of(numbers).map_or((0.0, 0.0), |summary| (summary.spread.mean, summary.half_95));
    CurvePoint { time_s, value: mean, low: mean - half, high: mean + half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::trial::Sample;

    #[test]
    fn a_bin_is_drawn_where_it_says_and_was() {
        let bin = Bin { samples: 10, range: (0.4, 0.6), said: 0.5, was: 0.25, interval: (0.1, 0.4) };
        let drawn = reliability(&[bin]);
        assert!(drawn.contains("cx=\"350\"") && drawn.contains("cy=\"350\""), "{drawn}");
    }

    #[test]
    fn an_ended_run_keeps_its_last_error() {
        let samples = |errors: &[f32]| {
            errors
                .iter()
                .map(|&off_m| Sample { certainty: 1.0, off_m, off_rad: 0.0, is_right: true })
                .collect::<Vec<_>>()
        };
        let trial = |errors: &[f32]| MissionTrial {
            seed: 1,
            fault: None,
            unmeasured: None,
            measures: vec![],
            samples: samples(errors),
        };
        let trials = [trial(&[4.0]), trial(&[2.0; 201])];
        assert_eq!(error_at(&trials, 20).value, 3.0);
        assert!(error_over_time(&[("a row", trials.to_vec())]).contains("a row"));
    }

    #[test]
    fn success_comes_when_the_plans_end_and_never_by_those_that_fail() {
        let trial = |fault: Option<&str>, time_s: f64| MissionTrial {
            seed: 1,
            fault: fault.map(str::to_string),
            measures: vec![("time [s]", Some(time_s))],
            unmeasured: None,
            samples: vec![],
        };
        let trials = vec![trial(None, 10.0), trial(None, 40.0), trial(Some("blocked"), 5.0), trial(None, 100.0)];
        let drawn = success_over_time(&[("mine", trials)]);
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
