//! Facts about the whole filter, on maps small enough to compute everything by hand.

mod dead_reckoning;
mod gating;
mod odometry_faults;
mod sleeping;
mod turning;
mod watcher;

use super::grid::{Place, TILE, TILE_EDGE};
use super::sensor::mixture;
use super::*;
use crate::geometry::{Point, Pose, wrap_angle_rad};
use crate::occupancy::{Cell, OccupancyGrid};
use crate::simulator::{Commands, SimulatorModel, SimulatorSettings};
use crate::world::World;
use rpl_random::Stream;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// A walled room of 6 × 4 m with a box in one corner.
fn room() -> OccupancyGrid {
    let mut map = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.1, 60, 40, Cell::Free);
    for row in 0..40 {
        for column in 0..60 {
            let wall = row == 0 || row == 39 || column == 0 || column == 59;
            let shelf = row < 8 && column > 40;
            if wall || shelf {
                map.set(column, row, Cell::Occupied);
            }
        }
    }
    map
}

/// A walled corridor of 12 × 3 m with a cupboard on one side.
fn corridor() -> OccupancyGrid {
    let mut map = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.1, 120, 30, Cell::Free);
    for column in 0..120 {
        for row in 0..30 {
            let wall = column == 0 || column == 119 || row == 0 || row == 29;
            if wall || (40..45).contains(&column) && row < 12 {
                map.set(column, row, Cell::Occupied);
            }
        }
    }
    map
}

fn parameters() -> LocalizationParameters {
    let sensors = vec![ScanParameters { gating: None, ..ScanParameters::default() }];
    LocalizationParameters { cell_m: 0.3, angle_step_deg: 15, sensors, ..LocalizationParameters::default() }
}

fn fine() -> LocalizationParameters {
    LocalizationParameters { cell_m: 0.2, angle_step_deg: 5, ..parameters() }
}

fn model(parameters: LocalizationParameters) -> LocalizationModel {
    LocalizationModel::new(&room(), parameters).expect("the room is a map")
}

/// What a noise-free robot at a pose measures.
fn scan_at(model: &LocalizationModel, pose_in_map: Pose) -> Vec<f32> {
    let state = model.state_at(pose_in_map).expect("a pose on the map");
    model.expected_scan(0, state).into_iter().map(|bin| model.sensors[0].likelihood.range_m(bin) as f32).collect()
}

fn states(model: &LocalizationModel) -> Vec<State> {
    let grid = &model.grid;
    let rows = |heading| {
        (0..grid.rows).flat_map(move |row| (0..grid.columns).map(move |column| State { heading, row, column }))
    };
    (0..grid.headings).flat_map(rows).collect()
}

fn probabilities(model: &LocalizationModel, belief: &Belief) -> Vec<f64> {
    states(model).into_iter().map(|state| belief.probability(model, state)).collect()
}

fn total_variation(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / 2.0
}

/// A drive around the room: odometry and scans, the first pose first.
fn drive(model: &LocalizationModel, seed: u64, steps: usize) -> Vec<(Pose, Vec<f32>)> {
    let mut noise = Stream::new(seed, "noise");
    let start = Pose::new(2.0, 2.0, 0.0);
    let mut odometry = Pose::default();
    (0..steps)
        .map(|step| {
            let turn_rad = if step % 8 < 4 { 0.0 } else { 0.4 };
            odometry = odometry.compose(Pose::new(0.12, 0.0, turn_rad));
            let mut scan_m = scan_at(model, start.compose(odometry));
            scan_m.iter_mut().for_each(|range_m| *range_m += 0.03 * noise.normal() as f32);
            (odometry, scan_m)
        })
        .collect()
}

#[test]
fn the_belief_sums_to_one_after_every_operation() {
    let model = model(parameters());
    let mut localization = Localization::start_at(&model, Pose::new(2.0, 2.0, 0.0), Spread::default());
    let check = |localization: &Localization| {
        let (belief, leading) = localization.belief(&model);
        let sum: f64 = probabilities(leading, belief).iter().sum();
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        assert!((localization.mass(&model) - 1.0).abs() < 1e-4);
    };
    check(&localization);
    check(&Localization::start_uniform(&model));
    for (step, (odometry, scan_m)) in drive(&model, 10_000, 40).iter().enumerate() {
        let sonar_m = (step % 5 != 0).then_some(scan_m.as_slice());
        localization.observe(&model, *odometry, &[sonar_m]);
        check(&localization);
        if step == 20 {
            localization.reset_for_relocalization(&model);
            check(&localization);
        }
    }
    let picture: f64 = localization.belief_xy(&model).iter().sum();
    assert!((picture - 1.0).abs() < 1e-4);
}

