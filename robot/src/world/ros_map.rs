//! Maps of the ROS map_server: a YAML file beside an image.

use super::image::{GreyImage, ImageError};
use super::yaml::{self, YamlPart, YamlValue};
use super::{LARGEST_M, SMALLEST_M};
use crate::file_text::{FileFaults, Finding, Findings, nearest};
use crate::geometry::{Point, Pose};
use crate::occupancy::{Cell, OccupancyGrid};
use std::ops::Range;

/// No corner of a map is farther from the origin: a micrometre would no longer be told apart.
const FARTHEST_M: f64 = 1e6;

/// Points along each edge of a cell at which a turned map is looked at.
const LOOKS: usize = 3;

const KEYS: [&str; 7] = ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];

/// How shades become cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapMode {
    /// Occupied, free, and unknown in between.
    Trinary,
    /// The same here: what lies between the thresholds is neither free nor occupied for sure.
    Scale,
    /// The value of a pixel is the occupancy in percent; above 100 it is unknown.
    Raw,
}

/// The YAML file of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct RosMap {
    /// Name of the image, relative to the file.
    pub image: String,
    /// Edge of a pixel.
    pub resolution_m: f64,
    /// The lower left corner of the lower left pixel, and how far the image is turned around it.
    pub origin_in_map: Pose,
    /// Whether black is free.
    pub negate: bool,
    /// An occupancy above this is occupied.
    pub occupied_thresh: f64,
    /// An occupancy below this is free.
    pub free_thresh: f64,
    /// How shades become cells.
    pub mode: MapMode,
}

impl RosMap {
    /// Reads the text of the YAML file; `file_name` is for the messages only.
    ///
    /// # Errors
    /// All faults at once: unknown and missing keys, and values that make no sense.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, FileFaults> {
        let entries = yaml::read(file_name, text)?;
        let mut reader = MapReader { file: file_name, text, entries: &entries, findings: Findings::default() };
        reader.only_known_keys();
        let map = reader.map();
        reader.findings.or_value(map)
    }

    /// What a pixel means; the thresholds themselves are unknown.
    pub(super) fn cell(&self, shade: f32, is_transparent: bool) -> Cell {
        let Some(occupancy) = self.occupancy(shade).filter(|_| self.mode != MapMode::Scale || !is_transparent) else {
            return Cell::Unknown;
        };
        if occupancy > self.occupied_thresh {
            Cell::Occupied
        } else if occupancy < self.free_thresh {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }

    /// How surely a shade is occupied, from 0 to 1; none if it says that it does not know.
    pub(super) fn occupancy(&self, shade: f32) -> Option<f64> {
        match self.mode {
            MapMode::Raw => {
                let value = f64::from(shade) * 255.0;
                (value <= 100.5).then(|| libm::round(value) / 100.0)
            }
            MapMode::Trinary | MapMode::Scale if self.negate => Some(f64::from(shade)),
            MapMode::Trinary | MapMode::Scale => Some(1.0 - f64::from(shade)),
        }
    }

    /// The map as a grid along the axes of the map frame. A turned image is drawn into the cells it
    /// touches: a cell is occupied if one of nine points in it is, and free if its middle is.
    pub fn grid(&self, image: &GreyImage) -> OccupancyGrid {
        let pixels = OccupancyGrid {
            resolution_m: self.resolution_m,
            origin_in_frame: Point::origin(),
            columns: image.columns,
            rows: image.rows,
            cells: self.cells_upwards(image),
        };
        if self.origin_in_map.heading_rad == 0.0 {
            return OccupancyGrid { origin_in_frame: self.origin_in_map.point(), ..pixels };
        }
        turned(&pixels, self.origin_in_map)
    }

    /// Cells with the lowest row first.
    fn cells_upwards(&self, image: &GreyImage) -> Vec<Cell> {
        let cells_of = |is_transparent: bool| -> Vec<Cell> {
            (0..=image.white).map(|value| self.cell(image.shade(value), is_transparent)).collect()
        };
        let (opaque, transparent) = (cells_of(false), cells_of(true));
        let mut cells = Vec::with_capacity(image.values.len());
        for row in (0..image.rows).rev() {
            let pixels = row * image.columns..(row + 1) * image.columns;
            cells.extend(pixels.map(|pixel| {
                let is_transparent = image.transparent.get(pixel).copied().unwrap_or(false);
                let meant = if is_transparent { &transparent } else { &opaque };
                meant[usize::from(image.values[pixel])]
            }));
        }
        cells
    }

    /// Whether the image makes a map of a size that a robot can drive in.
    ///
    /// # Errors
    /// How large the map is, and what it may be.
    pub fn check_size(&self, image: &GreyImage) -> Result<(), ImageError> {
        let (width_m, height_m) = (image.columns as f64 * self.resolution_m, image.rows as f64 * self.resolution_m);
        // A turned map reaches farther.
        let largest_m = if self.origin_in_map.heading_rad == 0.0 { LARGEST_M } else { LARGEST_M / 2.0 };
        let fits = |length_m: f64| (SMALLEST_M..=largest_m).contains(&length_m);
        if fits(width_m) && fits(height_m) {
            return Ok(());
        }
        let message = format!(
            "{} by {} pixels of {} m are a map of {width_m:.3} m by {height_m:.3} m; a map has from {SMALLEST_M} m to {largest_m} m \
             along each side: set `resolution`, the edge of a pixel in metres, or crop the image",
            image.columns, image.rows, self.resolution_m
        );
        Err(ImageError { message })
    }
}

