//! Facts about choices and the state machine, in a corridor that looks the same from both ends but
//! for one room.

use super::*;
use crate::geometry::{Point, Pose, distance_m};
use crate::localization::{Localization, LocalizationModel, LocalizationParameters, Maximum, Spread};
use crate::occupancy::{Cell, OccupancyGrid};
use rpl_random::Stream;
use std::f64::consts::PI;

const LENGTH_M: f64 = 12.0;
const WIDTH_M: f64 = 9.0;

/// A corridor along x with a door in each long wall, each the other's mirror image about the
/// middle, and a room behind each; a box in the room at the top right makes the difference.
fn rooms(differ: bool) -> OccupancyGrid {
    let mut map = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.1, 120, 90, Cell::Free);
    for row in 0..90usize {
        for column in 0..120usize {
            let outer = row == 0 || row == 89 || column == 0 || column == 119;
            let door = |row: usize, column: usize| row == 59 && (80..90).contains(&column);
            let long_wall = row == 30 || row == 59;
            let wall = outer || long_wall && !door(row, column) && !door(89 - row, 119 - column);
            let furniture = differ && (65..80).contains(&row) && (92..112).contains(&column);
            if wall || furniture {
                map.set(column, row, Cell::Occupied);
            }
        }
    }
    map
}

fn model(differ: bool) -> LocalizationModel {
    let parameters = LocalizationParameters { cell_m: 0.2, angle_step_deg: 5, ..LocalizationParameters::default() };
    LocalizationModel::new(&rooms(differ), parameters).expect("the rooms are a map")
}

fn parameters() -> ActiveParameters {
    ActiveParameters { resolution_m: 0.2, reach_m: 12.0, ..ActiveParameters::default() }
}

fn mirrored(pose: Pose) -> Pose {
    Pose::new(LENGTH_M - pose.x_m, WIDTH_M - pose.y_m, pose.heading_rad + PI)
}

/// The pose and its mirror image, as likely as each other.
fn two_maxima(pose: Pose) -> [Maximum; 2] {
    [pose, mirrored(pose)].map(|pose_in_map| Maximum { pose_in_map, mass: 0.5 })
}

const START: Pose = Pose { x_m: 4.5, y_m: 4.5, heading_rad: 0.0 };

#[test]
fn the_distinguishing_room_is_chosen() {
    let model = model(true);
    let choice = choose(&model, &two_maxima(START), &[], &parameters()).expect("there is a way");
    let target = START.transform(choice.target_in_base);
    // The room differs behind either door, and both doors are the same target for the two poses.
    assert!(target.y > 6.0 || target.y < 3.0, "{target}");
    assert!((choice.current_entropy - std::f64::consts::LN_2).abs() < 1e-9);
    assert!(choice.expected_entropy < 0.35, "{}", choice.expected_entropy);
    let end = choice.path_in_base.last().copied();
    assert_eq!(end, Some(choice.target_in_base));
}

#[test]
fn nothing_is_expected_of_a_place_that_looks_the_same() {
    let parameters = parameters();
    let (_, field) = consider(&model(false), &two_maxima(START), &[], &parameters).expect("there is a way");
    for &entropy in field.expected_entropy.iter().filter(|entropy| entropy.is_finite()) {
        assert!(entropy > 0.6 && f64::from(entropy) <= std::f64::consts::LN_2 + 1e-6, "{entropy}");
    }
}

#[test]
fn what_is_not_looked_at_would_not_have_been_chosen() {
    let model = model(true);
    let mut stream = Stream::new(10_320, "maxima");
    let mut ways_m = Vec::new();
    for number in 0..30 {
        let (x_m, y_m) = (stream.uniform_in(0.5, LENGTH_M - 0.5), stream.uniform_in(3.5, WIDTH_M - 3.5));
        let pose = Pose::new(x_m, y_m, stream.uniform_in(-PI, PI));
        // The dearer the way, the sooner the search ends, and the nearer is what it must not miss.
        let parameters =
            ActiveParameters { target_step: 1, alpha_per_m: 0.02 * f64::from(1 + number % 5), ..parameters() };
        let all = consider(&model, &two_maxima(pose), &[], &parameters).map(|(choice, _)| choice);
        assert_eq!(choose(&model, &two_maxima(pose), &[], &parameters), all, "{pose:?}");
        ways_m.extend(all.map(|choice| choice.cost_m));
    }
    assert!(ways_m.len() > 20 && ways_m.iter().filter(|&&way_m| way_m > 3.0).count() > 5, "{ways_m:?}");
}