#[test]
fn a_point_mass_lands_where_pose_arithmetic_says() {
    let exact = OdometryError {
        forward_m: 0.0,
        sideward_m: 0.0,
        turn_per_metre_rad: 0.0,
        turn_per_radian_rad: 0.0,
        position_per_radian_m: 0.0,
    };
    let model = model(LocalizationParameters { odometry: exact, mixing: 0.0, ..parameters() });
    let point = Spread { position_m: 0.0, heading_rad: 0.0 };
    let start = Pose::new(2.07, 1.93, 0.3);
    let mut belief = Belief::around(&model, start, point);
    let mut pose = start;
    for motion in [Pose::new(0.4, 0.05, 0.5), Pose::new(0.33, 0.0, 0.9), Pose::new(0.71, 0.0, -0.2)] {
        belief.advance(&model, motion, &model.parameters.odometry);
        pose = pose.compose(motion);
        belief.mix(&model, 0.0);
        let mode = belief.mode(&model).pose_in_map;
        assert!(mode.distance_m(pose) < 1e-6, "{mode:?} {pose:?}");
        assert!(wrap_angle_rad(mode.heading_rad - pose.heading_rad).abs() < 1e-6);
    }
}

#[test]
fn noise_of_the_odometry_spreads_the_belief_about_its_mean() {
    let error = OdometryError {
        forward_m: 0.3,
        sideward_m: 0.1,
        turn_per_metre_rad: 0.0,
        turn_per_radian_rad: 0.0,
        position_per_radian_m: 0.0,
    };
    let model = model(LocalizationParameters { odometry: error, mixing: 0.0, activity_threshold: 0.0, ..parameters() });
    let point = Spread { position_m: 0.0, heading_rad: 0.0 };
    let mut belief = Belief::around(&model, Pose::new(2.25, 2.25, 0.0), point);
    belief.advance(&model, Pose::new(1.0, 0.0, 0.0), &model.parameters.odometry);
    let plane = &belief.planes()[0];
    let moment = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        let part = |state: &State| {
            let (column, row) = plane.position_cells(&model.grid, model.grid.place(state.column, state.row));
            let origin = model.grid.origin_in_map;
            let value = belief.probability(&model, *state);
            value * of(origin.x + column * 0.3 - 3.25, origin.y + row * 0.3 - 2.25)
        };
        states(&model).iter().filter(|state| state.heading == 0).map(part).sum()
    };
    let mass = moment(&|_, _| 1.0);
    assert!((moment(&|x, _| x) / mass).abs() < 1e-5 && (moment(&|_, y| y) / mass).abs() < 1e-5);
    let applied = [moment(&|x, _| x * x) / mass, moment(&|_, y| y * y) / mass];
    let pending = plane.variance_cells.map(|variance| variance * 0.09);
    assert!((applied[0] + pending[0] - 0.09).abs() < 1e-5 && (applied[1] + pending[1] - 0.01).abs() < 1e-5);
}

