//! The floor plan of an arena: hallways, rooms with their doors, foyers, walls.

use super::area::Area;
use super::bands::centimetres;
use super::blocks::Grid;
use super::hallway::{Hallway, LeadsTo, SideFeature};
use super::interval::{Interval, Millimetres};
use super::walls::{WallLine, joined, overlap, shrunk, without, without_foyers};
use crate::feature::{Feature, Side};
use rpl_random::Stream;
use rpl_robot::world::{Axis, Rect};

/// A door between a room and a hallway.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Doorway {
    /// The hallway it leads to.
    pub hallway: usize,
    /// On which side of it, for who walks in the direction of its axis.
    pub side: Side,
    /// Where it begins and ends along that axis.
    pub along_mm: Interval,
    /// The middle of its wall, across that axis.
    pub wall_mm: Millimetres,
    /// Whether it is open.
    pub open: bool,
}

impl Doorway {
    /// Its middle, along the hallway's axis.
    pub fn middle_mm(&self) -> Millimetres {
        (self.along_mm.0 + self.along_mm.1) / 2
    }
}

/// How a room is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    /// By a door.
    Door(Doorway),
    /// It is a foyer, all open to a hallway.
    Foyer {
        /// To which.
        hallway: usize,
        /// On which side of that, for who walks in the direction of its axis.
        side: Side,
        /// From where to where along it.
        along_mm: Interval,
    },
    /// Not at all.
    None,
}

/// A room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArenaRoom {
    /// From middle to middle of its walls.
    pub area: Area,
    /// How it is left.
    pub opening: Opening,
}

/// Where everything that never moves is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FloorPlan {
    /// Width and height of the world.
    pub size_mm: Interval,
    /// How thick the walls are.
    pub walls_mm: Millimetres,
    /// The hallways, with what is on their sides.
    pub hallways: Vec<Hallway>,
    /// The rooms.
    pub rooms: Vec<ArenaRoom>,
    /// The walls; doors stand in them.
    pub walls: Vec<WallLine>,
}

/// Clear width of a door (lola.md, part 10).
const DOOR_MM: Interval = (900, 1000);

/// A door keeps so far from the middles of the walls beside it, and so from the next door and the next corner.
const DOOR_OFF_CORNER_MM: Millimetres = 700;

/// How often a door is open.
const OPEN: f64 = 0.5;

/// Clear width of a foyer.
const FOYER_MM: Interval = (3500, 5500);

/// A foyer keeps so far from crossings and from the ends of its hallway.
const FOYER_OFF_CROSSING_MM: Millimetres = 1000;

/// Two foyers of a hallway are so far apart along it: one can be told to go past the next.
const FOYERS_APART_MM: Millimetres = 4000;

/// How often a room that could be a foyer is one.
const FOYER: f64 = 0.3;

/// The width of a room along its hallway.
const ROOM_MM: Interval = (3000, 5500);

impl FloorPlan {
    /// One of the event's kind.
    pub fn draw(stream: &mut Stream, walls_mm: Millimetres) -> Self {
        let grid = Grid::draw(stream, walls_mm);
        Self::of_grid(stream, &grid, walls_mm)
    }

    /// The hallways of a grid, and rooms in the blocks between them.
    pub(super) fn of_grid(stream: &mut Stream, grid: &Grid, walls_mm: Millimetres) -> Self {
        let mut plan = Self::of_hallways(grid, walls_mm);
        let blocks = grid.blocks();
        for block in &blocks {
            for area in plan.divided(stream, *block) {
                let opening = plan.drawn_opening(stream, area);
                plan.take_room(ArenaRoom { area, opening });
            }
        }
        plan.finish(&blocks);
        plan
    }

