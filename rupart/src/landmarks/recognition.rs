//! Which landmark a sheet is.

use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::vision::WallMark;
use rpl_robot::world::Landmark;

/// A landmark is expected within this of where it is seen: more than a position that is known strays.
const EXPECTED_M: f64 = 1.5;

/// Which of the landmarks a sheet is taken for, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recognized {
    /// One that hangs about there.
    Expected(usize),
    /// None hangs there: the nearest one.
    Unexpected(usize),
}

impl Recognized {
    /// The landmark.
    pub fn number(self) -> usize {
        match self {
            Self::Expected(number) | Self::Unexpected(number) => number,
        }
    }
}

/// Of the landmarks that look like a mark and whose front the robot could see, the one nearest to where the sheet
/// is by the estimated position: "the robot determines from its estimated location which marker is closest". None
/// if there is none.
pub fn recognize(
    landmarks: &[Landmark],
    mark: &WallMark,
    at_in_base: Point,
    estimated_in_map: Pose,
) -> Option<Recognized> {
    let seen_in_map = estimated_in_map.transform(at_in_base);
    let towards = seen_in_map - estimated_in_map.point();
    let alike = landmarks.iter().enumerate().filter(|(_, landmark)| mark.is_of(landmark));
    let before = alike.filter(|(_, landmark)| towards.dot(&landmark.facing()) < 0.0);
    let off_m = |landmark: &Landmark| distance_m(landmark.pose_in_map.point(), seen_in_map);
    let nearest = before.min_by(|(_, a), (_, b)| off_m(a).total_cmp(&off_m(b)));
    nearest.map(|(number, landmark)| match off_m(landmark) < EXPECTED_M {
        true => Recognized::Expected(number),
        false => Recognized::Unexpected(number),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::world::{MarkerColour, World};

    #[test]
    fn a_sheet_is_the_landmark_of_its_look_that_hangs_there() {
        let world = World::builtin("olin-rice").expect("built in");
        let mark = |colour| WallMark::of(world.landmarks.iter().find(|one| one.colour == colour).expect("one"));
        let named = |found: Option<Recognized>| found.map(|found| world.landmarks[found.number()].name.as_str());
        let here = Pose::new(20.0, 8.2, 0.0);
        // `south-hall-halfway-west` is 1.5 m ahead and 1.1 m to the right.
        let green = recognize(&world.landmarks, &mark(MarkerColour::Green), Point::new(1.5, -1.1), here);
        assert!(matches!(green, Some(Recognized::Expected(_))) && named(green) == Some("south-hall-halfway-west"));
        let orange = recognize(&world.landmarks, &mark(MarkerColour::Orange), Point::new(1.5, -1.1), here);
        assert!(matches!(orange, Some(Recognized::Unexpected(_))), "{orange:?}");
        let behind = Pose::new(20.0, 5.0, 0.0);
        let from_behind = recognize(&world.landmarks, &mark(MarkerColour::Green), Point::new(1.5, 2.1), behind);
        assert_ne!(named(from_behind), Some("south-hall-halfway-west"));
    }
}