#[test]
fn a_full_motion_is_eq_1_summed_over_all_pairs_of_states() {
    let error = OdometryError {
        forward_m: 0.25,
        sideward_m: 0.1,
        turn_per_metre_rad: 0.2,
        turn_per_radian_rad: 0.0,
        position_per_radian_m: 0.0,
    };
    let model = model(LocalizationParameters { odometry: error, mixing: 0.0, activity_threshold: 0.0, ..parameters() });
    let mut belief = Belief::around(&model, Pose::new(2.5, 2.0, 0.7), Spread { position_m: 0.8, heading_rad: 0.8 });
    let before = belief.clone();
    let motion = Pose::new(0.5, 0.1, 0.6);
    belief.advance(&model, motion, &model.parameters.odometry);
    let (grid, headings) = (&model.grid, model.grid.headings);
    let distance_m = libm::hypot(motion.x_m, motion.y_m);
    let step = grid.angle_step_rad();
    // What the error model gives along and across the heading, and of the heading, in cells and steps.
    let [forward, sideward] = [0.25, 0.1].map(|error_m| error_m * error_m * distance_m / (grid.cell_m * grid.cell_m));
    let turn_spread = (0.2 / step) * (0.2 / step) * distance_m / 2.0;
    let turned = libm::round(before.heading_offset + motion.heading_rad / step) as usize;
    let moved: Vec<[[f64; 2]; 2]> = (0..headings)
        .map(|heading| {
            let (sin, cos) = libm::sincos(before.heading_rad(&model, heading));
            let by = [cos * motion.x_m - sin * motion.y_m, sin * motion.x_m + cos * motion.y_m];
            let offset = before.planes()[heading].offset_cells;
            let variance = [cos * cos * forward + sin * sin * sideward, sin * sin * forward + cos * cos * sideward];
            [[offset[0] + by[0] / grid.cell_m, offset[1] + by[1] / grid.cell_m], variance]
        })
        .collect();
    let rest = |heading: usize| moved[heading][0].map(|cells| cells - libm::round(cells));
    let taps = |spread: f64| [(-1i64, spread), (0, 1.0 - 2.0 * spread), (1, spread)];
    // The room lies in one tile, which is larger than the map.
    assert_eq!(grid.tiles(), 1);
    let [west, south] = grid.column_and_row(Place { tile: 0, cell: 0 });
    let on_tile = |column: i64, row: i64| {
        (0..TILE_EDGE as i64).contains(&(column - west)) && (0..TILE_EDGE as i64).contains(&(row - south))
    };
    let mut exact = vec![vec![0.0; TILE]; headings];
    for state in states(&model) {
        let [by, variance] = moved[state.heading];
        let from = before.probability(&model, state);
        let (column, row) =
            (state.column as i64 + libm::round(by[0]) as i64, state.row as i64 + libm::round(by[1]) as i64);
        for (dx, x_share) in taps(variance[0] / 2.0) {
            for (dy, y_share) in taps(variance[1] / 2.0) {
                for (turn, turn_share) in taps(turn_spread) {
                    let beside = (state.heading as i64 + turn).rem_euclid(headings as i64) as usize;
                    let aligned = [0, 1].map(|axis| libm::round(rest(state.heading)[axis] - rest(beside)[axis]) as i64);
                    let (c, r) = (column + dx + aligned[0], row + dy + aligned[1]);
                    if on_tile(column, row) && on_tile(column + dx, row + dy) && on_tile(c, r) {
                        let cell = (r - south) as usize * TILE_EDGE + (c - west) as usize;
                        let to = &mut exact[(beside + turned) % headings][cell];
                        *to += from * x_share * y_share * turn_share;
                    }
                }
            }
        }
    }
    assert!(forward > 0.04 && turn_spread > 0.1 && turned > 0);
    for (plane, exact) in belief.planes().iter().zip(&exact) {
        for (stored, exact) in plane.tiles[0].cells.iter().zip(exact) {
            let found = belief.value(*stored);
            assert!((found - exact).abs() < 1e-6 * exact.max(1e-4), "{found} {exact}");
        }
    }
}

#[test]
fn a_full_update_is_bayes_rule_up_to_the_rounding_of_its_bytes() {
    let tempering = 0.7;
    let sensors = vec![ScanParameters { tempering, ..ScanParameters::default() }];
    let full = LocalizationParameters { sensors, mixing: 0.0, activity_threshold: 0.0, ..parameters() };
    let model = model(full);
    let mut belief = Belief::around(&model, Pose::new(2.5, 2.0, 1.0), Spread { position_m: 1.0, heading_rad: 1.0 });
    let mut posterior = probabilities(&model, &belief);
    let mut scan_m = scan_at(&model, Pose::new(2.4, 2.1, 0.8));
    let used = 10;
    scan_m[used..].fill(f32::NAN);
    belief.sense_ranges(&model, &[Some(&scan_m)]);
    let likelihoods: Vec<Vec<f64>> = (0..256).map(|bin| mixture(&model.parameters.sensors[0].beam, bin)).collect();
    for (state, probability) in states(&model).into_iter().zip(&mut posterior) {
        let expected = model.expected_scan(0, state);
        for sonar in 0..used {
            let measured = usize::from(model.sensors[0].likelihood.bin(f64::from(scan_m[sonar])));
            *probability *= libm::pow(likelihoods[usize::from(expected[sonar])][measured], tempering);
        }
    }
    let evidence: f64 = posterior.iter().sum();
    // Each byte errs by 1/64 nat, and so does the evidence, an average over such products.
    let bound = 2.0 * used as f64 / 64.0 * tempering + 1e-3;
    for (found, exact) in probabilities(&model, &belief).iter().zip(posterior.iter().map(|p| p / evidence)) {
        assert!(exact < 1e-20 || libm::fabs(libm::log(found / exact)) <= bound, "{found} {exact}");
    }
}

