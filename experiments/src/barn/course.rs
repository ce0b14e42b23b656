//! The courses: fields of posts grown by a cellular automaton, in a walled lane.

use rpl_random::Stream;
use rpl_robot::geometry::{Point, Pose};
use rpl_robot::planning::{Inflation, PlannerModel, path_length_m};
use rpl_robot::world::{Object, SeenBy, Shape, World};

/// As many as in the paper's data set: 25 of each of twelve kinds.
pub const COURSES: u64 = 300;

/// Cells along the length and the width of a field.
const CELLS: usize = 30;
/// Edge of a cell, and the diameter of a post.
const CELL_M: f64 = 0.15;
/// Floor before and behind the field.
const RUN_M: f64 = 3.75;
/// From the ends of the lane to start and goal.
const END_M: f64 = 1.0;
/// The edge of the cells on which the shortest way is found.
const FLOOR_CELL_M: f64 = 0.05;

/// A course, its goal, and the length of the shortest way to it.
pub struct Course {
    /// The lane with its posts; none of them is in any map.
    pub world: World,
    /// 10 m ahead of the start.
    pub goal_in_map: Point,
    /// For the robot's radius.
    pub optimum_m: f64,
}

type Field = Vec<[bool; CELLS]>;

impl Course {
    /// Course number `number` of [`COURSES`], drawn from the seed: fields are drawn until one has a way
    /// through.
    pub fn new(number: u64, seed: u64) -> Self {
        let kind = number * 12 / COURSES;
        let fill = 0.15 + 0.05 * (kind / 3) as f64;
        let smoothings = 2 + kind % 3;
        let mut stream = Stream::new(seed.wrapping_mul(COURSES).wrapping_add(number), "barn");
        loop {
            let field = grown(&mut stream, fill, smoothings);
            if let Some(course) = laid_out(&field) {
                return course;
            }
        }
    }
}

/// The rows at the two sides are the walls of the lane.
fn grown(stream: &mut Stream, fill: f64, smoothings: u64) -> Field {
    let mut field: Field = vec![[true; CELLS]; CELLS];
    for row in &mut field[1..CELLS - 1] {
        row.fill_with(|| stream.chance(fill));
    }
    for _ in 0..smoothings {
        field = smoothed(&field);
    }
    field
}

/// A cell with more than four filled neighbours of eight is filled, one with less than two emptied;
/// beyond the sides all is filled, beyond the ends nothing.
fn smoothed(field: &Field) -> Field {
    let filled = |row: usize, column: usize| -> usize {
        let mut count = 0;
        for y in row as i64 - 1..=row as i64 + 1 {
            for x in column as i64 - 1..=column as i64 + 1 {
                let is_self = y == row as i64 && x == column as i64;
                let is_filled = match (usize::try_from(y).ok().and_then(|y| field.get(y)), usize::try_from(x)) {
                    (None, _) => true,
                    (Some(line), Ok(x)) => line.get(x).copied().unwrap_or(false),
                    (Some(_), Err(_)) => false,
                };
                count += usize::from(is_filled && !is_self);
            }
        }
        count
    };
    let mut next = field.clone();
    for (row, line) in next.iter_mut().enumerate() {
        for (column, cell) in line.iter_mut().enumerate() {
            match filled(row, column) {
                0..2 => *cell = false,
                5.. => *cell = true,
                2..5 => {}
            }
        }
    }
    next
}

/// Of the robot: a disc with the area of the Jackal's 51 × 43 cm.
pub const RADIUS_M: f64 = 0.265;

/// None if there is no way through.
fn laid_out(field: &Field) -> Option<Course> {
    let (length_m, width_m) = (2.0 * RUN_M + CELLS as f64 * CELL_M, CELLS as f64 * CELL_M);
    let start = Pose::new(END_M, width_m / 2.0, 0.0);
    let text = format!(
        "name = \"barn\"\nsize = [{length_m}, {width_m}]\nstart = [{END_M}, {}, \"0deg\"]\n[[wall]]\n\
         line = [[0.05, 0.05], [{right}, 0.05], [{right}, {top}], [0.05, {top}], [0.05, 0.05]]\nthickness = 0.1\n",
        width_m / 2.0,
        right = length_m - 0.05,
        top = width_m - 0.05,
    );
    let mut world = World::parse(&text, "barn.toml").ok()?;
    for (row, line) in field.iter().enumerate() {
        for (column, _) in line.iter().enumerate().filter(|(_, is_filled)| **is_filled) {
            let centre = Point::new(RUN_M + (column as f64 + 0.5) * CELL_M, (row as f64 + 0.5) * CELL_M);
            world.objects.push(Object {
                name: format!("post-{row}-{column}"),
                shape: Shape::Circle { centre, radius_m: CELL_M / 2.0 },
                mapped: true,
                seen_by: SeenBy { sonar: true, laser: true },
            });
        }
    }
    let goal_in_map = Point::new(length_m - END_M, width_m / 2.0);
    let inflation = Inflation { body_radius_m: RADIUS_M, comfortable_distance_m: RADIUS_M, closeness_weight: 0.0 };
    let floor = PlannerModel::new(&world.map(FLOOR_CELL_M), inflation);
    let path = floor.cost_to_go(goal_in_map).path(start.point())?;
    Some(Course { world, goal_in_map, optimum_m: path_length_m(&path) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lone_post_goes_a_gap_in_a_block_is_filled_and_sides_are_walls() {
        let mut field: Field = vec![[false; CELLS]; CELLS];
        field[10][10] = true;
        for row in &mut field[19..22] {
            row[19..22].fill(true);
        }
        field[20][20] = false;
        let next = smoothed(&field);
        assert!(!next[10][10] && next[20][20] && next[19][20] && !next[18][18]);
        assert!(grown(&mut Stream::new(1, "barn"), 0.3, 0)[0].iter().all(|&is_filled| is_filled));
    }

    #[test]
    fn a_course_is_the_same_for_the_same_seed_and_no_shorter_than_straight() {
        let (course, again, other) = (Course::new(299, 1), Course::new(299, 1), Course::new(299, 2));
        assert_eq!(course.world, again.world);
        assert_ne!(course.world, other.world);
        let straight_m = (course.goal_in_map - course.world.start_in_map.point()).norm();
        assert!((straight_m - 10.0).abs() < 1e-9 && course.optimum_m >= straight_m, "{}", course.optimum_m);
    }
}