    /// Hallways that cross, without any room.
    fn of_hallways(grid: &Grid, walls_mm: Millimetres) -> Self {
        let size_mm = (grid.columns.size_mm(), grid.rows.size_mm());
        let hallways = grid.hallways(walls_mm);
        let mut plan = Self { size_mm, walls_mm, hallways, rooms: Vec::new(), walls: Vec::new() };
        plan.join_hallways();
        let (x_mm, y_mm) = (grid.columns.reach_mm(), grid.rows.reach_mm());
        plan.walls.extend(edges(Area { x_mm, y_mm }));
        plan
    }

    /// Sorts what is on the sides, and builds the walls.
    fn finish(&mut self, blocks: &[Area]) {
        for hallway in &mut self.hallways {
            hallway.sides.iter_mut().for_each(|side| side.sort_by_key(|feature| feature.from_mm));
        }
        let rooms = self.rooms.iter().map(|room| room.area);
        let walls: Vec<WallLine> = rooms.chain(blocks.iter().copied()).flat_map(edges).collect();
        self.walls.extend(walls);
        self.walls = without_foyers(joined(&self.walls), &self.hallways, self.walls_mm);
    }

    /// The clear floor of a room.
    pub fn floor(&self, room: usize) -> Rect {
        self.clear_area(room).rect()
    }

    /// The same.
    pub fn clear_area(&self, room: usize) -> Area {
        self.rooms[room].area.shrunk(self.walls_mm / 2)
    }

    /// The clear floor of a hallway.
    pub fn hallway_area(&self, hallway: usize) -> Area {
        let Hallway { axis, along_mm, across_mm, .. } = self.hallways[hallway];
        match axis {
            Axis::X => Area { x_mm: along_mm, y_mm: across_mm },
            Axis::Y => Area { x_mm: across_mm, y_mm: along_mm },
        }
    }

    /// Where hallways cross or meet, each is a feature of the other's side.
    fn join_hallways(&mut self) {
        for one in 0..self.hallways.len() {
            for other in 0..self.hallways.len() {
                let (this, that) = (&self.hallways[one], &self.hallways[other]);
                if this.axis == that.axis || !meets(this, that) {
                    continue;
                }
                let (from_mm, to_mm) = that.across_mm;
                let feature = |leads_to| SideFeature { feature: Feature::Hallway, from_mm, to_mm, leads_to };
                // On which side of `this` the floor of `that` goes on.
                let goes_up = that.along_mm.1 > this.across_mm.1;
                let goes_down = that.along_mm.0 < this.across_mm.0;
                for (goes_on, up) in [(goes_up, true), (goes_down, false)] {
                    if goes_on {
                        let side = self.hallways[one].side_towards(up);
                        self.hallways[one].side_mut(side).push(feature(LeadsTo::Hallway(other)));
                    }
                }
            }
        }
    }

    /// The rooms of a block: a row along each hallway beside it.
    fn divided(&self, stream: &mut Stream, block: Area) -> Vec<Area> {
        let [left, right, below, above] = edges(block).map(|edge| self.hallway_beside(edge).is_some());
        let mut rest = block;
        let mut rooms = Vec::new();
        // The depth of a strip of rooms, from and to; it leaves a row beside it.
        let strip_mm = (3000, 4200);
        let has_room = |rest: Area| rest.x_mm.1 - rest.x_mm.0 > 2 * strip_mm.1;
        if left && below && above && has_room(rest) && stream.chance(0.5) {
            let to_mm = rest.x_mm.0 + centimetres(stream, strip_mm);
            rooms.extend(column(stream, Area { x_mm: (rest.x_mm.0, to_mm), ..rest }));
            rest.x_mm.0 = to_mm;
        }
        if right && below && above && has_room(rest) && stream.chance(0.5) {
            let from_mm = rest.x_mm.1 - centimetres(stream, strip_mm);
            rooms.extend(column(stream, Area { x_mm: (from_mm, rest.x_mm.1), ..rest }));
            rest.x_mm.1 = from_mm;
        }
        let (low_mm, high_mm) = rest.y_mm;
        match (below, above, left || right) {
            (true, true, _) if high_mm - low_mm >= 6000 => {
                let middle_mm = (low_mm + high_mm) / 2 + 10 * (stream.index(101) as Millimetres - 50);
                for y_mm in [(low_mm, middle_mm), (middle_mm, high_mm)] {
                    rooms.extend(row(stream, Area { y_mm, ..rest }));
                }
            }
            (true, _, _) | (_, true, _) => rooms.extend(row(stream, rest)),
            (false, false, true) => rooms.extend(column(stream, rest)),
            (false, false, false) => rooms.push(rest),
        }
        rooms
    }