#[test]
fn a_belief_made_anew_has_the_densities_of_the_coarse_one() {
    let selective = model(fine());
    let model = model(LocalizationParameters { activity_threshold: 0.0, ..fine() });
    let coarse = model.watch.as_ref().expect("a coarse belief watches");
    let spread = Spread { position_m: 0.8, heading_rad: 0.6 };
    let other = Belief::around(coarse, Pose::new(2.53, 2.01, 0.77), spread);
    let density = |heading_rad: f64, point: Point| -> f64 {
        let away = |plane: usize| wrap_angle_rad(other.heading_rad(coarse, plane) - heading_rad).abs();
        let plane = (0..coarse.grid.headings).min_by(|&a, &b| away(a).total_cmp(&away(b))).expect("a plane");
        let (x, y) = coarse.grid.fractional(point);
        // The likeliest of the cells whose middles are within `across` and `up` cells along x and y.
        let likeliest = |across: f64, up: f64| -> f64 {
            let cells = states(coarse).into_iter().filter(|state| state.heading == plane).filter(|state| {
                let place = coarse.grid.place(state.column, state.row);
                let (column, row) = other.planes[plane].position_cells(&coarse.grid, place);
                (column - x).abs() < across && (row - y).abs() < up
            });
            cells.map(|state| other.probability(coarse, state)).fold(0.0, f64::max)
        };
        let here = likeliest(0.5, 0.5);
        if here > 0.0 { here } else { likeliest(1.5, 0.5).max(likeliest(0.5, 1.5)) }
    };
    let due: Vec<f64> = states(&model)
        .into_iter()
        .map(|State { heading, row, column }| {
            let is_admissible = model.is_admissible(column, row);
            let point = model.grid.centre(column, row);
            if is_admissible { density(model.grid.heading_rad(heading), point) } else { 0.0 }
        })
        .collect();
    let sum: f64 = due.iter().sum();
    let due: Vec<f64> = due.into_iter().map(|density| density / sum).collect();
    let found = probabilities(&model, &Belief::resampled(&model, &other, coarse));
    assert!(total_variation(&found, &due) < 1e-6, "{}", total_variation(&found, &due));
    let slept = Belief::resampled(&selective, &other, coarse);
    let found = probabilities(&selective, &slept);
    // What sleeps is at most θ, 0.3 % of the prior.
    assert!(total_variation(&found, &due) < 3e-3, "{}", total_variation(&found, &due));
    assert!(slept.active_planes() < selective.grid.headings);
}

#[test]
fn a_turn_by_hand_is_noticed_soon_and_a_turn_by_wheel_is_not() {
    let model = LocalizationModel::new(&corridor(), fine()).expect("the corridor is a map");
    let start = Pose::new(8.0, 1.5, 0.0);
    let mut lowest = [1f64; 2];
    for (by_hand, lowest) in [false, true].into_iter().zip(&mut lowest) {
        let mut localization = Localization::start_at(&model, start, Spread::default());
        let turn = Pose::new(0.0, 0.0, 70f64.to_radians());
        for step in 0..8 {
            let motion = Pose::new(0.0, 0.0, f64::from(step) * 0.2);
            let turned = if step >= 2 { motion.compose(turn) } else { motion };
            let odometry = if by_hand { motion } else { turned };
            localization.observe(&model, odometry, &[Some(&scan_at(&model, start.compose(turned)))]);
            *lowest = lowest.min(localization.estimate(&model).certainty);
        }
    }
    assert!(lowest[0] > 0.8 && lowest[1] < 0.8, "{lowest:?}");
}

