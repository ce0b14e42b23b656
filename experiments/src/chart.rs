//! Charts as SVG: lines with their 95 % intervals, told apart by colour and by dashes.

use super::over_time::OverTime;
use super::reliability::Bin;
use super::samples::EVERY_S;
use super::statistics::{Proportion, Summary};
use rpl_drawing::palette::{self, SERIES};
use rpl_drawing::writing::{FAMILY, SMALL_PX, TEXT_PX, TITLE_PX, centred, ending, rounded, text, width_px, wrap};
use svg::Document;
use svg::node::element::{Circle, Group, Line as Stroke, Path, Polyline, Rectangle};

/// Where the axes are on the sheet, in pixels.
const LEFT: f64 = 70.0;
const WIDTH: f64 = 600.0;
const HEIGHT: f64 = 340.0;
const SHEET_WIDTH: f64 = LEFT + WIDTH + 30.0;

/// A line of the legend.
const LEGEND_LINE: f64 = 20.0;

/// A sheet with two axes from 0, below a title of some lines.
struct Axes {
    x_max: f64,
    y_max: f64,
    /// Where the plot begins, below the title.
    top: f64,
    title: Vec<String>,
}

/// A round number that is no less, and into how many parts an axis up to there is divided.
pub fn axis_up_to(value: f64) -> (f64, u32) {
    let power = libm::exp10(libm::floor(libm::log10(value.max(1e-9))));
    let rounds = [(1.0, 5), (1.5, 3), (2.0, 4), (2.5, 5), (3.0, 3), (4.0, 4), (5.0, 5), (6.0, 3), (8.0, 4), (10.0, 5)];
    let found = rounds.into_iter().find(|round| round.0 * power >= value * (1.0 - 1e-9));
    found.map_or((value, 5), |(round, parts)| (round * power, parts))
}

impl Axes {
    fn new(title: &str, x_max: f64, y_max: f64) -> Self {
        let title = wrap(title, TITLE_PX, WIDTH + LEFT - 20.0);
        Self { x_max, y_max, top: 26.0 + 22.0 * title.len() as f64, title }
    }

    fn x(&self, value: f64) -> f64 {
        rounded(LEFT + WIDTH * (value / self.x_max).clamp(0.0, 1.0))
    }

    fn y(&self, value: f64) -> f64 {
        rounded(self.top + HEIGHT * (1.0 - (value / self.y_max).clamp(0.0, 1.0)))
    }

    fn line(&self, from: (f64, f64), to: (f64, f64), colour: &str) -> Stroke {
        Stroke::new()
            .set("x1", self.x(from.0))
            .set("y1", self.y(from.1))
            .set("x2", self.x(to.0))
            .set("y2", self.y(to.1))
            .set("stroke", colour)
    }

    /// The title, the axes with their ticks, what they mean, and room for `legend_lines` lines of a legend.
    fn sheet(&self, along: &str, up: &str, legend_lines: usize) -> Document {
        let bottom = self.top + HEIGHT;
        let height = bottom + 58.0 + LEGEND_LINE * legend_lines as f64;
        let middle = self.top + HEIGHT / 2.0;
        let mut document = Document::new()
            .set("viewBox", (0, 0, SHEET_WIDTH, height))
            .set("width", SHEET_WIDTH)
            .set("height", height)
            .set("font-family", FAMILY)
            .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", palette::PAPER))
            .add(centred(along, LEFT + WIDTH / 2.0, bottom + 40.0, TEXT_PX))
            .add(centred(up, 18.0, middle, TEXT_PX).set("transform", format!("rotate(-90 18 {middle})")));
        for (number, line) in self.title.iter().enumerate() {
            let y = 26.0 + 21.0 * number as f64;
            document = document.add(text(line, 18.0, y, TITLE_PX).set("font-weight", "bold"));
        }
        let ticks = |most: f64| {
            let parts = axis_up_to(most).1;
            (0..=parts).map(move |part| most * f64::from(part) / f64::from(parts))
        };
        for value in ticks(self.x_max) {
            document = document.add(self.line((value, 0.0), (value, self.y_max), palette::GRID)).add(centred(
                &axis_label(value),
                self.x(value),
                bottom + 18.0,
                SMALL_PX,
            ));
        }
        for value in ticks(self.y_max) {
            document = document.add(self.line((0.0, value), (self.x_max, value), palette::GRID)).add(ending(
                &axis_label(value),
                LEFT - 8.0,
                self.y(value) + 4.0,
                SMALL_PX,
            ));
        }
        document.add(self.line((0.0, 0.0), (self.x_max, 0.0), palette::INK)).add(self.line(
            (0.0, 0.0),
            (0.0, self.y_max),
            palette::INK,
        ))
    }
}

