//! Optimal lengths on grids of the kinds that Sturtevant's benchmarks have (rooms, mazes, caves,
//! random obstacles; "Benchmarks for Grid-Based Pathfinding", 2012), beside a plain Dijkstra.

use super::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

const EDGE: usize = 192;

fn open() -> OccupancyGrid {
    OccupancyGrid::filled(Point::new(-3.0, 7.0), 0.05, EDGE, EDGE, Cell::Free)
}

fn scattered(stream: &mut Stream, share: f64) -> OccupancyGrid {
    let mut map = open();
    map.cells.iter_mut().filter(|_| stream.chance(share)).for_each(|cell| *cell = Cell::Occupied);
    map
}

/// Rooms of 15 cells; each wall has a door somewhere.
fn rooms(stream: &mut Stream) -> OccupancyGrid {
    const ROOM: usize = 16;
    let mut map = open();
    for wall in (0..EDGE).step_by(ROOM) {
        for along in 0..EDGE {
            map.set(wall, along, Cell::Occupied);
            map.set(along, wall, Cell::Occupied);
        }
    }
    for (x, y) in (0..EDGE / ROOM).flat_map(|y| (0..EDGE / ROOM).map(move |x| (x * ROOM, y * ROOM))) {
        map.set(x, y + 1 + stream.index(ROOM - 1), Cell::Free);
        map.set(x + 1 + stream.index(ROOM - 1), y, Cell::Free);
    }
    map
}

/// A tree of corridors one cell wide.
fn maze(stream: &mut Stream) -> OccupancyGrid {
    let mut map = OccupancyGrid { cells: vec![Cell::Occupied; EDGE * EDGE], ..open() };
    let mut trail = vec![(1, 1)];
    map.set(1, 1, Cell::Free);
    while let Some(&(x, y)) = trail.last() {
        let ways = [(2, 0), (-2, 0), (0, 2), (0, -2)].map(|(dx, dy)| (x + dx, y + dy));
        let within = |at: i32| (1..EDGE as i32 - 1).contains(&at);
        let fresh: Vec<(i32, i32)> = ways
            .into_iter()
            .filter(|&(x, y)| within(x) && within(y) && map.get(x as usize, y as usize) == Cell::Occupied)
            .collect();
        if fresh.is_empty() {
            trail.pop();
            continue;
        }
        let (next_x, next_y) = fresh[stream.index(fresh.len())];
        map.set((x + next_x) as usize / 2, (y + next_y) as usize / 2, Cell::Free);
        map.set(next_x as usize, next_y as usize, Cell::Free);
        trail.push((next_x, next_y));
    }
    map
}

/// Caves, as games have them: noise in which each cell follows most of its neighbours.
fn caves(stream: &mut Stream) -> OccupancyGrid {
    let mut map = scattered(stream, 0.45);
    for _ in 0..4 {
        let before = map.clone();
        for (x, y) in (1..EDGE - 1).flat_map(|y| (1..EDGE - 1).map(move |x| (x, y))) {
            let around = (0..9).filter(|cell| before.get(x + cell % 3 - 1, y + cell / 3 - 1) == Cell::Occupied);
            map.set(x, y, if around.count() > 4 { Cell::Occupied } else { Cell::Free });
        }
    }
    map
}

/// Lengths in cells, by straight and diagonal moves that cut no corners.
fn dijkstra(map: &OccupancyGrid, target: usize) -> Vec<f64> {
    let edge = EDGE as i64;
    let is_free = |x: i64, y: i64| {
        (0..edge).contains(&x) && (0..edge).contains(&y) && map.get(x as usize, y as usize) == Cell::Free
    };
    let mut lengths = vec![f64::INFINITY; map.cells.len()];
    lengths[target] = 0.0;
    // The bits of a positive number are in its order.
    let mut open = BinaryHeap::from([Reverse((0u64, target))]);
    while let Some(Reverse((bits, cell))) = open.pop() {
        if f64::from_bits(bits) > lengths[cell] {
            continue;
        }
        let (x, y) = ((cell % EDGE) as i64, (cell / EDGE) as i64);
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).filter(|&step| step != (0, 0)) {
            if is_free(x + dx, y + dy) && is_free(x + dx, y) && is_free(x, y + dy) {
                let length = lengths[cell] + ((dx * dx + dy * dy) as f64).sqrt();
                let next = ((y + dy) * edge + x + dx) as usize;
                if length < lengths[next] {
                    lengths[next] = length;
                    open.push(Reverse((length.to_bits(), next)));
                }
            }
        }
    }
    lengths
}

#[test]
fn lengths_are_optimal_to_a_ten_thousandth_of_a_cell() {
    let stream = &mut Stream::new(12, "benchmarks");
    let maps = [scattered(stream, 0.1), scattered(stream, 0.35), rooms(stream), maze(stream), caves(stream), open()];
    for (kind, map) in maps.iter().enumerate() {
        let model = PlannerModel::new(map, POINT);
        let centre = |cell: usize| map.centre(cell % EDGE, cell / EDGE);
        let free: Vec<usize> = (0..map.cells.len()).filter(|&cell| map.cells[cell] == Cell::Free).collect();
        let target = free[stream.index(free.len())];
        let costs = model.cost_to_go(centre(target));
        let lengths = dijkstra(map, target);
        for &cell in &free {
            let found = costs.cost_m(centre(cell)).map_or(f64::INFINITY, |cost_m| cost_m / map.resolution_m);
            let is_exact = found == lengths[cell] || (found - lengths[cell]).abs() < 1e-4;
            assert!(is_exact, "map {kind}, cell {cell}: {found} and not {}", lengths[cell]);
        }
        for &cell in free.iter().step_by(97).filter(|&&cell| lengths[cell].is_finite()) {
            let way = costs.way_ahead(centre(cell), f64::INFINITY).expect("a way");
            let length = path_length_m(&way) / map.resolution_m;
            assert!((length - lengths[cell]).abs() < 1e-4, "map {kind}, cell {cell}: {length} {}", lengths[cell]);
        }
    }
}