#[test]
fn fields_agree_with_each_other() {
    let (choice, field) = consider(&model(true), &two_maxima(START), &[], &parameters()).expect("there is a way");
    let best = field.grid.cell_at(choice.target_in_base).expect("the target is on the grid");
    let payoff = f64::from(field.payoff[best]);
    assert!((payoff + choice.expected_entropy + parameters().alpha_per_m * choice.cost_m).abs() < 1e-5);
    for (cell, &payoff) in field.payoff.iter().enumerate() {
        let far = field.grid.point_in_base(cell).coords.norm() > 1.5;
        let painted_over = field.cost_m[cell] < field.cost_m[best];
        assert!(payoff.is_nan() || !far || painted_over || f64::from(payoff) <= f64::from(field.payoff[best]) + 1e-5);
    }
    assert_eq!(field.cost_m[field.grid.robot()], 0.0);
}

#[test]
fn left_of_the_robot_is_positive_y() {
    let model = model(true);
    let one = [Maximum { pose_in_map: Pose::new(6.0, 4.5, 0.0), mass: 1.0 }];
    let (_, field) = consider(&model, &one, &[], &parameters()).expect("there is a way");
    // The door at the top, at (8.5, 6), lies ahead and to the left of a robot that looks along x.
    let occupancy = |x: f64, y: f64| field.grid.cell_at(Point::new(x, y)).map(|cell| field.occupancy[cell]);
    assert!(occupancy(2.4, 1.4).is_some_and(|value| value < 0.5));
    assert_eq!(occupancy(2.4, -1.4), Some(1.0));
}

#[test]
fn occupancy_is_the_overlay_weighted_by_mass() {
    let model = model(true);
    let mut maxima = two_maxima(START);
    maxima[0].mass = 0.3;
    maxima[1].mass = 0.1;
    let alone = |index: usize| consider(&model, &maxima[index..=index], &[], &parameters()).expect("there is a way").1;
    let (a, b) = (alone(0).occupancy, alone(1).occupancy);
    let (_, both) = consider(&model, &maxima, &[], &parameters()).expect("there is a way");
    for (cell, value) in both.occupancy.iter().enumerate() {
        assert!((value - (0.75 * a[cell] + 0.25 * b[cell])).abs() < 1e-5);
    }
}

#[test]
fn the_sum_over_the_belief_chooses_as_well_as_the_maxima_when_these_are_all_there_is() {
    let model = model(true);
    let [a, b] = two_maxima(START).map(|maximum| maximum.pose_in_map);
    let exact = Spread { position_m: 0.02, heading_rad: 0.01 };
    let localization =
        Localization::start_at(&model, a, exact).merged(&model, &Localization::start_at(&model, b, exact));
    let maxima = localization.maxima(&model, 10, 0.01);
    let choice = choose(&model, &maxima, &[], &parameters()).expect("there is a way");
    let sum = choose_exactly(&model, &localization, choice.target_in_base, &parameters()).expect("there is a way");
    assert!((sum.choice.current_entropy - std::f64::consts::LN_2).abs() < 0.3, "{}", sum.choice.current_entropy);
    let other = sum.payoff_of_other.expect("there is a way for both");
    assert!(other <= sum.payoff + 1e-9 && sum.payoff - other < 0.2, "{other} {}", sum.payoff);
}

#[test]
fn a_way_found_blocked_is_left() {
    let model = model(true);
    let maxima = two_maxima(START);
    let first = choose(&model, &maxima, &[], &parameters()).expect("there is a way");
    let second = choose(&model, &maxima, &[first.target_in_base], &parameters()).expect("there is another");
    assert!(distance_m(first.target_in_base, second.target_in_base) > 0.4);
    assert!(choose(&model, &[], &[], &parameters()).is_none());
}