/// A number at an axis.
pub fn axis_label(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// The reliability diagram: on the diagonal the robot is right as often as it says.
pub fn reliability(bins: &[Bin]) -> String {
    let axes = Axes::new("How often the position is right", 1.0, 1.0);
    let along = "certainty that the robot says, in bins with equal numbers of samples";
    let up = "share of moments at which it is right";
    let diagonal = axes.line((0.0, 0.0), (1.0, 1.0), palette::QUIET).set("stroke-dasharray", "5 4");
    let mut document = axes.sheet(along, up, 1).add(diagonal);
    for bin in bins {
        let (low, high) = bin.interval;
        let (x, y) = (axes.x(bin.said), axes.y(bin.was));
        document = document
            .add(axes.line((bin.said, low), (bin.said, high), SERIES[0]).set("stroke-width", 2))
            .add(Circle::new().set("cx", x).set("cy", y).set("r", 5).set("fill", SERIES[0]));
    }
    let y = axes.top + HEIGHT + 62.0;
    let bar = Stroke::new().set("x1", LEFT + 7.0).set("x2", LEFT + 7.0).set("y1", y - 8.0).set("y2", y + 8.0);
    let diagonal = Stroke::new().set("x1", LEFT + 230.0).set("x2", LEFT + 260.0).set("y1", y).set("y2", y);
    document
        .add(bar.set("stroke", SERIES[0]).set("stroke-width", 2))
        .add(Circle::new().set("cx", LEFT + 7.0).set("cy", y).set("r", 5).set("fill", SERIES[0]))
        .add(text("measured, with 95 % interval", LEFT + 20.0, y + 4.0, SMALL_PX))
        .add(diagonal.set("stroke", palette::QUIET).set("stroke-dasharray", "5 4"))
        .add(text("as often as it says", LEFT + 266.0, y + 4.0, SMALL_PX))
        .to_string()
}

/// Something over time.
pub(crate) struct Curve<'a> {
    /// What it is called.
    pub name: &'a str,
    /// In the order of time.
    pub points: Vec<CurvePoint>,
}

/// Something at a time, with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CurvePoint {
    /// When.
    pub time_s: f64,
    /// What it is.
    pub value: f64,
    /// Where its interval begins.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
}

/// The mean distance from the estimate to the truth over time, with 95 % intervals; runs that have ended
/// keep their last error. None where nothing had an estimate.
pub(crate) fn error_over_time(rows: &[(&str, &OverTime)]) -> Option<String> {
    let points = rows.iter().filter_map(|(_, over_time)| over_time.error_points()).max()?;
    let over = |over_time: &OverTime| {
        let at = |point: usize| around((point * EVERY_S) as f64, over_time.error_m(point));
        (0..=points).map(at).collect()
    };
    let lines: Vec<Curve<'_>> = rows.iter().map(|(name, row)| Curve { name, points: over(row) }).collect();
    Some(over_time("Distance from the estimate to the truth: mean and 95 % interval", "error [m]", 1.0, &lines))
}

/// A curve of steps has no more of them at their own times.
const MOST_STEPS: usize = 400;

