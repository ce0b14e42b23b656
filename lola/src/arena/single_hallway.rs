//! A single long hallway, to measure what is perceived of it and whether openings are counted right.

use super::bands::Bands;
use super::blocks::Grid;
use super::floor_plan::FloorPlan;
use super::furniture::{Furniture, Start};
use super::hallway::Hallway;
use super::read;
use super::settings::ArenaSettings;
use super::text::{self, Titles};
use rpl_random::Stream;
use rpl_robot::world::World;

/// A hallway of some sixty metres with openings of all kinds on both sides, the robot at its western end.
#[derive(Clone, Debug, PartialEq)]
pub struct SingleHallway {
    /// The world file.
    pub text: String,
    /// The same, read.
    pub world: World,
    /// The hallway, which runs along x.
    pub hallway: Hallway,
}

/// Other hallways that branch off.
const BRANCHES: (usize, usize) = (4, 5);

impl SingleHallway {
    /// The hallway of a seed.
    pub fn draw(seed: u64, settings: &ArenaSettings) -> Self {
        let plan = floor_plan(&mut Stream::new(seed, "hallway layout"), settings);
        let start = Start::Hallway(0);
        let furniture = Furniture::draw(&mut Stream::new(seed, "hallway furniture"), &plan, start, settings);
        let head = [format!("A hallway with openings of all kinds, drawn from seed {seed}.")];
        let titles = Titles { name: "hallway", head: &head, named: &[], people: settings.people };
        let text = text::write(&plan, &furniture, &titles);
        Self { world: read(&text), text, hallway: plan.hallways[0].clone() }
    }
}

fn floor_plan(stream: &mut Stream, settings: &ArenaSettings) -> FloorPlan {
    let branches = BRANCHES.0 + stream.index(BRANCHES.1 - BRANCHES.0 + 1);
    let columns = Bands::draw(stream, branches, settings.walls_mm);
    let rows = Bands::draw(stream, 1, settings.walls_mm);
    let stubs: Vec<(bool, bool)> = (0..branches)
        .map(|_| {
            let both = [(true, true), (true, false), (false, true)];
            both[stream.index(both.len())]
        })
        .collect();
    FloorPlan::of_grid(stream, &Grid::street(columns, rows, &stubs), settings.walls_mm)
}