fn start(model: &LocalizationModel, localization: &mut Localization) -> ActiveLocalization {
    ActiveLocalization::start(model, localization, Pose::default(), 0, parameters())
}

#[test]
fn a_robot_that_knows_keeps_its_belief_and_is_done_when_that_is_confirmed() {
    let model = model(true);
    let mut localization = Localization::start_at(&model, START, Spread::default());
    let before = localization.clone();
    let mut active = start(&model, &mut localization);
    assert_eq!(localization, before);
    let mut odometry = Pose::default();
    let mut intents = Vec::new();
    for _ in 0..12 {
        odometry = odometry.compose(Pose::new(0.15, 0.0, 0.0));
        let scan = scan_at(&model, START.compose(odometry));
        localization.observe(&model, odometry, &[Some(&scan)]);
        intents.push(active.step(&model, &mut localization, odometry, false, 0));
    }
    // It drives to where it hears more, and does not wander.
    assert!(matches!(intents[0], Intent::FollowPath { .. }), "{:?}", intents[0]);
    assert_eq!(intents.last(), Some(&Intent::Done));
}

#[test]
fn a_lost_robot_starts_over_and_fails_when_time_is_up() {
    let model = model(true);
    let mut localization = Localization::start_uniform(&model);
    let mut active = start(&model, &mut localization);
    assert!(localization.estimate(&model).certainty < 0.1);
    assert_eq!(active.step(&model, &mut localization, Pose::default(), false, 0), Intent::Explore(Exploration::Wander));
    assert_eq!(active.step(&model, &mut localization, Pose::default(), false, 600_000_000), Intent::Failed);
}

#[test]
fn a_position_that_is_lost_on_the_way_is_given_up_once() {
    let model = model(true);
    let mut localization = Localization::start_at(&model, START, Spread::default());
    let mut active = start(&model, &mut localization);
    let follow = active.step(&model, &mut localization, Pose::default(), false, 0);
    assert!(matches!(follow, Intent::FollowPath { .. }), "{follow:?}");
    // Two places come to be as likely as each other.
    let elsewhere = Localization::start_at(&model, mirrored(START), Spread::default());
    localization = localization.merged(&model, &elsewhere);
    let entropy = localization.entropy(&model);
    let lost = active.step(&model, &mut localization, Pose::default(), false, 0);
    assert_eq!(lost, Intent::Explore(Exploration::Wander));
    assert!(localization.entropy(&model) > entropy + 1.0);
    let given_up = localization.clone();
    active.step(&model, &mut localization, Pose::default(), false, 0);
    assert_eq!(localization, given_up);
}

#[test]
fn wandering_ends_after_its_way_and_a_saved_machine_goes_on_alike() {
    let model = model(true);
    let mut localization = Localization::start_uniform(&model);
    let mut active = start(&model, &mut localization);
    let scan = scan_at(&model, START);
    // Two scans, so that there are maxima to choose by.
    (0..25).for_each(|_| _ = localization.observe(&model, Pose::default(), &[Some(&scan)]));
    assert_eq!(
        active.step(&model, &mut localization, Pose::new(10.0, 0.0, 0.0), false, 0),
        Intent::Explore(Exploration::Wander)
    );
    let bytes = postcard::to_allocvec(&active).expect("it can be written");
    let mut loaded: ActiveLocalization = postcard::from_bytes(&bytes).expect("and read");
    let next = active.step(&model, &mut localization, Pose::new(20.1, 0.0, 0.0), false, 0);
    assert!(matches!(next, Intent::FollowPath { .. }), "{next:?}");
    assert_eq!(loaded.step(&model, &mut localization, Pose::new(20.1, 0.0, 0.0), false, 0), next);
    assert_eq!(loaded, active);
}

fn scan_at(model: &LocalizationModel, pose_in_map: Pose) -> Vec<f32> {
    let state = model.state_at(pose_in_map).expect("a pose on the map");
    model.expected_scan(0, state).into_iter().map(|bin| model.sensors[0].likelihood.range_m(bin) as f32).collect()
}