/// A grid turned around its lower left corner and brought to a place.
fn turned(pixels: &OccupancyGrid, origin_in_map: Pose) -> OccupancyGrid {
    let (width_m, height_m) = (pixels.columns as f64 * pixels.resolution_m, pixels.rows as f64 * pixels.resolution_m);
    let corners = [(0.0, 0.0), (width_m, 0.0), (0.0, height_m), (width_m, height_m)];
    let corners = corners.map(|(x, y)| origin_in_map.transform(Point::new(x, y)));
    let least = |axis: usize| corners.iter().map(|corner| corner[axis]).fold(f64::INFINITY, f64::min);
    let most = |axis: usize| corners.iter().map(|corner| corner[axis]).fold(f64::NEG_INFINITY, f64::max);
    let count = |axis: usize| libm::ceil((most(axis) - least(axis)) / pixels.resolution_m - 1e-9).max(1.0) as usize;
    let lower_left = Point::new(least(0), least(1));
    let mut grid = OccupancyGrid::filled(lower_left, pixels.resolution_m, count(0), count(1), Cell::Unknown);
    let in_image = origin_in_map.inverse();
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let centre = grid.centre(column, row);
            let look = |step: usize| ((step as f64 + 0.5) / LOOKS as f64 - 0.5) * pixels.resolution_m;
            let is_occupied = (0..LOOKS * LOOKS).any(|index| {
                let at = Point::new(centre.x + look(index % LOOKS), centre.y + look(index / LOOKS));
                pixels.at(in_image.transform(at)) == Cell::Occupied
            });
            let cell = if is_occupied { Cell::Occupied } else { pixels.at(in_image.transform(centre)) };
            grid.set(column, row, cell);
        }
    }
    grid
}

/// Reads values and notes what is wrong with them.
struct MapReader<'t> {
    file: &'t str,
    text: &'t str,
    entries: &'t [(YamlPart, YamlValue)],
    findings: Findings,
}