    /// The hallway whose wall an edge of a room is, with its side, and the part of the wall beside its floor.
    fn hallway_beside(&self, edge: WallLine) -> Option<(usize, Side, Interval)> {
        let half_mm = self.walls_mm / 2;
        self.hallways.iter().enumerate().find_map(|(index, hallway)| {
            let is_up = edge.across_mm == hallway.across_mm.1 + half_mm;
            let is_down = edge.across_mm == hallway.across_mm.0 - half_mm;
            let along_mm = (edge.along_mm.0.max(hallway.along_mm.0), edge.along_mm.1.min(hallway.along_mm.1));
            let is_beside = hallway.axis == edge.axis && (is_up || is_down) && along_mm.1 - along_mm.0 > 1000;
            is_beside.then(|| (index, hallway.side_towards(is_up), along_mm))
        })
    }

    /// Foyer, door, or none.
    fn drawn_opening(&self, stream: &mut Stream, area: Area) -> Opening {
        let beside: Vec<_> = edges(area)
            .into_iter()
            .filter_map(|edge| {
                let (hallway, side, along_mm) = self.hallway_beside(edge)?;
                Some((edge, hallway, side, self.span(hallway, along_mm)?))
            })
            .collect();
        if beside.is_empty() {
            return Opening::None;
        }
        let (edge, hallway, side, span_mm) = beside[stream.index(beside.len())];
        if self.can_be_foyer(edge, hallway) && stream.chance(FOYER) {
            return Opening::Foyer { hallway, side, along_mm: shrunk(edge.along_mm, self.walls_mm / 2) };
        }
        let width_mm = centimetres(stream, DOOR_MM);
        let from_mm = centimetres(stream, (span_mm.0, span_mm.1 - width_mm));
        let along_mm = (from_mm, from_mm + width_mm);
        let open = stream.chance(OPEN);
        Opening::Door(Doorway { hallway, side, along_mm, wall_mm: edge.across_mm, open })
    }

    /// The longest part of a wall beside a hallway where a door may stand: off the wall's ends, and off what
    /// crosses the hallway.
    fn span(&self, hallway: usize, along_mm: Interval) -> Option<Interval> {
        let mut free = vec![shrunk(along_mm, DOOR_OFF_CORNER_MM)];
        for crossing_mm in self.crossings_mm(hallway) {
            free = without(&free, shrunk(crossing_mm, -DOOR_OFF_CORNER_MM));
        }
        let longest = free.into_iter().max_by_key(|(from_mm, to_mm)| to_mm - from_mm)?;
        (longest.1 - longest.0 >= DOOR_MM.1).then_some(longest)
    }

    /// Where hallways cross or meet a hallway, along it.
    fn crossings_mm(&self, hallway: usize) -> impl Iterator<Item = Interval> {
        let features = self.hallways[hallway].sides.iter().flatten();
        let crossings = features.filter(|found| found.feature == Feature::Hallway);
        crossings.map(|found| (found.from_mm, found.to_mm))
    }

    /// Where foyers are beside a hallway, on either side.
    fn foyers_mm(&self, hallway: usize) -> impl Iterator<Item = Interval> {
        let features = self.hallways[hallway].sides.iter().flatten();
        let foyers = features.filter(|found| found.feature == Feature::Foyer);
        foyers.map(|found| (found.from_mm, found.to_mm))
    }