/// The share of the runs that have succeeded by a time, with 95 % intervals.
pub(crate) fn success_over_time(rows: &[(&str, &OverTime)]) -> String {
    let latest_s = rows.iter().map(|(_, row)| row.latest_s).fold(1.0, f64::max);
    let line = |row: &OverTime| -> Vec<CurvePoint> {
        let point = |at_s: f64| {
            let share = Proportion::new(row.succeeded_s.up_to(at_s), row.runs);
            let (low, high) = share.interval_95;
            CurvePoint { time_s: at_s, value: share.rate.unwrap_or(0.0), low, high }
        };
        // Where runs are few each steps at its own time; where they are many, no step could be seen.
        let own = row.succeeded_s.different(MOST_STEPS);
        let grid = || (0..=MOST_STEPS).map(|point| latest_s * point as f64 / MOST_STEPS as f64).collect();
        let mut times_s: Vec<f64> = own.unwrap_or_else(grid);
        times_s.insert(0, 0.0);
        times_s.push(latest_s);
        let points: Vec<CurvePoint> = times_s.into_iter().map(point).collect();
        // A run succeeds at a moment: between two the share stays what it was.
        let steps = points.windows(2).flat_map(|pair| [CurvePoint { time_s: pair[1].time_s, ..pair[0] }, pair[1]]);
        points.first().copied().into_iter().chain(steps).collect()
    };
    let lines: Vec<Curve<'_>> = rows.iter().map(|(name, row)| Curve { name, points: line(row) }).collect();
    over_time("Runs that have succeeded, with 95 % interval", "share of the runs", 1.0, &lines)
}

/// Lines over time with their intervals as bands, and their names; up to a round number, at least `least`.
pub(crate) fn over_time(title: &str, up: &str, least: f64, lines: &[Curve<'_>]) -> String {
    let points = || lines.iter().flat_map(|line| &line.points);
    let highest = points().map(|point| point.high).fold(least, f64::max);
    let latest = points().map(|point| point.time_s).fold(1.0, f64::max);
    let axes = Axes::new(title, axis_up_to(latest).0, axis_up_to(highest).0);
    let rows = legend_rows(lines);
    let last_row = rows.last().map_or(0, |row| row.0 + 1);
    let mut document = axes.sheet("time [s]", up, last_row);
    for (number, line) in lines.iter().enumerate() {
        document = document.add(band(&axes, &line.points, series(number)));
    }
    for (number, line) in lines.iter().enumerate() {
        let at = |point: &CurvePoint| format!("{},{}", axes.x(point.time_s), axes.y(point.value));
        let path: Vec<String> = line.points.iter().map(at).collect();
        let drawn = Polyline::new().set("points", path.join(" ")).set("fill", "none").set("stroke-linejoin", "round");
        let drawn = drawn.set("stroke", series(number)).set("stroke-width", 2);
        document = document.add(drawn.set("stroke-dasharray", DASHES[number % DASHES.len()]));
    }
    for ((number, line), (row, x)) in lines.iter().enumerate().zip(rows) {
        let y = axes.top + HEIGHT + 60.0 + LEGEND_LINE * row as f64;
        document = document.add(sample(number, x, y)).add(text(line.name, x + 42.0, y + 4.0, SMALL_PX));
    }
    document.to_string()
}

/// Lines differ in colour and, for who prints in grey, in their dashes.
const DASHES: [&str; 6] = ["none", "9 4", "2.5 3", "9 3 2 3", "14 4", "5 2"];

/// The colour of a line or a row, by its number.
pub fn series(number: usize) -> &'static str {
    SERIES[number % SERIES.len()]
}

