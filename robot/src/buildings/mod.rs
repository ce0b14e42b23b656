//! Floor plans drawn from a seed: buildings nobody has tuned anything to, to drive in.
//!
//! A building is drawn of a kind, each in a file of its own: its walls, doors, fixtures and furniture are a `draft`,
//! `furniture` puts things in and moves them, `floor` finds the start and the places. A draw that leaves no room for
//! three places is drawn again from the same stream.

mod caves;
mod draft;
mod flats;
mod floor;
mod furniture;
mod halls;
mod lots;
mod offices;
mod recorded;
#[cfg(test)]
mod tests;
mod twins;
mod warehouses;

use crate::geometry::{Point, Pose};
use crate::world::World;
use draft::Draft;
use floor::Floor;
pub use furniture::Furniture;
use rpl_random::Stream;

/// The draws that are made before there is no building.
const DRAWS: usize = 400;

/// The ways to move the furniture of a building that are tried before another building is drawn.
const REARRANGEMENTS: usize = 40;

/// How buildings differ in plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildingKind {
    /// Rooms along one to three corridors.
    Offices,
    /// A single room that is larger than most sensors reach.
    Halls,
    /// Rows of racks with aisles between them.
    Warehouses,
    /// Rough outlines, as a recorded map.
    Caves,
    /// A few small rooms, one leading into the next.
    Flats,
    /// Rooms along a corridor, which half a turn brings onto each other but for few things.
    Twins,
    /// Open ground, its fence missing here and there.
    Lots,
}

impl BuildingKind {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Offices, Self::Halls, Self::Warehouses, Self::Caves, Self::Flats, Self::Twins, Self::Lots];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Offices => "offices",
            Self::Halls => "halls",
            Self::Warehouses => "warehouses",
            Self::Caves => "caves",
            Self::Flats => "flats",
            Self::Twins => "twins",
            Self::Lots => "lots",
        }
    }

    /// Whether its rooms have doors.
    pub fn has_doors(self) -> bool {
        match self {
            Self::Offices | Self::Flats | Self::Twins => true,
            Self::Halls | Self::Warehouses | Self::Caves | Self::Lots => false,
        }
    }

    fn draft(self, stream: &mut Stream, robot_radius_m: f64) -> Draft {
        match self {
            Self::Offices => offices::draw(stream, robot_radius_m),
            Self::Halls => halls::draw(stream),
            Self::Warehouses => warehouses::draw(stream, robot_radius_m),
            Self::Caves => caves::draw(stream, robot_radius_m),
            Self::Flats => flats::draw(stream, robot_radius_m),
            Self::Twins => twins::draw(stream, robot_radius_m),
            Self::Lots => lots::draw(stream),
        }
    }
}

/// A building, and its map.
#[derive(Clone, Debug, PartialEq)]
pub struct Building {
    /// As it was when the map was made: what a robot knows of it.
    pub mapped: World,
    /// As it is. Size, walls, doors, start and places are those of the map.
    pub real: World,
}

/// Nothing that was drawn leaves a robot room.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "none of {draws} buildings drawn from the seed {seed} has three places that a robot of {robot_radius_m} m around \
     its middle gets to"
)]
pub struct NoBuilding {
    /// How many were drawn.
    pub draws: usize,
    /// What from.
    pub seed: u64,
    /// Of the robot.
    pub robot_radius_m: f64,
}

impl Building {
    /// Draws a building of a kind for a robot of this radius, which gets from the start to each of its three places
    /// and back, on the map and on the floor as it is. The same seed gives the same plan and the same places whatever
    /// became of the furniture, unless it can be moved in no way that leaves the places free.
    /// Cost: O(cells of 5 or 10 cm) for each draw, of which few are needed.
    ///
    /// # Errors
    /// No draw leaves the robot room.
    pub fn draw(kind: BuildingKind, seed: u64, robot_radius_m: f64, furniture: Furniture) -> Result<Self, NoBuilding> {
        let mut stream = Stream::new(seed, "building");
        let name = format!("{}-{seed}", kind.name());
        let draft = |stream: &mut Stream| kind.draft(stream, robot_radius_m);
        Self::settled(&name, &mut stream, seed, robot_radius_m, furniture, draft)
    }

    /// The same on a recorded floor plan: start and places are drawn on the piece of floor that hangs together with
    /// the start of that world. As it is mapped it has no furniture; to be rearranged it gets some, which the map shows.
    ///
    /// # Errors
    /// As for [`Building::draw`].
    pub fn on_plan(plan: &World, seed: u64, robot_radius_m: f64, furniture: Furniture) -> Result<Self, NoBuilding> {
        let mut stream = Stream::new(seed, "building");
        let draft = |stream: &mut Stream| recorded::draw(plan, stream, furniture);
        Self::settled(&plan.name, &mut stream, seed, robot_radius_m, furniture, draft)
    }

    fn settled(
        name: &str,
        stream: &mut Stream,
        seed: u64,
        robot_radius_m: f64,
        furniture: Furniture,
        draft: impl Fn(&mut Stream) -> Draft,
    ) -> Result<Self, NoBuilding> {
        let mut moves = Stream::new(seed, "furniture");
        let building = (0..DRAWS).find_map(|_| {
            let draft = draft(stream);
            let mut mapped = draft.world(name, &draft.furniture);
            let floor = Floor::new(&mapped, robot_radius_m);
            floor.settle(&mut mapped, draft.within, stream)?;
            let real = match furniture {
                Furniture::AsMapped => World { crowd: draft.people, ..mapped.clone() },
                Furniture::Rearranged => (0..REARRANGEMENTS).find_map(|_| {
                    let objects = furniture::rearranged(&draft, &mut moves);
                    let start_and_places = (mapped.start_in_map, mapped.places.clone());
                    let mut real = draft.world(name, &objects);
                    (real.start_in_map, real.places) = start_and_places;
                    real.crowd = draft.people;
                    Floor::new(&real, robot_radius_m).joins(&real).then_some(real)
                })?,
            };
            Some(Self { mapped, real })
        });
        building.ok_or(NoBuilding { draws: DRAWS, seed, robot_radius_m })
    }

    /// Poses on the floor as it is that a robot gets to from the start, apart from each other: where it may be put down.
    /// Fewer than asked for where the floor is small.
    pub fn spots(&self, count: usize, robot_radius_m: f64, stream: &mut Stream) -> Vec<Pose> {
        Floor::new(&self.real, robot_radius_m).spots(&self.real, count, stream)
    }

    /// The shortest way from the start over the places, by the map: along straight lines from point to point.
    pub fn way(&self, robot_radius_m: f64) -> Vec<Point> {
        Floor::new(&self.mapped, robot_radius_m).way(&self.mapped)
    }
}