impl MapReader<'_> {
    fn note(&mut self, span: Range<usize>, key: &str, message: String, help: &str) {
        let (file, text) = (self.file, self.text);
        self.findings.add(|| Finding::new(file, text, span, key, message, help));
    }

    fn only_known_keys(&mut self) {
        for (index, (key, _)) in self.entries.iter().enumerate() {
            let help = format!("the keys of a map are {}", KEYS.join(", "));
            if !KEYS.contains(&key.text.as_str()) {
                let message = match nearest(&key.text, KEYS.into_iter()) {
                    Some(meant) => format!("unknown key `{}`, did you mean `{meant}`?", key.text),
                    None => format!("unknown key `{}`", key.text),
                };
                self.note(key.span.clone(), &key.text, message, &help);
            } else if self.entries[..index].iter().any(|(earlier, _)| earlier.text == key.text) {
                self.note(key.span.clone(), &key.text, format!("`{}` stands here a second time", key.text), "");
            }
        }
    }

    fn map(&mut self) -> Option<RosMap> {
        let image = self.one("image", "map.pgm").map(|part| part.text);
        let resolution_m = self.number("resolution", "0.05", |metres| metres > 0.0, "a length above 0 m");
        let origin_in_map = self.origin();
        let negate = self.negate();
        let share = |value: f64| (0.0..=1.0).contains(&value);
        let occupied_thresh = self.number("occupied_thresh", "0.65", share, "from 0 to 1");
        let free_thresh = self.number("free_thresh", "0.196", share, "from 0 to 1");
        if let (Some(free), Some(occupied)) = (free_thresh, occupied_thresh)
            && free > occupied
        {
            let message = format!("`free_thresh` is {free}, above `occupied_thresh`, {occupied}");
            self.note(self.span("free_thresh"), "free_thresh", message, "usual values are 0.196 and 0.65");
        }
        let mode = self.mode();
        Some(RosMap {
            image: image?,
            resolution_m: resolution_m?,
            origin_in_map: origin_in_map?,
            negate: negate?,
            occupied_thresh: occupied_thresh?,
            free_thresh: free_thresh?,
            mode: mode?,
        })
    }

    fn value(&self, key: &str) -> Option<&YamlValue> {
        self.entries.iter().find(|(known, _)| known.text == key).map(|(_, value)| value)
    }

    fn span(&self, key: &str) -> Range<usize> {
        self.value(key).map_or(0..0, YamlValue::span)
    }

    fn one(&mut self, key: &str, example: &str) -> Option<YamlPart> {
        let help = format!("write it like `{key}: {example}`");
        match self.value(key) {
            Some(YamlValue::One(part)) => return Some(part.clone()),
            Some(YamlValue::List(..)) => {
                self.note(self.span(key), key, format!("`{key}` must be a single value"), &help)
            }
            None => self.note(0..0, key, format!("`{key}` is missing"), &help),
        }
        None
    }

    fn number(&mut self, key: &str, example: &str, fits: impl Fn(f64) -> bool, what: &str) -> Option<f64> {
        let part = self.one(key, example)?;
        match part.text.parse::<f64>() {
            Ok(number) if number.is_finite() && fits(number) => Some(number),
            _ => {
                let message = format!("`{key}` must be {what}, found {}", part.text);
                self.note(part.span, key, message, &format!("write it like `{key}: {example}`"));
                None
            }
        }
    }

    fn origin(&mut self) -> Option<Pose> {
        let help = "write it like `origin: [-10.0, -10.0, 0.0]`: x, y and the turn of the lower left corner";
        let Some(YamlValue::List(parts, _)) = self.value("origin") else {
            let found = if self.value("origin").is_some() { "must be a list of three numbers" } else { "is missing" };
            self.note(self.span("origin"), "origin", format!("`origin` {found}"), help);
            return None;
        };
        let numbers: Vec<f64> = parts.iter().filter_map(|part| part.text.parse().ok()).collect();
        match numbers[..] {
            [x, y, turn] if parts.len() == 3 && numbers.iter().all(|number| number.abs() <= FARTHEST_M) => {
                Some(Pose::new(x, y, turn))
            }
            _ => {
                let found: Vec<&str> = parts.iter().map(|part| part.text.as_str()).collect();
                let message =
                    format!("`origin` must be three finite numbers up to 1,000,000, found [{}]", found.join(", "));
                self.note(self.span("origin"), "origin", message, help);
                None
            }
        }
    }

    fn negate(&mut self) -> Option<bool> {
        let part = self.one("negate", "0")?;
        match part.text.as_str() {
            "0" | "false" | "False" => Some(false),
            "1" | "true" | "True" => Some(true),
            found => {
                let message = format!("`negate` must be 0 or 1, found {found}");
                self.note(part.span, "negate", message, "0: black is occupied; 1: white is");
                None
            }
        }
    }

    fn mode(&mut self) -> Option<MapMode> {
        if self.value("mode").is_none() {
            return Some(MapMode::Trinary);
        }
        let part = self.one("mode", "trinary")?;
        match part.text.as_str() {
            "trinary" => Some(MapMode::Trinary),
            "scale" => Some(MapMode::Scale),
            "raw" => Some(MapMode::Raw),
            found => {
                let meant = nearest(found, ["trinary", "scale", "raw"].into_iter());
                let advice = meant.map_or(String::new(), |meant| format!(", did you mean `{meant}`?"));
                let message = format!("unknown mode `{found}`{advice}");
                self.note(part.span, "mode", message, "the modes are trinary, scale and raw");
                None
            }
        }
    }
}