/// In which row of the legend each name stands, and where it begins.
fn legend_rows(lines: &[Curve<'_>]) -> Vec<(usize, f64)> {
    let (mut row, mut x) = (0, LEFT);
    let mut rows = Vec::new();
    for line in lines {
        let width = 42.0 + width_px(line.name, SMALL_PX) + 18.0;
        if x + width > LEFT + WIDTH && x > LEFT {
            (row, x) = (row + 1, LEFT);
        }
        rows.push((row, x));
        x += width;
    }
    rows
}

/// A piece of a line with its band.
fn sample(number: usize, x: f64, y: f64) -> Group {
    let band = Rectangle::new().set("x", rounded(x)).set("y", rounded(y - 6.0)).set("width", 36).set("height", 12);
    let line = Stroke::new().set("x1", rounded(x)).set("x2", rounded(x + 36.0)).set("y1", y).set("y2", y);
    let line = line.set("stroke", series(number)).set("stroke-width", 2);
    Group::new()
        .add(band.set("fill", series(number)).set("fill-opacity", BAND))
        .add(line.set("stroke-dasharray", DASHES[number % DASHES.len()]))
}

/// How much of its colour a band has.
const BAND: f64 = 0.11;

/// The intervals of a line.
fn band(axes: &Axes, points: &[CurvePoint], colour: &str) -> Path {
    let corner = |time_s: f64, value: f64| format!("{} {}", axes.x(time_s), axes.y(value));
    let above = points.iter().map(|point| corner(point.time_s, point.high));
    let below = points.iter().rev().map(|point| corner(point.time_s, point.low));
    let corners: Vec<String> = above.chain(below).collect();
    let path = Path::new().set("fill", colour).set("fill-opacity", BAND).set("class", "interval");
    if corners.is_empty() { path } else { path.set("d", format!("M{}Z", corners.join("L"))) }
}

/// The mean of some numbers at a time.
pub(crate) fn point(time_s: f64, numbers: &[f64]) -> CurvePoint {
    around(time_s, Summary::of(numbers).map_or((0.0, 0.0), |summary| (summary.spread.mean, summary.half_95)))
}

/// A mean at a time, and half its interval.
fn around(time_s: f64, (mean, half): (f64, f64)) -> CurvePoint {
    CurvePoint { time_s, value: mean, low: mean - half, high: mean + half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Quantity;
    use crate::samples::ErrorTrack;
    use crate::trial::MissionTrial;

    #[test]
    fn a_bin_is_drawn_where_it_says_and_was() {
        let bin = Bin { samples: 10, range: (0.4, 0.6), said: 0.5, was: 0.25, interval: (0.1, 0.4) };
        let drawn = reliability(&[bin]);
        let middle = format!("cx=\"{}\" cy=\"{}\"", LEFT + 0.5 * WIDTH, 48.0 + 0.75 * HEIGHT);
        assert!(drawn.contains(&middle), "{middle} in {drawn}");
    }

    #[test]
    fn success_comes_when_the_plans_end_and_never_by_those_that_fail() {
        let trial = |fault: Option<&str>, time_s: f64| MissionTrial {
            seed: 1,
            fault: fault.map(str::to_string),
            value: None,
            measures: vec![(Quantity::Time, Some(time_s))],
            unmeasured: None,
            error: ErrorTrack::default(),
            samples: vec![],
        };
        let trials = [trial(None, 10.0), trial(None, 40.0), trial(Some("blocked"), 5.0), trial(None, 100.0)];
        let mut over_time = OverTime::default();
        trials.iter().for_each(|trial| over_time.add(trial));
        let drawn = success_over_time(&[("mine", &over_time)]);
        let line = drawn.split("<polyline").nth(1).and_then(|rest| rest.split("points=\"").nth(1)).expect("a line");
        let axis_s = axis_up_to(100.0).0;
        let corners: Vec<(f64, f64)> = line
            .split('"')
            .next()
            .expect("its points")
            .split_whitespace()
            .map(|point| point.split_once(',').expect("two numbers"))
            .map(|(x, y)| (x.parse::<f64>().expect("a number"), y.parse::<f64>().expect("a number")))
            .map(|(x, y)| ((x - LEFT) / WIDTH * axis_s, 1.0 - (y - 48.0) / HEIGHT))
            .collect();
        // The line goes along to the time of each success and then up.
        let at = |time_s: f64| corners.iter().rfind(|(corner_s, _)| *corner_s <= time_s).expect("it begins at 0").1;
        assert_eq!((at(9.0), at(10.2), at(39.0), at(40.2)), (0.0, 0.25, 0.25, 0.5), "{corners:?}");
        assert_eq!(corners.last().expect("it ends").1, 0.75, "{corners:?}");
    }
}
