//! The world in a terminal: walls, the robot, where it believes it is, and how sure it is of what.

use rpl_mission::robot::Robot;
use rpl_mission::sight::PositionBelief;
use rpl_robot::geometry::{Point, Pose};
use rpl_robot::occupancy::{Cell, OccupancyGrid};

/// Cells of a drawing: two lie above each other in one character.
struct Canvas {
    columns: usize,
    rows: usize,
    cells: Vec<Ink>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ink {
    Free,
    Unknown,
    Wall,
    /// Where the robot may be, darker for more probable.
    Belief(u8),
}

/// The map with robot and belief, at most `width` by `height` characters. None without a robot.
pub fn map(map: &OccupancyGrid, robot: &Robot, width: usize, height: usize, colour: bool) -> Option<Vec<String>> {
    let (sight, belief) = (robot.sight()?, robot.belief()?);
    let size = (map.columns as f64 * map.resolution_m, map.rows as f64 * map.resolution_m);
    // A character is about twice as high as wide, and holds two cells above each other.
    let cell_m = (size.0 / width as f64).max(size.1 / (2 * height) as f64);
    let columns = ((size.0 / cell_m).floor() as usize).clamp(1, width);
    let rows = (((size.1 / cell_m) / 2.0).ceil() as usize * 2).clamp(2, 2 * height);
    let mut canvas = Canvas { columns, rows, cells: vec![Ink::Free; columns * rows] };
    draw_map(&mut canvas, map, cell_m);
    draw_belief(&mut canvas, map.origin_in_frame, &belief, cell_m);
    let place = |pose: Pose| cell_of(&canvas, map.origin_in_frame, cell_m, Point::new(pose.x_m, pose.y_m));
    let estimate = place(sight.estimate_in_map).map(|cell| (cell, '?'));
    let robot = sight.robot_in_map.and_then(|pose| Some((place(pose)?, arrow(pose.heading_rad))));
    let mut lines = lines(&canvas, &[estimate, robot], colour);
    // What is known best comes first.
    let (sign, what, shown) = match sight.robot_in_map {
        Some(pose) => (arrow(pose.heading_rad), "robot at", pose),
        None => ('?', "estimate at", sight.estimate_in_map),
    };
    let Pose { x_m, y_m, heading_rad } = shown;
    let estimate = if sight.robot_in_map.is_some() { "   ? estimate," } else { "," };
    lines.push(format!(
        "{sign} {what} {x_m:.2} {y_m:.2} {:.0}°{estimate} certainty {:.2}",
        heading_rad.to_degrees(),
        sight.certainty
    ));
    Some(lines)
}

fn cell_of(canvas: &Canvas, origin: Point, cell_m: f64, point: Point) -> Option<(usize, usize)> {
    let (column, row) = ((point.x - origin.x) / cell_m, (point.y - origin.y) / cell_m);
    let inside = column >= 0.0 && row >= 0.0 && column < canvas.columns as f64 && row < canvas.rows as f64;
    inside.then_some((column as usize, row as usize))
}

/// The cells of a grid that a stretch of the drawing touches along one axis, with the share of each
/// that lies in it. The drawing may be finer than the grid, or coarser.
fn touched(at: usize, cell_m: f64, from_m: f64, grain_m: f64, count: usize) -> impl Iterator<Item = (usize, f64)> {
    let (start, end) = ((at as f64 * cell_m - from_m) / grain_m, ((at + 1) as f64 * cell_m - from_m) / grain_m);
    let first = start.floor().max(0.0) as usize;
    let last = (end.ceil().max(0.0) as usize).min(count);
    (first..last).map(move |cell| {
        let share = end.min((cell + 1) as f64) - start.max(cell as f64);
        (cell, share)
    })
}

/// So little of a cell is an error of rounding.
const LEAST_SHARE: f64 = 1e-6;

fn draw_map(canvas: &mut Canvas, map: &OccupancyGrid, cell_m: f64) {
    let along = |at, count| touched(at, cell_m, 0.0, map.resolution_m, count).filter(|&(_, share)| share > LEAST_SHARE);
    for y in 0..canvas.rows {
        for x in 0..canvas.columns {
            let cells =
                along(y, map.rows).flat_map(|(row, _)| along(x, map.columns).map(move |(column, _)| (column, row)));
            let seen: Vec<Cell> = cells.map(|(column, row)| map.get(column, row)).collect();
            canvas.cells[y * canvas.columns + x] = match (seen.contains(&Cell::Occupied), seen.contains(&Cell::Free)) {
                (true, _) => Ink::Wall,
                (false, true) => Ink::Free,
                (false, false) => Ink::Unknown,
            };
        }
    }
}

fn draw_belief(canvas: &mut Canvas, origin: Point, belief: &PositionBelief, cell_m: f64) {
    let grain_m = belief.resolution_m;
    let rows = belief.cells.len() / belief.columns.max(1);
    let from = belief.origin_in_map - origin;
    let mut mass = Vec::with_capacity(canvas.cells.len());
    for y in 0..canvas.rows {
        for x in 0..canvas.columns {
            let row_mass = |(row, height): (usize, f64)| {
                touched(x, cell_m, from.x, grain_m, belief.columns)
                    .map(|(column, width)| belief.cells[row * belief.columns + column] * width * height)
                    .sum::<f64>()
            };
            mass.push(touched(y, cell_m, from.y, grain_m, rows).map(row_mass).sum::<f64>());
        }
    }
    let most = mass.iter().fold(0.0, |most: f64, &mass| most.max(mass));
    for (ink, mass) in canvas.cells.iter_mut().zip(mass) {
        // A logarithm would show the floor of the filter; the root keeps the weaker hypotheses visible.
        let shade = (mass / most.max(f64::MIN_POSITIVE)).sqrt();
        if *ink != Ink::Wall && shade > 0.1 {
            *ink = Ink::Belief((shade * 4.0).ceil().clamp(1.0, 4.0) as u8);
        }
    }
}

fn arrow(theta: f64) -> char {
    const ARROWS: [char; 8] = ['→', '↗', '↑', '↖', '←', '↙', '↓', '↘'];
    ARROWS[(theta / (std::f64::consts::TAU / 8.0)).round().rem_euclid(8.0) as usize % 8]
}

fn lines(canvas: &Canvas, marks: &[Option<((usize, usize), char)>], colour: bool) -> Vec<String> {
    let ink = |column: usize, row: usize| canvas.cells[row * canvas.columns + column];
    let character = |column: usize, row: usize| {
        let here = marks.iter().rev().flatten().find(|((x, y), _)| *x == column && y / 2 == row / 2);
        match here {
            Some((_, mark)) if colour => format!("\x1b[1;31m{mark}\x1b[0m"),
            Some((_, mark)) => mark.to_string(),
            None => block(ink(column, row + 1), ink(column, row), colour),
        }
    };
    let rows = (0..canvas.rows / 2).rev();
    rows.map(|row| (0..canvas.columns).map(|column| character(column, 2 * row)).collect::<String>())
        .map(|line| line.trim_end().to_string())
        .collect()
}

/// One character for two cells.
fn block(upper: Ink, lower: Ink, colour: bool) -> String {
    let belief = match (upper, lower) {
        (Ink::Belief(one), Ink::Belief(other)) => Some(one.max(other)),
        (Ink::Belief(one), _) | (_, Ink::Belief(one)) => Some(one),
        _ => None,
    };
    if let Some(shade) = belief {
        let shade = [' ', '░', '▒', '▓', '█'][usize::from(shade.min(4))];
        return if colour { format!("\x1b[36m{shade}\x1b[0m") } else { shade.to_string() };
    }
    let wall = match (upper == Ink::Wall, lower == Ink::Wall) {
        (true, true) => "█",
        (true, false) => "▀",
        (false, true) => "▄",
        (false, false) => return if upper == Ink::Unknown && lower == Ink::Unknown { "·" } else { " " }.to_string(),
    };
    wall.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_mission::site::{Setup, Site};
    use rpl_robot::description::RobotDescription;
    use rpl_shell::files::world_files;

    /// What the map of a world looks like in `width` by `height` characters.
    fn drawn(world: &str, width: usize, height: usize) -> Vec<String> {
        let world = world_files::for_all_seeds(world, &RobotDescription::papers()).expect("there is such a world");
        let map = world.map(0.1);
        let site = Site::new(Setup { world: Some(world), ..Setup::default() }).expect("a site");
        super::map(&map, &site.robot(1), width, height, false).expect("there is a robot")
    }

    #[test]
    fn a_character_smaller_than_a_cell_leaves_no_gap_in_a_wall() {
        for (width, height) in [(80, 21), (120, 37), (200, 47), (400, 120)] {
            let lines = drawn("test-room", width, height);
            let (top, rest) = lines.split_first().expect("there are lines");
            let is_wall = |c: char| matches!(c, '█' | '▀' | '▄');
            assert!(top.trim_start().chars().all(is_wall), "{width}×{height}\n{}", lines.join("\n"));
            let body = &rest[..rest.len() - 2];
            assert!(body.iter().all(|line| line.starts_with(is_wall)), "{width}×{height}\n{}", lines.join("\n"));
            assert!(
                body.iter().all(|line| !line.contains('·')),
                "the room is free: {width}×{height}\n{}",
                lines.join("\n")
            );
        }
    }

    #[test]
    fn the_shares_of_the_cells_a_stretch_touches_add_up_to_it() {
        for (cell_m, grain_m) in [(0.03, 0.1), (0.1, 0.1), (0.25, 0.1), (0.07, 0.15)] {
            for at in 0..20 {
                let total: f64 = touched(at, cell_m, 0.0, grain_m, 1000).map(|(_, share)| share).sum();
                assert!((total * grain_m - cell_m).abs() < 1e-9, "{at} {cell_m} {grain_m}");
            }
        }
    }
}
