//! Robots, targets and lines of a drawing.

use super::palette;
use super::writing::rounded;
use rpl_robot::geometry::Pose;
use svg::Node;
use svg::node::element::{Circle, Group, Line, Rectangle};

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackKind {
    /// Where the robot was.
    Truth,
    /// Where it believed it was: a band, under the others.
    Estimate,
    /// Where it means to go.
    Plan,
    /// What belongs together.
    Link,
    /// Where a person walks.
    Round,
}

/// What stands out in a drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MarkKind {
    /// The robot, where it is.
    Robot,
    /// The robot, where it believes it is.
    Estimate,
    /// A maximum of the belief.
    Maximum,
    /// Where it means to go.
    Target,
    /// Where it might have gone as well.
    Alternative,
    /// A landmark on a wall.
    Landmark,
    /// A sheet on the floor.
    Marker,
    /// A thing that can be carried.
    Item,
    /// A person, where a round begins.
    Person,
}

/// Something that stands out in a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// What it is.
    pub kind: MarkKind,
    /// Where.
    pub pose_in_map: Pose,
    /// Of a robot's body; of what has none, 0.
    pub radius_m: f64,
    /// What is written beside it.
    pub label: String,
}

impl MarkKind {
    /// What a legend says of it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Estimate => "where it believes it is",
            Self::Maximum => "maximum of the belief, with its share",
            Self::Target => "chosen target",
            Self::Alternative => "other target, with what it pays less [nats]",
            Self::Landmark => "landmark",
            Self::Marker => "marker on the floor",
            Self::Item => "thing that can be carried",
            Self::Person => "person, where the round begins",
        }
    }
}

impl TrackKind {
    /// As a class of the drawing.
    pub fn class(self) -> &'static str {
        match self {
            Self::Truth => "true-path",
            Self::Estimate => "estimated-path",
            Self::Plan => "plan",
            Self::Link => "link",
            Self::Round => "round",
        }
    }
}

/// A line in the style of what it is; `weight` makes lines thinner where there are many.
pub fn track_style<N: Node>(mut line: N, kind: TrackKind, weight: f64) -> N {
    let (colour, width_px, dashes) = match kind {
        TrackKind::Truth => (palette::TRUTH, 1.8 * weight, None),
        TrackKind::Estimate => (palette::ESTIMATE_BAND, 6.0 * weight.max(0.6), None),
        TrackKind::Plan => (palette::TARGET, 2.0, Some("6 4")),
        TrackKind::Link => (palette::ESTIMATE, 1.2, None),
        TrackKind::Round => (palette::PERSON, 1.2, Some("3 3")),
    };
    line.assign("stroke", colour);
    line.assign("stroke-width", rounded(width_px));
    if let Some(dashes) = dashes {
        line.assign("stroke-dasharray", dashes);
    }
    line
}

/// A sign of this size around a point of the sheet, that looks to where the heading says.
pub fn mark_at(kind: MarkKind, (x_px, y_px): (f64, f64), heading_rad: f64, radius_px: f64) -> Group {
    let body = |colour: &str, fill: &str, width_px: f64| {
        let nose_px = (x_px + radius_px * heading_rad.cos(), y_px - radius_px * heading_rad.sin());
        let line = Line::new().set("x1", rounded(x_px)).set("y1", rounded(y_px));
        let line = line.set("x2", rounded(nose_px.0)).set("y2", rounded(nose_px.1));
        Group::new()
            .set("stroke", colour)
            .set("stroke-width", width_px)
            .add(ring((x_px, y_px), radius_px).set("fill", fill))
            .add(line)
    };
    let bare = |colour: &str, width_px: f64| Group::new().set("stroke", colour).set("stroke-width", width_px);
    match kind {
        MarkKind::Robot => body(palette::TRUTH, palette::PAPER, 2.4).set("class", "robot"),
        MarkKind::Estimate => body(palette::ESTIMATE, palette::ESTIMATE_BAND, 2.0).set("class", "estimate"),
        MarkKind::Maximum => body(palette::INK, "none", 1.3).set("class", "maximum"),
        MarkKind::Target => {
            let circle = ring((x_px, y_px), radius_px).set("fill", palette::PAPER);
            let middle = ring((x_px, y_px), 2.4).set("fill", palette::TARGET);
            bare(palette::TARGET, 2.4).set("class", "target").add(circle).add(middle)
        }
        MarkKind::Alternative => bare(palette::TARGET, 1.3)
            .set("class", "alternative")
            .add(ring((x_px, y_px), radius_px * 0.7).set("fill", palette::PAPER)),
        MarkKind::Landmark => {
            bare(palette::PAPER, 1.0).set("class", "dot").add(ring((x_px, y_px), 4.0).set("fill", palette::LANDMARK))
        }
        MarkKind::Marker => bare(palette::LANDMARK, 1.2)
            .set("class", "marker")
            .add(square((x_px, y_px), 4.0).set("fill", palette::PAPER)),
        MarkKind::Item => {
            bare(palette::PAPER, 1.0).set("class", "item").add(square((x_px, y_px), 3.5).set("fill", palette::TARGET))
        }
        MarkKind::Person => {
            let body = ring((x_px, y_px), radius_px).set("fill", palette::PAPER);
            let head = ring((x_px, y_px), radius_px * 0.4).set("fill", palette::PERSON);
            bare(palette::PERSON, 1.6).set("class", "person").add(body).add(head)
        }
    }
}

fn square((x_px, y_px): (f64, f64), half_px: f64) -> Rectangle {
    Rectangle::new()
        .set("x", rounded(x_px - half_px))
        .set("y", rounded(y_px - half_px))
        .set("width", 2.0 * half_px)
        .set("height", 2.0 * half_px)
}

fn ring((x_px, y_px): (f64, f64), radius_px: f64) -> Circle {
    Circle::new().set("cx", rounded(x_px)).set("cy", rounded(y_px)).set("r", rounded(radius_px))
}
