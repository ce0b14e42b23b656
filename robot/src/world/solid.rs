//! The solid bodies of a world: walls cut by doors, door leaves, objects.

use super::blocks::blocks;
use super::{Axis, Door, Object, Rect, SeenBy, Shape, Wall, World};
use crate::geometry::{Point, Vector, distance_m};

/// Thickness of a closed door; it stands in the middle of its wall, so an open and a closed door
/// show the same jambs from both sides.
pub const DOOR_LEAF_M: f64 = 0.04;

/// Outline of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// A simple polygon, counter-clockwise. Two points are a wall without thickness.
    Polygon(Vec<Point>),
    /// A disc.
    Disc {
        /// Its middle.
        centre: Point,
        /// Its radius.
        radius_m: f64,
    },
}

/// Where a body comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidOrigin {
    /// A wall; it never changes.
    Wall,
    /// The leaf of `world.doors[i]`; it is there while the door is closed.
    Door(usize),
    /// `world.objects[i]`.
    Object(usize),
}

/// A body that stops the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Its outline, in the map frame.
    pub outline: Outline,
    /// Where it comes from.
    pub origin: SolidOrigin,
    /// Which sensors see it.
    pub seen_by: SeenBy,
}

const SEEN_BY_ALL: SeenBy = SeenBy { sonar: true, laser: true };

impl World {
    /// All bodies, the leaves of open doors included; walls have the openings of their doors cut
    /// out and reach half their thickness beyond their ends, so that corners are filled.
    pub fn solids(&self) -> Vec<Solid> {
        let walls = self.walls.iter().flat_map(|wall| wall_outlines(wall, &self.doors));
        let recorded = self.recorded.iter().flat_map(|map| blocks(map, usize::MAX)).map(Outline::of_rect);
        let walls =
            walls.chain(recorded).map(|outline| Solid { outline, origin: SolidOrigin::Wall, seen_by: SEEN_BY_ALL });
        let doors = self.doors.iter().enumerate().map(|(index, door)| Solid {
            outline: Outline::of_rect(door.leaf()),
            origin: SolidOrigin::Door(index),
            seen_by: SEEN_BY_ALL,
        });
        let objects = self.objects.iter().enumerate().map(|(index, object)| Solid {
            outline: object.outline(),
            origin: SolidOrigin::Object(index),
            seen_by: object.seen_by,
        });
        walls.chain(doors).chain(objects).collect()
    }

    /// What a body is called in messages.
    pub fn called(&self, origin: SolidOrigin) -> String {
        match origin {
            SolidOrigin::Wall => "a wall".to_owned(),
            SolidOrigin::Door(index) => format!("the closed door of `{}`", self.doors[index].room),
            SolidOrigin::Object(index) => format!("the object `{}`", self.objects[index].name),
        }
    }
}

impl Door {
    /// The floor the closed door stands on.
    pub fn leaf(&self) -> Rect {
        let reach = self.along() * (self.width_m / 2.0) + self.through() * (DOOR_LEAF_M / 2.0);
        Rect { min: self.at - reach, max: self.at + reach }
    }

    /// Along its wall, of unit length.
    pub fn along(&self) -> Vector {
        match self.axis {
            Axis::X => Vector::new(1.0, 0.0),
            Axis::Y => Vector::new(0.0, 1.0),
        }
    }

    /// Across its wall, of unit length.
    pub fn through(&self) -> Vector {
        Vector::new(self.along().y, self.along().x)
    }

    /// The part of a straight wall from `from` to `to` that the door opens, as distances from
    /// `from`; none if it stands elsewhere.
    pub(crate) fn opening_in(&self, from: Point, to: Point, thickness_m: f64) -> Option<(f64, f64)> {
        let along = to - from;
        let length_m = distance_m(from, to);
        let across = match self.axis {
            Axis::X => along.y,
            Axis::Y => along.x,
        };
        if length_m == 0.0 || across.abs() > 1e-6 * length_m {
            return None;
        }
        let offset = self.at - from;
        let distance_along_m = offset.dot(&along) / length_m;
        let distance_across_m = (along.x * offset.y - along.y * offset.x).abs() / length_m;
        let here = distance_across_m <= (thickness_m / 2.0).max(0.02)
            && distance_along_m - self.width_m / 2.0 >= -1e-6
            && distance_along_m + self.width_m / 2.0 <= length_m + 1e-6;
        here.then_some((distance_along_m - self.width_m / 2.0, distance_along_m + self.width_m / 2.0))
    }
}

impl Object {
    /// Its outline as a body.
    pub fn outline(&self) -> Outline {
        match &self.shape {
            Shape::Rect(rect) => Outline::of_rect(*rect),
            Shape::Circle { centre, radius_m } => Outline::Disc { centre: *centre, radius_m: *radius_m },
            Shape::Polygon(corners) => {
                let mut corners = corners.clone();
                if signed_area_m2(&corners) < 0.0 {
                    corners.reverse();
                }
                Outline::Polygon(corners)
            }
        }
    }
}