/// A walled corridor of 12 × 3 m with two cupboards, each the other's image under half a turn.
/// Half of the robot's sonars hear somebody who stands around it and walks with it; the others hear
/// what the pose explains, or what it does not.
fn lowest_certainty_in_a_crowd(others_fit: bool) -> f64 {
    let model = model(LocalizationParameters { sensors: vec![ScanParameters::default()], ..fine() });
    let start = Pose::new(2.0, 2.0, 0.0);
    let mut localization = Localization::start_at(&model, start, Spread::default());
    let mut lowest = 1f64;
    for (step, (odometry, scan_m)) in drive(&model, 10_001, 60).iter().enumerate() {
        let heard = |(beam, &range_m): (usize, &f32)| match (beam + step / 5) % 24 {
            0..=11 => range_m.min(0.7),
            _ if others_fit => range_m,
            _ => range_m + 1.0,
        };
        let scan_m: Vec<f32> = scan_m.iter().enumerate().map(heard).collect();
        localization.observe(&model, *odometry, &[Some(&scan_m)]);
        lowest = lowest.min(localization.estimate(&model).certainty);
    }
    let (estimate, right) = (localization.estimate(&model), start.compose(drive(&model, 10_001, 60)[59].0));
    if others_fit {
        assert!(estimate.pose_in_map.distance_m(right) < 0.3, "{estimate:?} {right:?}");
    }
    lowest
}

#[test]
fn a_crowd_is_no_reason_to_doubt_the_position_unless_the_other_readings_are() {
    let (fitting, farther) = (lowest_certainty_in_a_crowd(true), lowest_certainty_in_a_crowd(false));
    // As sure as a search makes a robot.
    assert!(fitting > 0.9, "{fitting}");
    assert!(farther < 0.7, "{farther}");
}

fn symmetric_corridor() -> OccupancyGrid {
    let mut map = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.1, 120, 30, Cell::Free);
    for column in 0..120 {
        for row in 0..30 {
            let wall = column == 0 || column == 119 || row == 0 || row == 29;
            let cupboard = |column: usize, row: usize| (30..38).contains(&column) && row < 10;
            if wall || cupboard(column, row) || cupboard(119 - column, 29 - row) {
                map.set(column, row, Cell::Occupied);
            }
        }
    }
    map
}

#[test]
fn a_robot_turned_half_round_in_a_symmetric_corridor_takes_both_poses_for_possible() {
    let model = LocalizationModel::new(&symmetric_corridor(), fine()).expect("the corridor is a map");
    let believed = Pose::new(8.0, 1.5, 0.0);
    let mut localization = Localization::start_at(&model, believed, Spread::default());
    let mut odometry = Pose::default();
    for _ in 0..20 {
        odometry = odometry.compose(Pose::new(0.15, 0.0, 0.0));
        let truth = Pose::new(8.0, 1.5, PI).compose(odometry);
        localization.observe(&model, odometry, &[Some(&scan_at(&model, truth))]);
    }
    let truth = Pose::new(8.0, 1.5, PI).compose(odometry);
    let twin = Pose::new(12.0 - truth.x_m, 3.0 - truth.y_m, truth.heading_rad + PI);
    let (belief, leading) = localization.belief(&model);
    let masses = [truth, twin, believed.compose(odometry)].map(|pose| belief.mass_near(leading, pose));
    assert!(masses[0] > 0.2 && masses[1] > 0.2 && masses[2] < 0.1, "{masses:?}");
    assert!(localization.estimate(&model).certainty < 0.8);
}

#[test]
fn a_refuted_belief_is_uniform() {
    let model = model(fine());
    let mut localization = Localization::start_at(&model, Pose::new(2.0, 2.0, 0.0), Spread::default());
    localization.refute(&model);
    let uniform = Localization::start_uniform(&model).entropy(&model);
    assert!((localization.entropy(&model) - uniform).abs() < 1e-3);
    assert!(localization.estimate(&model).certainty < 0.2);
    let mut odometry = Pose::default();
    for _ in 0..40 {
        odometry = odometry.compose(Pose::new(0.02, 0.0, 0.2));
        localization.observe(&model, odometry, &[None]);
        assert!((localization.mass(&model) - 1.0).abs() < 1e-3, "{}", localization.mass(&model));
    }
}

