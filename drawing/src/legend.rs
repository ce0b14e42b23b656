//! What the signs of a drawing mean, below it, in as many lines as it takes.

use super::marks::{MarkKind, TrackKind, mark_at, track_style};
use super::palette;
use super::shades::ShadeScale;
use super::writing::{self, SMALL_PX, rounded, text};
use svg::node::element::{Circle, Group, Line, Rectangle};

/// A sign is so wide, and a line of the legend so high.
const SIGN_PX: f64 = 26.0;
const LINE_PX: f64 = 20.0;

/// Half the side of the sign of a place.
const PLACE_PX: f64 = 2.6;

/// A sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign {
    /// A wall.
    Wall,
    /// What the map does not know.
    Unknown,
    /// Furniture: in the map or not.
    Furniture(bool),
    /// A door: open or not, and whether the robot's map says otherwise.
    Door { open: bool, misdrawn: bool },
    /// A place with a name: one where the robot is charged or not.
    Place { charges: bool },
    /// A line.
    Track(TrackKind),
    /// A point among many.
    Dot,
    /// Something that stands out.
    Mark(MarkKind),
}

/// Signs and what they mean.
#[derive(Default)]
pub struct Legend {
    entries: Vec<(Sign, String)>,
    /// What the darkness of cells means.
    pub shades: Option<ShadeScale>,
    /// What else is to be said.
    pub note: Option<String>,
}

impl Legend {
    /// One more sign, unless it is there.
    pub fn add(&mut self, sign: Sign, means: &str) {
        if !self.entries.iter().any(|(known, said)| *known == sign && said == means) {
            self.entries.push((sign, means.to_string()));
        }
    }

    /// All of it, the first line from `first_px` on, the others from `left_px`, down from `top_px`; and where it ends.
    pub fn drawn(&self, first_px: f64, left_px: f64, top_px: f64, right_px: f64) -> (Group, f64) {
        let mut group = Group::new().set("class", "legend");
        let (mut x_px, mut y_px) = (first_px, top_px + 10.0);
        let mut place = |width_px: f64| {
            if x_px + width_px > right_px && x_px > left_px {
                (x_px, y_px) = (left_px, y_px + LINE_PX);
            }
            let at = (x_px, y_px);
            x_px += width_px;
            at
        };
        for (sign, means) in &self.entries {
            let width_px = SIGN_PX + 5.0 + writing::width_px(means, SMALL_PX) + 16.0;
            let (x_px, y_px) = place(width_px);
            group =
                group.add(drawn_sign(*sign, x_px, y_px)).add(text(means, x_px + SIGN_PX + 5.0, y_px + 4.0, SMALL_PX));
        }
        if let Some(note) = &self.note {
            let (x_px, y_px) = place(writing::width_px(note, SMALL_PX) + 16.0);
            group = group.add(text(note, x_px, y_px + 4.0, SMALL_PX).set("fill", palette::QUIET));
        }
        let mut bottom_px = y_px + 8.0;
        if let Some(shades) = &self.shades {
            group = group.add(shades.drawn(left_px, bottom_px + 10.0));
            bottom_px += 10.0 + ShadeScale::HEIGHT_PX;
        }
        (group, bottom_px)
    }
}

/// A sign whose left edge is there, and whose middle is at that height.
fn drawn_sign(sign: Sign, x_px: f64, y_px: f64) -> Group {
    let group = Group::new();
    let area = |fill: &str| {
        let area = Rectangle::new().set("x", rounded(x_px + 3.0)).set("y", rounded(y_px - 5.0));
        area.set("width", SIGN_PX - 6.0).set("height", 10).set("fill", fill)
    };
    let line = |colour: &str, width_px: f64| {
        let line = Line::new().set("x1", rounded(x_px)).set("x2", rounded(x_px + SIGN_PX));
        line.set("y1", rounded(y_px)).set("y2", rounded(y_px)).set("stroke", colour).set("stroke-width", width_px)
    };
    let middle_px = (x_px + SIGN_PX / 2.0, y_px);
    match sign {
        Sign::Wall => group.add(line(palette::INK, 4.0)),
        Sign::Unknown => group.add(area(palette::UNKNOWN).set("stroke", palette::GRID)),
        Sign::Furniture(true) => group.add(area(palette::FURNITURE).set("stroke", palette::FURNITURE_EDGE)),
        Sign::Furniture(false) => {
            group.add(area(palette::PAPER).set("stroke", palette::FURNITURE_EDGE).set("stroke-dasharray", "3 2"))
        }
        Sign::Door { open, misdrawn } => group.add(door_style(line(palette::DOOR, 1.0), open, misdrawn)),
        Sign::Place { charges } => group.add(place_sign(middle_px, charges)),
        Sign::Track(kind) => group.add(track_style(line(palette::INK, 1.0), kind, 1.0)),
        Sign::Dot => group.add(dot(middle_px)),
        Sign::Mark(kind) => group.add(mark_at(kind, middle_px, 0.0, 6.0)),
    }
}

/// A door: dots where one goes through, a bar where it is closed; in the colour of the truth where the robot's map says
/// otherwise.
pub fn door_style(line: Line, open: bool, misdrawn: bool) -> Line {
    let line = line.set("stroke", if misdrawn { palette::TRUTH } else { palette::DOOR });
    match open {
        true => line.set("stroke-width", 1.2).set("stroke-dasharray", "2 2"),
        false => line.set("stroke-width", 4),
    }
}

/// From the middle of a place's sign to its edge.
pub fn place_radius_px(charges: bool) -> f64 {
    if charges { 2.0 * PLACE_PX } else { PLACE_PX }
}

/// A place with a name; one where the robot is charged has a ring.
pub fn place_sign((x_px, y_px): (f64, f64), charges: bool) -> Group {
    let square = Rectangle::new()
        .set("x", rounded(x_px - PLACE_PX))
        .set("y", rounded(y_px - PLACE_PX))
        .set("width", 2.0 * PLACE_PX)
        .set("height", 2.0 * PLACE_PX)
        .set("transform", format!("rotate(45 {} {})", rounded(x_px), rounded(y_px)))
        .set("fill", palette::PLACE);
    let sign = Group::new().add(square);
    match charges {
        true => sign.add(
            Circle::new()
                .set("class", "charger")
                .set("cx", rounded(x_px))
                .set("cy", rounded(y_px))
                .set("r", place_radius_px(true))
                .set("fill", "none")
                .set("stroke", palette::PLACE)
                .set("stroke-width", 1.4),
        ),
        false => sign,
    }
}

/// A point among many.
pub fn dot((x_px, y_px): (f64, f64)) -> Circle {
    Circle::new()
        .set("class", "dot")
        .set("cx", rounded(x_px))
        .set("cy", rounded(y_px))
        .set("r", 2.2)
        .set("fill", palette::ESTIMATE)
        .set("fill-opacity", 0.6)
}
