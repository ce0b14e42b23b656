//! Numbers for points around the robot, as darkness.

use super::frame::Frame;
use super::ink::{self, Raster};
use super::labels::Labels;
use super::legend::{Legend, Sign};
use super::marks::{MarkKind, TrackKind, mark_at, track_style};
use super::palette;
use super::shades::{self, ShadeScale};
use super::sheet::{Sheet, round_below};
use super::writing::{SMALL_PX, centred, ending};
use rpl_robot::active::ActionGrid;
use rpl_robot::geometry::{Point, Vector};
use rpl_robot::world::Rect;
use svg::node::element::{Group, Line};

/// Around the field, for what is written at its axes.
const AXIS_SHARE: f64 = 0.06;

/// Numbers for points around the robot.
pub struct Field<'a> {
    /// Above the drawing.
    pub title: &'a str,
    /// Below the title.
    pub subtitle: &'a str,
    /// Where the cells lie.
    pub grid: ActionGrid,
    /// Their darkness.
    pub steps: Vec<Option<usize>>,
    /// What it means.
    pub scale: ShadeScale,
    /// The way to the chosen target.
    pub way_in_base: Vec<Point>,
    /// What stands out, and what is written beside it.
    pub marks: Vec<(MarkKind, Point, String)>,
}

impl Field<'_> {
    /// The drawing as SVG.
    pub fn draw(self) -> String {
        let half_m = (self.grid.reach as f64 + 0.5) * self.grid.resolution_m;
        let corner = Vector::new(half_m, half_m);
        let room = corner * (1.0 + 2.0 * AXIS_SHARE);
        let bounds = Rect { min: Point::origin() - room, max: Point::origin() + corner };
        let sheet = Sheet::new(bounds, self.title, self.subtitle);
        let frame = sheet.frame;
        let side = self.grid.side();
        let raster = Raster {
            origin_in_map: Point::origin() - corner,
            resolution_m: self.grid.resolution_m,
            columns: side,
            rows: side,
        };
        let mut labels = Labels::new(sheet.width_px, sheet.map_to_px.1);
        let mut legend = Legend::default();
        legend.shades = Some(self.scale.clone());
        let mut map = axes(frame, half_m).add(shades::shaded(&raster, &self.steps, frame));
        let way = ink::line(&self.way_in_base, frame).set("class", TrackKind::Plan.class());
        map = map.add(track_style(way, TrackKind::Plan, 1.0));
        legend.add(Sign::Track(TrackKind::Plan), "way to the target");
        for (kind, at, _) in &self.marks {
            let (x_px, y_px) = frame.at(*at);
            labels.take((x_px - 6.0, y_px - 6.0, x_px + 6.0, y_px + 6.0));
            map = map.add(mark_at(*kind, (x_px, y_px), 0.0, 6.0));
            legend.add(Sign::Mark(*kind), kind.words());
        }
        for (_, at, label) in self.marks.iter().filter(|mark| !mark.2.is_empty()) {
            labels.beside(label, frame.at(*at), 6.0, SMALL_PX, palette::INK);
        }
        sheet.finish(map.add(labels.drawn()), &legend)
    }
}

/// A frame, and round numbers of metres beside it.
fn axes(frame: Frame, half_m: f64) -> Group {
    let line = |from: (f64, f64), to: (f64, f64), colour: &str| {
        let ((x1, y1), (x2, y2)) = (frame.at(Point::new(from.0, from.1)), frame.at(Point::new(to.0, to.1)));
        Line::new().set("x1", x1).set("y1", y1).set("x2", x2).set("y2", y2).set("stroke", colour)
    };
    let mut group = Group::new().set("class", "axes");
    let every_m = round_below(half_m / 2.0);
    let ticks = (half_m / every_m).floor() as i32;
    for tick in -ticks..=ticks {
        let at_m = f64::from(tick) * every_m;
        let ((x_px, _), (left_px, y_px)) = (frame.at(Point::new(at_m, 0.0)), frame.at(Point::new(-half_m, at_m)));
        let bottom_px = frame.y(-half_m);
        group = group
            .add(line((at_m, -half_m), (at_m, half_m), palette::GRID))
            .add(line((-half_m, at_m), (half_m, at_m), palette::GRID))
            .add(centred(&format!("{at_m}"), x_px, bottom_px + SMALL_PX + 4.0, SMALL_PX))
            .add(ending(&format!("{at_m}"), left_px - 5.0, y_px + 4.0, SMALL_PX));
    }
    group
}