#[test]
fn entropy_has_its_closed_forms() {
    let model = model(parameters());
    let states = (model.admissible_cells() * model.grid.headings) as f64;
    assert!((Belief::uniform(&model).entropy(&model) - libm::log(states)).abs() < 1e-4);
    let exact = Spread { position_m: 0.0, heading_rad: 0.0 };
    let at = |x_m: f64, heading_rad: f64| Belief::around(&model, Pose::new(x_m, 2.0, heading_rad), exact);
    assert!(at(2.0, 0.0).entropy(&model) < 1e-4);
    let two = at(2.0, 0.0).merged(&model, &at(4.0, PI));
    assert!((two.entropy(&model) - std::f64::consts::LN_2).abs() < 1e-4);
}

#[test]
fn two_peaks_are_two_maxima_with_their_masses() {
    let model = model(parameters());
    let spread = Spread { position_m: 0.2, heading_rad: 0.15 };
    let poses = [Pose::new(1.5, 2.0, 0.0), Pose::new(4.2, 2.4, PI / 2.0)];
    let [a, b] = poses.map(|pose| Belief::around(&model, pose, spread));
    let belief = a.merged(&model, &b);
    let maxima = belief.maxima(&model, 5, 0.1);
    assert_eq!(maxima.len(), 2);
    for pose in poses {
        let found = maxima.iter().find(|maximum| maximum.is_near(pose, Pose::default()));
        assert!(found.is_some_and(|maximum| {
            maximum.pose_in_map.distance_m(pose) < 0.25 && (0.4..=0.5).contains(&maximum.mass)
        }));
    }
    assert_eq!(Belief::uniform(&model).maxima(&model, 5, 0.1), []);
}

#[test]
fn a_saved_filter_goes_on_like_the_one_it_was_saved_from() {
    let model = model(parameters());
    let mut localization = Localization::start_at(&model, Pose::new(2.0, 2.0, 0.0), Spread::default());
    for (odometry, scan_m) in drive(&model, 10_002, 15) {
        let bytes = postcard::to_allocvec(&localization).expect("it can be written");
        let mut loaded: Localization = postcard::from_bytes(&bytes).expect("and read");
        assert_eq!(loaded, localization);
        localization.observe(&model, odometry, &[Some(&scan_m)]);
        loaded.observe(&model, odometry, &[Some(&scan_m)]);
        assert_eq!(postcard::to_allocvec(&loaded), postcard::to_allocvec(&localization));
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let model = model(fine());
            let mut localization = Localization::start_uniform(&model);
            let mut bytes = Vec::new();
            for (odometry, scan_m) in drive(&model, 10_003, 12) {
                localization.observe(&model, odometry, &[Some(&scan_m)]);
                bytes.push(postcard::to_allocvec(&localization).expect("it can be written"));
                bytes.push(localization.entropy(&model).to_bits().to_le_bytes().to_vec());
            }
            (bytes, localization.maxima(&model, 10, 0.0))
        })
    };
    assert!(run(1) == run(2));
}

#[test]
fn all_instructions_give_the_same_bits() {
    let run = |instructions: Instructions| {
        let model = model(fine()).with_instructions(instructions);
        let mut localization = Localization::start_uniform(&model);
        let mut bytes = Vec::new();
        for (step, (odometry, mut scan_m)) in drive(&model, 10_004, 16).into_iter().enumerate() {
            // Any number of readings, also one that is no multiple of what is looked up together.
            let count = scan_m.len();
            scan_m[count - step % count..].fill(f32::NAN);
            localization.observe(&model, odometry, &[Some(&scan_m)]);
            bytes.push(postcard::to_allocvec(&localization).expect("it can be written"));
            bytes.push(localization.entropy(&model).to_bits().to_le_bytes().to_vec());
        }
        bytes
    };
    let portable = run(Instructions::PORTABLE);
    for instructions in Instructions::available() {
        assert!(run(instructions) == portable, "{}", instructions.name());
    }
}

#[test]
fn parameters_that_describe_no_grid_are_errors() {
    let error = |parameters| LocalizationModel::new(&room(), parameters).err();
    assert_eq!(error(LocalizationParameters { angle_step_deg: 7, ..parameters() }), Some(ModelError::AngleStep(7)));
    assert!(matches!(error(LocalizationParameters { cell_m: 0.05, ..parameters() }), Some(ModelError::CellSize(_))));
    assert_eq!(error(LocalizationParameters { sensors: Vec::new(), ..parameters() }), Some(ModelError::NoSensor));
    assert_eq!(error(LocalizationParameters { clearance_m: 3.0, ..parameters() }), Some(ModelError::NoFreeCell));
}

