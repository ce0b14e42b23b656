//! Doors found closed: what the sensors see standing in a doorway for a while is remembered, and
//! planned around where there is another way.

use crate::geometry::{Point, Vector, distance_m};
use crate::world::World;
use serde::{Deserialize, Serialize};

/// A doorway is judged from up to so far, by what is remembered of it.
const LOOK_M: f64 = 2.5;
/// Points this near to a jamb, along the wall, may be its echo in a wide cone ...
const JAMB_M: f64 = 0.25;
/// ... but none farther from it than this share of the robot's width: what is left out must not look like a gap to it.
const JAMB_SHARE: f64 = 0.5;
/// Points this far before or behind the wall count as standing in the doorway: leaf, somebody's
/// feet, and the error of the estimate.
const DEPTH_M: f64 = 0.25;
/// How long a door must be seen shut to count as closed: longer than a person takes to walk through.
const SHUT_S: f64 = 2.0;
/// How long it stays closed for the robot; then somebody may have opened it.
const CLOSED_S: f64 = 180.0;
/// From up to this distance before it the sound comes straight back from a closed leaf: if nothing is seen there for
/// this time, the door is open.
const BEFORE_M: f64 = 1.2;
const OPEN_S: f64 = 1.0;
/// Between the points of a barrier across a closed door.
const BARRIER_GRAIN_M: f64 = 0.1;

/// The opening of a door, in the map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doorway {
    /// The door, as an index into the world's doors.
    pub door: usize,
    /// Its middle.
    pub at: Point,
    /// Along the wall, of unit length.
    pub along: Vector,
    /// Clear width.
    pub width_m: f64,
}

impl Doorway {
    /// The doors of a world that its map shows open.
    pub fn all(world: &World) -> Vec<Self> {
        let open = world.doors.iter().enumerate().filter(|(_, door)| door.mapped_open);
        open.map(|(index, door)| Self { door: index, at: door.at, along: door.along(), width_m: door.width_m })
            .collect()
    }

    /// Whether no robot of that width gets through between these points and the jambs, echoes of the jambs aside.
    fn is_shut_by(&self, points_in_map: &[Point], robot_width_m: f64) -> bool {
        let (half_m, jamb_m) = (self.width_m / 2.0, JAMB_M.min(JAMB_SHARE * robot_width_m));
        let across = Vector::new(-self.along.y, self.along.x);
        let mut places_m: Vec<f64> = points_in_map
            .iter()
            .map(|point| point - self.at)
            .filter(|offset| offset.dot(&across).abs() <= DEPTH_M && offset.dot(&self.along).abs() < half_m - jamb_m)
            .map(|offset| offset.dot(&self.along))
            .chain([-half_m, half_m])
            .collect();
        places_m.sort_by(f64::total_cmp);
        places_m.windows(2).all(|pair| pair[1] - pair[0] < robot_width_m)
    }

    /// Whether somebody there would soon see it open.
    pub fn is_at_hand(&self, here: Point) -> bool {
        distance_m(self.at, here) <= BEFORE_M
    }

    /// Whether somebody there looks straight at the leaf, or stands in the opening.
    fn is_before(&self, here: Point) -> bool {
        let offset = here - self.at;
        let across = Vector::new(-self.along.y, self.along.x);
        offset.dot(&across).abs() <= BEFORE_M && offset.dot(&self.along).abs() < self.width_m / 2.0 - JAMB_M
    }

    /// Points across the opening that leave no gap.
    fn barrier(&self) -> impl Iterator<Item = Point> + use<'_> {
        let steps = libm::ceil(self.width_m / BARRIER_GRAIN_M).max(1.0);
        (0..=steps as usize).map(move |step| self.at + self.along * (self.width_m * (step as f64 / steps - 0.5)))
    }
}

/// What was seen of one door.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct SeenDoor {
    door: usize,
    /// How long it has been seen shut, less the time it was seen open since.
    shut_s: f64,
    /// How long it has been seen open from straight before it, without a break.
    open_s: f64,
    closed_until_s: f64,
}

/// Doors that were seen shut.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DoorMemory {
    /// Sorted by door.
    seen: Vec<SeenDoor>,
}

impl DoorMemory {
    /// Forgets how doors stand, by their number.
    pub fn forget_where(&mut self, is_meant: impl Fn(usize) -> bool) {
        self.seen.retain(|seen| !is_meant(seen.door));
    }

    /// Looks at the doorways at hand; `for_s` since the last look. A doorway is shut when no gap is
    /// wide enough for the robot. A leaf seen from the side may throw all sound away, so only from
    /// straight before it a door is seen open again.
    pub fn look(
        &mut self,
        doorways: &[Doorway],
        here: Point,
        points_in_map: &[Point],
        robot_width_m: f64,
        now_s: f64,
        for_s: f64,
    ) {
        for doorway in doorways.iter().filter(|doorway| distance_m(doorway.at, here) <= LOOK_M) {
            let is_shut = doorway.is_shut_by(points_in_map, robot_width_m);
            let seen = self.seen_mut(doorway.door);
            seen.shut_s = if is_shut { seen.shut_s + for_s } else { (seen.shut_s - 2.0 * for_s).max(0.0) };
            seen.open_s = if is_shut || !doorway.is_before(here) { 0.0 } else { seen.open_s + for_s };
            if seen.shut_s >= SHUT_S {
                seen.shut_s = SHUT_S;
                seen.closed_until_s = now_s + CLOSED_S;
            } else if seen.open_s >= OPEN_S {
                seen.closed_until_s = now_s;
            }
        }
        self.seen.retain(|seen| seen.shut_s > 0.0 || seen.closed_until_s > now_s);
    }

