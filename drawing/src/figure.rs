//! A map with what happened in it.

use super::floor_plan::FloorPlan;
use super::frame::Frame;
use super::labels::Labels;
use super::legend::{Legend, Sign, dot};
use super::marks::{Mark, TrackKind, mark_at, track_style};
use super::sheet::Sheet;
use super::writing::SMALL_PX;
use super::{ink, palette, shades};
use rpl_mission::sight::PositionBelief;
use rpl_robot::geometry::{Point, distance_m};
use svg::node::element::Group;

/// A mark is at least so large.
const LEAST_RADIUS_PX: f64 = 5.5;

/// Lines that are together longer than this, as multiples of the width of the map, are drawn thinner.
const LONG: f64 = 8.0;

/// Lines that mean the same.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// What they are.
    pub kind: TrackKind,
    /// In words.
    pub means: String,
    /// Each through its points.
    pub lines_in_map: Vec<Vec<Point>>,
}

/// Points that mean the same.
#[derive(Clone, Debug, PartialEq)]
pub struct Dots {
    /// What they are.
    pub means: String,
    /// Where.
    pub points_in_map: Vec<Point>,
}

/// What a drawing shows.
pub struct Figure<'a> {
    /// Above the drawing.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// What stands where.
    pub plan: FloorPlan,
    /// Where the robot may be: the darker the likelier.
    pub belief: Option<&'a PositionBelief>,
    /// Lines.
    pub tracks: Vec<Track>,
    /// Points.
    pub dots: Vec<Dots>,
    /// What stands out; what means something has its words in the legend.
    pub marks: Vec<Mark>,
}

impl<'a> Figure<'a> {
    /// A plan of the floor and nothing else.
    pub fn new(title: impl Into<String>, plan: FloorPlan) -> Self {
        Self {
            title: title.into(),
            subtitle: String::new(),
            plan,
            belief: None,
            tracks: Vec::new(),
            dots: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// Lines that mean the same.
    pub fn track(&mut self, kind: TrackKind, means: impl Into<String>, lines_in_map: Vec<Vec<Point>>) {
        if lines_in_map.iter().any(|line| !line.is_empty()) {
            self.tracks.push(Track { kind, means: means.into(), lines_in_map });
        }
    }

    /// The drawing as SVG.
    pub fn draw(&self) -> String {
        let sheet = Sheet::new(self.plan.bounds, &self.title, &self.subtitle);
        let frame = sheet.frame;
        let mut legend = Legend::default();
        let mut labels = Labels::new(sheet.width_px, sheet.map_to_px.1);
        let (left, top) = sheet.map_from_px;
        // Nothing is written into title and margin.
        labels.take((0.0, 0.0, sheet.width_px, top - 1.0));
        labels.take((0.0, 0.0, left - 1.0, sheet.map_to_px.1));
        let mut map = Group::new().add(self.plan.unknown(frame));
        if let Some(belief) = self.belief {
            map = map.add(shades::belief(belief, frame));
            legend.shades = Some(shades::belief_scale());
        }
        map = map.add(self.plan.solids(frame));
        self.plan.explain(&mut legend);
        map = self.draw_tracks(map, frame, &mut labels, &mut legend);
        map = self.draw_dots(map, frame, &mut legend);
        self.plan.keep_off(&mut labels, frame);
        map = map.add(self.plan.place_signs(&mut labels, frame));
        map = self.draw_marks(map, frame, &mut labels, &mut legend);
        self.plan.names(&mut labels, frame);
        if labels.left_out > 0 {
            legend.note = Some(format!("no room for {} of the names", labels.left_out));
        }
        sheet.finish(map.add(labels.drawn()), &legend)
    }

    fn draw_tracks(&self, mut map: Group, frame: Frame, labels: &mut Labels, legend: &mut Legend) -> Group {
        let length_m: f64 = self.tracks.iter().flat_map(|track| &track.lines_in_map).map(|line| length_m(line)).sum();
        let width_m = self.plan.bounds.max.x - self.plan.bounds.min.x;
        let weight = if length_m > LONG * width_m { 0.5 } else { 1.0 };
        for kind in [TrackKind::Round, TrackKind::Estimate, TrackKind::Link, TrackKind::Truth, TrackKind::Plan] {
            for track in self.tracks.iter().filter(|track| track.kind == kind) {
                for line in track.lines_in_map.iter().filter(|line| !line.is_empty()) {
                    let drawn = ink::line(line, frame).set("class", kind.class());
                    map = map.add(track_style(drawn, kind, weight));
                    for pair in line.windows(2) {
                        labels.cross_line(frame.at(pair[0]), frame.at(pair[1]));
                    }
                }
                legend.add(Sign::Track(kind), &track.means);
            }
        }
        map
    }

    fn draw_dots(&self, mut map: Group, frame: Frame, legend: &mut Legend) -> Group {
        for dots in &self.dots {
            map = dots.points_in_map.iter().fold(map, |map, &point| map.add(dot(frame.at(point))));
            legend.add(Sign::Dot, &dots.means);
        }
        map
    }

    fn draw_marks(&self, mut map: Group, frame: Frame, labels: &mut Labels, legend: &mut Legend) -> Group {
        for mark in &self.marks {
            let (at_px, radius_px) = placed(mark, frame);
            map = map.add(mark_at(mark.kind, at_px, mark.pose_in_map.heading_rad, radius_px));
            labels.take((at_px.0 - radius_px, at_px.1 - radius_px, at_px.0 + radius_px, at_px.1 + radius_px));
            legend.add(Sign::Mark(mark.kind), mark.kind.words());
        }
        for mark in self.marks.iter().filter(|mark| !mark.label.is_empty()) {
            let (at_px, radius_px) = placed(mark, frame);
            labels.beside(&mark.label, at_px, radius_px, SMALL_PX, palette::INK);
        }
        map
    }
}

fn placed(mark: &Mark, frame: Frame) -> ((f64, f64), f64) {
    (frame.at(mark.pose_in_map.point()), frame.length(mark.radius_m).max(LEAST_RADIUS_PX))
}

fn length_m(line: &[Point]) -> f64 {
    line.windows(2).map(|pair| distance_m(pair[0], pair[1])).sum()
}