    fn can_be_foyer(&self, edge: WallLine, hallway: usize) -> bool {
        let (from_mm, to_mm) = shrunk(edge.along_mm, self.walls_mm / 2);
        let (least_mm, most_mm) = FOYER_MM;
        let off_mm = shrunk((from_mm, to_mm), -FOYER_OFF_CROSSING_MM);
        let hallway_mm = self.hallways[hallway].along_mm;
        (least_mm..=most_mm).contains(&(to_mm - from_mm))
            && hallway_mm.0 <= off_mm.0
            && off_mm.1 <= hallway_mm.1
            && !self.crossings_mm(hallway).any(|crossing_mm| overlap(crossing_mm, off_mm))
            && !self.foyers_mm(hallway).any(|foyer_mm| overlap(foyer_mm, shrunk((from_mm, to_mm), -FOYERS_APART_MM)))
    }

    /// Adds a room, and what is seen of it from its hallway.
    fn take_room(&mut self, room: ArenaRoom) {
        let leads_to = LeadsTo::Room(self.rooms.len());
        let seen = match room.opening {
            Opening::Door(Doorway { hallway, side, along_mm, open, .. }) => {
                Some((hallway, side, along_mm, if open { Feature::OpenDoor } else { Feature::ClosedDoor }))
            }
            Opening::Foyer { hallway, side, along_mm } => Some((hallway, side, along_mm, Feature::Foyer)),
            Opening::None => None,
        };
        if let Some((hallway, side, (from_mm, to_mm), feature)) = seen {
            self.hallways[hallway].side_mut(side).push(SideFeature { feature, from_mm, to_mm, leads_to });
        }
        self.rooms.push(room);
    }
}

/// Whether two hallways of different axes share a square, or one ends in the other.
fn meets(one: &Hallway, other: &Hallway) -> bool {
    let within = |across_mm: Interval, along_mm: Interval| along_mm.0 <= across_mm.0 && across_mm.1 <= along_mm.1;
    within(other.across_mm, one.along_mm) && within(one.across_mm, other.along_mm)
}

/// Left, right, lower and upper edge.
fn edges(Area { x_mm, y_mm }: Area) -> [WallLine; 4] {
    [
        WallLine { axis: Axis::Y, across_mm: x_mm.0, along_mm: y_mm },
        WallLine { axis: Axis::Y, across_mm: x_mm.1, along_mm: y_mm },
        WallLine { axis: Axis::X, across_mm: y_mm.0, along_mm: x_mm },
        WallLine { axis: Axis::X, across_mm: y_mm.1, along_mm: x_mm },
    ]
}

/// Rooms side by side along x.
fn row(stream: &mut Stream, area: Area) -> Vec<Area> {
    pieces(stream, area.x_mm).into_iter().map(|x_mm| Area { x_mm, ..area }).collect()
}

/// Rooms side by side along y.
fn column(stream: &mut Stream, area: Area) -> Vec<Area> {
    pieces(stream, area.y_mm).into_iter().map(|y_mm| Area { y_mm, ..area }).collect()
}

/// Cuts a length into pieces of the width of rooms, of different lengths; one that is too short stays whole.
fn pieces(stream: &mut Stream, (from_mm, to_mm): Interval) -> Vec<Interval> {
    let length_mm = to_mm - from_mm;
    let (least_mm, most_mm) = ROOM_MM;
    let fewest = (length_mm + most_mm - 1) / most_mm;
    let most = (length_mm / least_mm).max(fewest);
    let count = fewest + stream.index(usize::try_from(most - fewest + 1).unwrap_or(1)) as Millimetres;
    // How far each cut may be off without a piece becoming too short.
    let play_cm = ((length_mm / count - least_mm) / 20).max(0);
    let mut cuts = vec![from_mm];
    for cut in 1..count {
        let off_cm = stream.index(usize::try_from(2 * play_cm + 1).unwrap_or(1)) as Millimetres - play_cm;
        cuts.push(from_mm + length_mm * cut / count / 10 * 10 + 10 * off_cm);
    }
    cuts.push(to_mm);
    cuts.windows(2).map(|ends| (ends[0], ends[1])).collect()
}
