//! The world in a terminal: walls, the robot, where it believes it is, and how sure it is of what.

use crate::mission::{PositionBelief, Robot};
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

/// The map with robot and belief, at most so many characters wide and high. None without a robot.
pub fn map(map: &OccupancyGrid, robot: &Robot, width: usize, height: usize, colour: bool) -> Option<Vec<String>> {
    let (sight, belief) = (robot.sight()?, robot.belief()?);
    let size = (map.columns as f64 * map.resolution_m, map.rows as f64 * map.resolution_m);
    // A character is about twice as high as wide, and holds two cells above each other.
    let cell_m = (size.0 / width as f64).max(size.1 / (2 * height) as f64);
    let columns = ((size.0 / cell_m).floor() as usize).clamp(1, width);
    let rows = (((size.1 / cell_m) / 2.0).ceil() as usize * 2).clamp(2, 2 * height);
    let mut canvas = Canvas { columns, rows, cells: vec![Ink::Free; columns * rows] };
    draw_map(&mut canvas, map, cell_m);
    draw_belief(&mut canvas, map.origin_in_map, &belief, cell_m);
    let place = |pose: Pose| cell_of(&canvas, map.origin_in_map, cell_m, Point::new(pose.x_m, pose.y_m));
    let marks = [
        place(sight.estimate_in_map).map(|cell| (cell, '?')),
        place(sight.robot_in_map).map(|cell| (cell, arrow(sight.robot_in_map.heading_rad))),
    ];
    let mut lines = lines(&canvas, &marks, colour);
    lines.push(format!(
        "{} robot at {:.2} {:.2} {:.0}°   ? estimate, certainty {:.2}",
        arrow(sight.robot_in_map.heading_rad),
        sight.robot_in_map.x_m,
        sight.robot_in_map.y_m,
        sight.robot_in_map.heading_rad.to_degrees(),
        sight.certainty
    ));
    Some(lines)
}

fn cell_of(canvas: &Canvas, origin: Point, cell_m: f64, point: Point) -> Option<(usize, usize)> {
    let (column, row) = ((point.x - origin.x) / cell_m, (point.y - origin.y) / cell_m);
    let inside = column >= 0.0 && row >= 0.0 && column < canvas.columns as f64 && row < canvas.rows as f64;
    inside.then_some((column as usize, row as usize))
}

fn draw_map(canvas: &mut Canvas, map: &OccupancyGrid, cell_m: f64) {
    let mut free = vec![false; canvas.cells.len()];
    let mut wall = vec![false; canvas.cells.len()];
    for row in 0..map.rows {
        for column in 0..map.columns {
            let Some((x, y)) = cell_of(canvas, map.origin_in_map, cell_m, map.centre(column, row)) else { continue };
            match map.get(column, row) {
                Cell::Free => free[y * canvas.columns + x] = true,
                Cell::Occupied => wall[y * canvas.columns + x] = true,
                Cell::Unknown => {}
            }
        }
    }
    for (index, ink) in canvas.cells.iter_mut().enumerate() {
        *ink = match (wall[index], free[index]) {
            (true, _) => Ink::Wall,
            (false, true) => Ink::Free,
            (false, false) => Ink::Unknown,
        };
    }
}

fn draw_belief(canvas: &mut Canvas, origin: Point, belief: &PositionBelief, cell_m: f64) {
    let mut mass = vec![0.0; canvas.cells.len()];
    for (index, &probability) in belief.cells.iter().enumerate() {
        let (column, row) = (index % belief.columns, index / belief.columns);
        let point = Point::new(
            belief.origin_in_map.x + (column as f64 + 0.5) * belief.resolution_m,
            belief.origin_in_map.y + (row as f64 + 0.5) * belief.resolution_m,
        );
        if let Some((x, y)) = cell_of(canvas, origin, cell_m, point) {
            mass[y * canvas.columns + x] += probability;
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
