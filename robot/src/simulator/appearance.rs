//! What things look like to a camera: colours, and the light on them.
//!
//! Colours are shares of the light that a surface sends back, red, green and blue; what fluoresces may send
//! back more than there is of its colour. Which of the usual colours a thing has is drawn from the seed.

use super::place_draws::PlaceDraws;
use super::surface::Body;
use crate::geometry::Point;
use crate::world::{MarkerColour, SolidOrigin};

/// Red, green and blue.
pub(super) type Colour = [f64; 3];

const WALL: Colour = [0.78, 0.76, 0.70];
const FLOOR: Colour = [0.46, 0.46, 0.47];
/// What is too far off to be told apart.
const HAZE: Colour = [0.60, 0.60, 0.60];

/// Doors: oak, beech, painted grey, painted red, painted blue.
const DOORS: [Colour; 5] =
    [[0.46, 0.30, 0.17], [0.66, 0.48, 0.30], [0.50, 0.52, 0.54], [0.50, 0.12, 0.10], [0.20, 0.28, 0.45]];

/// Things that stand about: cardboard, steel, white, black, a red crate, a green plant, a blue bin, pine.
const OBJECTS: [Colour; 8] = [
    [0.60, 0.45, 0.28],
    [0.42, 0.43, 0.45],
    [0.80, 0.80, 0.78],
    [0.10, 0.10, 0.11],
    [0.65, 0.10, 0.09],
    [0.18, 0.42, 0.14],
    [0.12, 0.25, 0.60],
    [0.72, 0.55, 0.32],
];

/// Jackets and trousers: red, navy, black, grey, olive, orange, pink, white.
const CLOTHES: [Colour; 8] = [
    [0.70, 0.08, 0.08],
    [0.08, 0.10, 0.25],
    [0.06, 0.06, 0.07],
    [0.40, 0.40, 0.42],
    [0.28, 0.28, 0.14],
    [0.80, 0.35, 0.08],
    [0.80, 0.32, 0.45],
    [0.82, 0.82, 0.80],
];

const SKIN: Colour = [0.70, 0.50, 0.40];

/// Where a person's trousers end ...
const WAIST_M: f64 = 0.9;

/// ... and the jacket.
const NECK_M: f64 = 1.45;

/// The share by which the floor's brightness differs from spot to spot, up or down.
const FLOOR_GRAIN: f64 = 0.06;

/// Spots of the floor are so large.
const GRAIN_M: f64 = 0.05;

/// Lamps and windows are so far apart.
const LAMPS_M: f64 = 3.0;

/// The brightness at a lamp: from a bulb that has failed to a window.
const BRIGHTNESS: [f64; 2] = [0.4, 1.2];

/// The share by which light may be warmer or colder: more red and less blue, or the other way round.
const WARMTH: f64 = 0.15;

/// What a world looks like.
#[derive(Clone, Copy)]
pub(super) struct Appearance {
    draws: PlaceDraws,
}

impl Appearance {
    pub fn new(place_seed: u64) -> Self {
        Self { draws: PlaceDraws::new(place_seed).of(u64::from_le_bytes(*b"coloured")) }
    }

    /// A body, so high above the floor.
    pub fn of_body(&self, body: Body, height_m: f64) -> Colour {
        let choose = |palette: &[Colour], [kind, number, part]: [u64; 3]| {
            let share = self.draws.of(kind).of(number).of(part).uniform();
            palette[(share * palette.len() as f64) as usize]
        };
        match body {
            Body::Solid(SolidOrigin::Wall) => WALL,
            Body::Solid(SolidOrigin::Door(index)) => choose(&DOORS, [0, index as u64, 0]),
            Body::Solid(SolidOrigin::Object(index)) => choose(&OBJECTS, [1, index as u64, 0]),
            Body::Added(index) => choose(&OBJECTS, [2, index as u64, 0]),
            Body::Person(index) if height_m < WAIST_M => choose(&CLOTHES, [3, index as u64, 0]),
            Body::Person(index) if height_m < NECK_M => choose(&CLOTHES, [3, index as u64, 1]),
            Body::Person(_) => SKIN,
        }
    }

    /// The floor.
    pub fn of_floor(&self, at_in_map: Point) -> Colour {
        let grain = self.draws.at(at_in_map.x, GRAIN_M).at(at_in_map.y, GRAIN_M).uniform();
        FLOOR.map(|share| share * (1.0 + FLOOR_GRAIN * (2.0 * grain - 1.0)))
    }

    /// A marker or a landmark.
    pub fn of_marker(colour: MarkerColour) -> Colour {
        match colour {
            MarkerColour::Pink => [1.05, 0.18, 0.62],
            MarkerColour::Orange => [1.10, 0.42, 0.06],
            MarkerColour::Green => [0.35, 1.05, 0.22],
            MarkerColour::Blue => [0.05, 0.42, 0.95],
        }
    }

    /// What is farther off than anything that is drawn.
    pub fn of_haze() -> Colour {
        HAZE
    }

    /// The light so far around a point.
    pub fn light(&self, around_in_map: Point, reach_m: f64) -> Light {
        let first = |at_m: f64| libm::floor((at_m - reach_m) / LAMPS_M);
        let columns = libm::ceil(2.0 * reach_m / LAMPS_M) as usize + 2;
        let (first_x, first_y) = (first(around_in_map.x), first(around_in_map.y));
        let lamp = |number: usize| {
            let (column, row) = ((number % columns) as f64, (number / columns) as f64);
            let draws = self.draws.of(u64::from_le_bytes(*b"lighting"));
            let mut draws = draws.at(first_x + column, 1.0).at(first_y + row, 1.0);
            let brightness = BRIGHTNESS[0] + (BRIGHTNESS[1] - BRIGHTNESS[0]) * draws.uniform();
            let warmth = WARMTH * (2.0 * draws.uniform() - 1.0);
            [brightness * (1.0 + warmth), brightness, brightness * (1.0 - warmth)]
        };
        Light { first_x, first_y, columns, lamps: (0..columns * columns).map(lamp).collect() }
    }
}

/// The light around a place: that of the lamps, and between them something in between.
pub(super) struct Light {
    first_x: f64,
    first_y: f64,
    columns: usize,
    lamps: Vec<Colour>,
}

impl Light {
    /// How bright it is at a point, in each colour.
    pub fn at(&self, point_in_map: Point) -> Colour {
        let most = (self.columns - 2) as f64;
        let x = (point_in_map.x / LAMPS_M - self.first_x).clamp(0.0, most + 1.0);
        let y = (point_in_map.y / LAMPS_M - self.first_y).clamp(0.0, most + 1.0);
        let (column, row) = (x.min(most) as usize, y.min(most) as usize);
        let (right, up) = (x - column as f64, y - row as f64);
        let lamp = |aside: usize, above: usize| &self.lamps[(row + above) * self.columns + column + aside];
        let [a, b, c, d] = [lamp(0, 0), lamp(1, 0), lamp(0, 1), lamp(1, 1)];
        std::array::from_fn(|part| {
            let (below, above) = (a[part] + (b[part] - a[part]) * right, c[part] + (d[part] - c[part]) * right);
            below + (above - below) * up
        })
    }
}