impl Outline {
    /// The outline of an axis-parallel box.
    pub fn of_rect(rect: Rect) -> Self {
        let Rect { min, max } = rect;
        Self::Polygon(vec![min, Point::new(max.x, min.y), max, Point::new(min.x, max.y)])
    }

    /// Its edges, the body on their left; both sides of a wall without thickness, none for a disc.
    pub fn edges(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let corners: &[Point] = match self {
            Self::Polygon(corners) => corners,
            Self::Disc { .. } => &[],
        };
        (0..corners.len()).map(move |index| (corners[index], corners[(index + 1) % corners.len()]))
    }

    /// Whether the point lies in the body.
    pub fn contains(&self, point: Point) -> bool {
        match self {
            Self::Disc { centre, radius_m } => distance_m(*centre, point) <= *radius_m,
            Self::Polygon(corners) if corners.len() < 3 => false,
            Self::Polygon(_) => {
                self.edges()
                    .filter(|(a, b)| (a.y > point.y) != (b.y > point.y))
                    .filter(|(a, b)| point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x))
                    .count()
                    % 2
                    == 1
            }
        }
    }

    /// Distance from a point to the body; 0 inside.
    pub fn distance_m(&self, point: Point) -> f64 {
        match self {
            Self::Disc { centre, radius_m } => (distance_m(*centre, point) - radius_m).max(0.0),
            Self::Polygon(_) if self.contains(point) => 0.0,
            Self::Polygon(_) => {
                self.edges().map(|(a, b)| distance_to_segment_m(point, a, b)).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// The smallest rectangle around the body.
    pub fn bounds(&self) -> Rect {
        match self {
            Self::Disc { centre, radius_m } => {
                let reach = Vector::new(*radius_m, *radius_m);
                Rect { min: centre - reach, max: centre + reach }
            }
            Self::Polygon(corners) => corners.iter().fold(
                Rect {
                    min: Point::new(f64::INFINITY, f64::INFINITY),
                    max: Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
                },
                |bounds, corner| Rect { min: bounds.min.inf(corner), max: bounds.max.sup(corner) },
            ),
        }
    }
}

/// Distance from a point to the segment between two points.
pub fn distance_to_segment_m(point: Point, a: Point, b: Point) -> f64 {
    (point - nearest_on_segment(point, a, b)).norm_squared().sqrt()
}

/// The point of the segment between two points that is nearest to a third.
pub fn nearest_on_segment(point: Point, a: Point, b: Point) -> Point {
    let along = b - a;
    let length2 = along.norm_squared();
    let share = if length2 > 0.0 { ((point - a).dot(&along) / length2).clamp(0.0, 1.0) } else { 0.0 };
    a + along * share
}

/// The part of a segment in a rectangle, as shares of its length; none if it has no point there (Liang and Barsky).
pub(crate) fn part_within(a: Point, b: Point, rect: Rect) -> Option<(f64, f64)> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let step = b[axis] - a[axis];
        let (low, high) = (rect.min[axis] - a[axis], rect.max[axis] - a[axis]);
        if step == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let (enters, leaves) = if step > 0.0 { (low / step, high / step) } else { (high / step, low / step) };
        from = from.max(enters);
        to = to.min(leaves);
    }
    (from <= to).then_some((from, to))
}

/// Area inside a polygon, negative if its corners run clockwise.
fn signed_area_m2(corners: &[Point]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a.x * b.y - a.y * b.x).sum::<f64>() / 2.0
}

fn wall_outlines(wall: &Wall, doors: &[Door]) -> Vec<Outline> {
    wall.line.windows(2).flat_map(|ends| straight_wall(ends[0], ends[1], wall.thickness_m, doors)).collect()
}

fn straight_wall(from: Point, to: Point, thickness_m: f64, doors: &[Door]) -> Vec<Outline> {
    let length_m = distance_m(from, to);
    if length_m == 0.0 {
        return Vec::new();
    }
    let along = (to - from) / length_m;
    let half = thickness_m / 2.0;
    let left = Vector::new(-along.y, along.x) * half;
    let mut openings: Vec<_> = doors.iter().filter_map(|door| door.opening_in(from, to, thickness_m)).collect();
    openings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut outlines = Vec::new();
    let mut start_m = -half;
    for (opens_m, closes_m) in openings.into_iter().chain([(length_m + half, f64::INFINITY)]) {
        if opens_m > start_m + 1e-9 {
            let (a, b) = (from + along * start_m, from + along * opens_m);
            outlines.push(Outline::Polygon(if half > 0.0 {
                vec![a - left, b - left, b + left, a + left]
            } else {
                vec![a, b]
            }));
        }
        start_m = start_m.max(closes_m);
    }
    outlines
}