    fn seen_mut(&mut self, door: usize) -> &mut SeenDoor {
        let index = match self.seen.binary_search_by_key(&door, |seen| seen.door) {
            Ok(index) => index,
            Err(index) => {
                self.seen.insert(index, SeenDoor { door, shut_s: 0.0, open_s: 0.0, closed_until_s: 0.0 });
                index
            }
        };
        &mut self.seen[index]
    }

    /// The doors remembered as closed, as indices into the world's doors, in order.
    pub fn closed(&self, now_s: f64) -> Vec<usize> {
        self.seen.iter().filter(|seen| seen.closed_until_s > now_s).map(|seen| seen.door).collect()
    }
}

/// What stands in the way where these doors, as indices into the world's doors, are closed.
pub fn barriers(doorways: &[Doorway], doors: &[usize]) -> Vec<Point> {
    doorways.iter().filter(|doorway| doors.contains(&doorway.door)).flat_map(Doorway::barrier).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doorway() -> Doorway {
        Doorway { door: 3, at: Point::new(2.0, 1.0), along: Vector::new(0.0, 1.0), width_m: 0.9 }
    }

    fn look_for(memory: &mut DoorMemory, points: &[Point], from_s: f64, seconds: f64) {
        for step in 1..=(seconds / 0.5) as u32 {
            let now_s = from_s + 0.5 * f64::from(step);
            memory.look(&[doorway()], Point::new(1.0, 1.0), points, 0.53, now_s, 0.5);
        }
    }

    #[test]
    fn a_door_seen_shut_for_a_while_is_closed_and_opens_again_in_time() {
        let leaf: Vec<Point> = (-3..=3).map(|step| Point::new(2.02, 1.0 + 0.1 * f64::from(step))).collect();
        let mut memory = DoorMemory::default();
        look_for(&mut memory, &leaf, 0.0, 1.5);
        assert_eq!(memory.closed(1.5), []);
        look_for(&mut memory, &leaf, 1.5, 2.5);
        assert_eq!(memory.closed(4.0), [3]);
        let barriers = barriers(&[doorway()], &[3]);
        assert!(barriers.len() >= 10 && barriers.windows(2).all(|pair| distance_m(pair[0], pair[1]) < 0.11));
        assert_eq!(memory.closed(4.0 + CLOSED_S + 1.0), []);
    }

    #[test]
    fn a_closed_door_is_seen_open_again_only_from_straight_before_it() {
        let shut = SeenDoor { door: 3, shut_s: SHUT_S, open_s: 0.0, closed_until_s: 100.0 };
        let closed_after = |here: Point, looks: u32| {
            let mut memory = DoorMemory { seen: vec![shut] };
            for look in 1..=looks {
                memory.look(&[doorway()], here, &[], 0.53, 0.5 * f64::from(look), 0.5);
            }
            memory.closed(0.5 * f64::from(looks))
        };
        assert_eq!(closed_after(Point::new(1.0, 1.1), 1), [3]);
        assert_eq!(closed_after(Point::new(1.0, 1.1), 2), []);
        for unsure in [Point::new(1.0, 1.6), Point::new(0.5, 1.0)] {
            assert_eq!(closed_after(unsure, 20), [3]);
        }
    }

    #[test]
    fn jambs_and_passers_by_shut_no_door() {
        let jambs = [Point::new(1.95, 1.38), Point::new(2.05, 0.6), Point::new(2.0, 0.55)];
        let mut memory = DoorMemory::default();
        look_for(&mut memory, &jambs, 0.0, 20.0);
        assert_eq!(memory.closed(20.0), []);
        for time in 0..10 {
            look_for(&mut memory, &[Point::new(2.0, 1.0)], 20.0 + 4.0 * f64::from(time), 1.0);
            look_for(&mut memory, &jambs, 22.0 + 4.0 * f64::from(time), 2.0);
        }
        assert_eq!(memory.closed(60.0), []);
    }

    #[test]
    fn a_person_in_the_middle_shuts_it() {
        assert!(doorway().is_shut_by(&[Point::new(2.0, 0.9), Point::new(2.1, 1.1)], 0.53));
        assert!(!doorway().is_shut_by(&[Point::new(2.3, 1.0)], 0.53), "that is not in the doorway");
    }

    #[test]
    fn a_leaf_shuts_a_door_for_a_robot_narrower_than_what_jambs_may_echo() {
        let leaf: Vec<Point> = (-7..=7).map(|step| Point::new(2.02, 1.0 + 0.06 * f64::from(step))).collect();
        let half: Vec<Point> = leaf.iter().copied().filter(|point| point.y > 1.0).collect();
        for robot_width_m in [0.53, 0.35, 0.21] {
            assert!(doorway().is_shut_by(&leaf, robot_width_m), "{robot_width_m}");
            assert_eq!(doorway().is_shut_by(&half, robot_width_m), robot_width_m > 0.5, "{robot_width_m}");
        }
    }
}