#[test]
fn two_mirror_poses_keep_their_share_along_a_symmetric_corridor() {
    let world = Arc::new(World::builtin("corridor").expect("it is built in"));
    let centre = world.size_m / 2.0;
    let mirrored = |pose: Pose| Pose::new(2.0 * centre.x - pose.x_m, 2.0 * centre.y - pose.y_m, pose.heading_rad + PI);
    let simulator = SimulatorModel::new(world.clone(), SimulatorSettings::default());
    let runs = [
        (LocalizationParameters::coarse(), 10_000),
        (LocalizationParameters::coarse(), 10_001),
        (LocalizationParameters::default(), 10_002),
    ];
    for (parameters, seed) in runs {
        let model = LocalizationModel::new(&world.map_centred(0.05), parameters).expect("the corridor is a map");
        let mut state = simulator.start(seed);
        let start = |pose| Localization::start_at(&model, pose, Spread::default());
        let mut localization = start(state.true_pose()).merged(&model, &start(mirrored(state.true_pose())));
        let mut ahead = 1.0;
        while state.distance_driven_m() < 50.0 {
            let pose = state.true_pose();
            // Up and down the corridor, at its middle, turning at 2 m from its ends.
            ahead = if pose.x_m < 4.0 {
                -1.0
            } else if pose.x_m > 23.0 {
                1.0
            } else {
                ahead
            };
            let off_course = wrap_angle_rad(pose.heading_rad - PI) + (pose.y_m - 10.0) * ahead * -0.5;
            let commands = Commands {
                translation_mps: 0.9 * ahead,
                rotation_radps: -off_course,
                sonars_on: true,
                ..Commands::default()
            };
            let percept = simulator.step(&mut state, &commands);
            let sonar_m = percept.sonar_m.as_deref();
            if localization.observe(&model, percept.odometry_in_odom, &[sonar_m]) {
                for pose in [state.true_pose(), mirrored(state.true_pose())] {
                    let (belief, leading) = localization.belief(&model);
                    let mass = belief.mass_near(leading, pose);
                    assert!((0.2..=0.8).contains(&mass), "{mass} after {:.1} m", state.distance_driven_m());
                }
            }
        }
    }
}

/// What is believed after a first scan and a second one, some centimetres on, by how their errors are correlated.
fn after_two_scans(correlation: Option<ErrorCorrelation>, is_second_heard: bool) -> [Vec<f64>; 2] {
    let sensors = vec![ScanParameters { correlation, ..parameters().sensors[0].clone() }];
    let model = model(LocalizationParameters { sensors, watch: None, activity_threshold: 0.0, ..parameters() });
    let mut localization = Localization::start_uniform(&model);
    let drive = drive(&model, 10_350, 12);
    [&drive[0], &drive[11]].map(|(odometry, scan_m)| {
        let is_heard = localization.updates() == 0 || is_second_heard;
        localization.observe(&model, *odometry, &[is_heard.then_some(scan_m.as_slice())]);
        probabilities(&model, localization.belief(&model).0)
    })
}

#[test]
fn of_a_scan_counts_what_the_last_one_has_not_told() {
    let correlated = |in_place: f64, length_m: f64| Some(ErrorCorrelation { in_place, length_m });
    let [first, alike] = after_two_scans(None, true);
    let [_, unheard] = after_two_scans(None, false);
    let differ = total_variation(&alike, &unheard);
    assert!(differ > 0.2, "{differ}");
    // The first scan counts in full however errors are correlated, and so does one whose errors are its own.
    for correlation in [correlated(1.0, 1000.0), correlated(0.5, 1.0), correlated(1.0, 1e-3)] {
        assert!(total_variation(&after_two_scans(correlation, true)[0], &first) < 1e-9);
    }
    assert!(total_variation(&after_two_scans(correlated(1.0, 1e-3), true)[1], &alike) < 1e-5);
    // The same errors once more tell nothing.
    assert!(total_variation(&after_two_scans(correlated(1.0, 1000.0), true)[1], &unheard) < 0.01);
    // What errs in part alike tells less, the less the nearer it is.
    let told = |length_m: f64| total_variation(&after_two_scans(correlated(0.8, length_m), true)[1], &unheard);
    let (near, far) = (told(100.0), told(0.5));
    assert!(0.05 * differ < near && near < 0.8 * far && far < 0.98 * differ, "{near} {far} {differ}");
}
