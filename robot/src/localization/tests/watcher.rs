//! When the coarse belief sleeps, and what it knows when it wakes.

use super::super::model::Misfit;
use super::super::scan::Weighing;
use super::super::watcher::{Update, Watcher};
use super::*;

/// Of scans that fit as usual, and of those at a wrong pose.
const USUAL: Misfit = Misfit { nats: 1.8, mean_nats: 4.0 };
const WRONG: Misfit = Misfit { nats: 5.0, mean_nats: 4.0 };
/// Of scans at the right pose in a building that is not as its map.
const ROUGH: Misfit = Misfit { nats: 3.0, mean_nats: 4.0 };

fn update(model: &LocalizationModel, from_in_map: Pose, motion: Pose, scan_m: &[f32]) -> Update {
    let scans = model.binned(&[Some(scan_m)]);
    let (error, sightings) = (OdometryError::default(), Vec::new());
    Update { from_in_map, motion, error, scans, weighings: vec![Weighing::USUAL], mixed: 5e-4, sightings }
}

fn at_rest(model: &LocalizationModel) -> Update {
    let pose_in_map = Pose::new(2.0, 2.0, 0.4);
    update(model, pose_in_map, Pose::default(), &scan_at(model, pose_in_map))
}

#[test]
fn a_coarse_belief_that_wakes_has_heard_what_one_that_never_slept_has() {
    let model = model(fine());
    let coarse = model.watch.as_ref().expect("a coarse belief watches");
    let start = Pose::new(2.0, 2.0, 0.0);
    let mut awake = Watcher::awake(Belief::around(coarse, start, Spread::default()));
    let mut asleep = Watcher::asleep();
    let share = |watcher: &Watcher, pose_in_map: Pose| {
        let belief = watcher.belief().expect("it is awake");
        belief.mass_within(coarse, pose_in_map, 1.2, 40f64.to_radians())
    };
    let (mut before, mut mode_in_map) = (Pose::default(), start);
    let carried = Pose::new(0.0, 0.0, PI);
    let mut drive = drive(&model, 10_001, 70).into_iter();
    // First with scans of where the robot is taken to be, then of where it looks the other way.
    for (steps, carried) in [(60, Pose::default()), (10, carried)] {
        for (odometry, _) in drive.by_ref().take(steps) {
            let (from_in_map, motion) = (mode_in_map, odometry.relative_to(before));
            (before, mode_in_map) = (odometry, mode_in_map.compose(motion));
            let scan_m = scan_at(&model, mode_in_map.compose(carried));
            if let Some(belief) = awake.belief_mut() {
                belief.advance(coarse, motion, &coarse.parameters.odometry);
            }
            for watcher in [&mut awake, &mut asleep] {
                watcher.hear(coarse, update(coarse, from_in_map, motion, &scan_m), Some(USUAL));
            }
        }
        let mut woken = asleep.clone();
        woken.wake(coarse, mode_in_map);
        let truth_in_map = mode_in_map.compose(carried);
        let shares = [share(&awake, truth_in_map), share(&woken, truth_in_map)];
        assert!(shares.iter().all(|&share| share > 0.95), "{shares:?} after {steps}");
    }
}

#[test]
fn scans_that_fit_badly_wake_it_and_agreement_lets_it_sleep_again() {
    let model = model(fine());
    let coarse = model.watch.as_ref().expect("a coarse belief watches");
    let mut watcher = Watcher::asleep();
    (0..200).for_each(|_| watcher.hear(coarse, at_rest(coarse), Some(USUAL)));
    assert!(watcher.belief().is_none(), "scans that fit as usual wake nobody");
    (0..3).for_each(|_| watcher.hear(coarse, at_rest(coarse), Some(WRONG)));
    assert!(watcher.belief().is_some(), "three scans that fit badly are enough");
    let mut updates = 0;
    while watcher.belief().is_some() {
        watcher.hear(coarse, at_rest(coarse), Some(USUAL));
        watcher.agree(true);
        updates += 1;
    }
    assert!((40..50).contains(&updates), "it slept after {updates}");
    watcher.hear(
        coarse,
        Update { weighings: vec![Weighing { is_crowd: true, ..Weighing::USUAL }], ..at_rest(coarse) },
        Some(USUAL),
    );
    assert!(watcher.belief().is_some(), "people wake it at once");
}

#[test]
fn in_a_building_in_which_scans_fit_worse_it_learns_what_is_usual_and_sleeps() {
    let model = model(fine());
    let coarse = model.watch.as_ref().expect("a coarse belief watches");
    let mut watcher = Watcher::asleep();
    (0..20).for_each(|_| watcher.hear(coarse, at_rest(coarse), Some(ROUGH)));
    assert!(watcher.belief().is_some(), "at first they are a reason to look");
    for _ in 0..200 {
        watcher.hear(coarse, at_rest(coarse), Some(ROUGH));
        watcher.agree(true);
    }
    assert!(watcher.belief().is_none(), "no other place was found");
    (0..8).for_each(|_| watcher.hear(coarse, at_rest(coarse), Some(WRONG)));
    assert!(watcher.belief().is_some(), "those of a wrong pose still wake it");
}

#[test]
fn a_coarse_belief_that_wakes_has_its_cells_where_mirror_poses_fall_on_mirror_cells() {
    let model = model(fine());
    let coarse = model.watch.as_ref().expect("a coarse belief watches");
    let mut watcher = Watcher::asleep();
    watcher.wake(coarse, Pose::new(2.11, 1.93, 0.37));
    let belief = watcher.belief().expect("it is awake");
    assert_eq!(belief.heading_offset, 0.0);
    assert!(belief.planes().iter().all(|plane| plane.offset_cells.iter().all(|cells| cells.abs() < 1e-9)));
    assert!(belief.mass_within(coarse, Pose::new(2.11, 1.93, 0.37), 1.2, 40f64.to_radians()) > 0.99);
}

#[test]
fn a_coarse_belief_that_leads_looks_at_what_may_be_true_and_at_everything_once_that_fits_badly() {
    let model = model(fine());
    let coarse = model.watch.as_ref().expect("a coarse belief watches");
    let all = coarse.ground.numbers().len() * coarse.grid.headings;
    let mut belief = Belief::uniform(coarse);
    belief.sleep_below(2.0 * coarse.parameters.mixing * coarse.prior());
    assert_eq!(belief.tiles().count(), all);
    let (mut before, mut most, mut truth_in_map) = (Pose::default(), 0, Pose::new(2.0, 2.0, 0.0));
    for (step, (odometry, _)) in drive(coarse, 10_001, 60).into_iter().enumerate() {
        let motion = odometry.relative_to(before);
        (before, truth_in_map) = (odometry, truth_in_map.compose(motion));
        if step == 40 {
            assert!(belief.tiles().count() * 2 < all, "{} of {all} when it is found", belief.tiles().count());
            truth_in_map = truth_in_map.compose(Pose::new(0.0, 0.0, PI));
            most = 0;
        }
        belief.advance(coarse, motion, &coarse.parameters.odometry);
        belief.sense_ranges(coarse, &[Some(&scan_at(coarse, truth_in_map))]);
        most = most.max(belief.tiles().count());
    }
    assert_eq!(most, all, "all wakes when it is turned by hand");
    assert!(belief.tiles().count() * 2 < all, "{} of {all} when it is found again", belief.tiles().count());
    let share = belief.mass_within(coarse, truth_in_map, 1.2, 40f64.to_radians());
    assert!(share > 0.95, "{share}");
    belief.sleep_below(0.0);
    belief.sense(coarse, &[]);
    assert_eq!(belief.tiles().count(), all, "nothing sleeps while it watches");
}

#[test]
fn what_cannot_be_true_sleeps_in_the_coarse_belief_while_it_leads() {
    let (columns, rows) = (240, 160);
    let mut hall = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.1, columns, rows, Cell::Free);
    for (column, row) in (0..columns).flat_map(|column| (0..rows).map(move |row| (column, row))) {
        let wall = row == 0 || row == rows - 1 || column == 0 || column == columns - 1;
        let shelf = (100..160).contains(&column) && (40..48).contains(&row) || column < 30 && (90..150).contains(&row);
        if wall || shelf {
            hall.set(column, row, Cell::Occupied);
        }
    }
    let model = LocalizationModel::new(&hall, fine()).expect("the hall is a map");
    let coarse = model.watch.as_ref().expect("a coarse belief watches");
    let all = coarse.ground.numbers().len() * coarse.grid.headings;
    let mut localization = Localization::start_uniform(&model);
    let mut awake = Vec::new();
    for (odometry, scan_m) in drive(&model, 10_001, 60) {
        localization.observe(&model, odometry, &[Some(&scan_m)]);
        let (belief, leading) = localization.belief(&model);
        if leading.grid.headings == coarse.grid.headings {
            awake.push(belief.tiles().count());
        }
    }
    assert!(awake.len() > 3, "the coarse belief leads at first: {awake:?}");
    assert!(awake.iter().any(|&tiles| tiles < all), "{awake:?} of {all}");
}

#[test]
fn a_position_that_was_just_found_is_not_sure_before_both_beliefs_have_agreed_for_long() {
    let model = model(fine());
    let mut localization = Localization::start_uniform(&model);
    let (mut found, mut sure) = (None, None);
    for (step, (odometry, scan_m)) in drive(&model, 10_001, 150).into_iter().enumerate() {
        localization.observe(&model, odometry, &[Some(&scan_m)]);
        let certainty = localization.estimate(&model).certainty;
        found = found.or((certainty > 0.9).then_some(step));
        sure = sure.or((certainty > 0.98).then_some(step));
    }
    let (Some(found), Some(sure)) = (found, sure) else { panic!("found at {found:?}, sure at {sure:?}") };
    assert!(sure >= found + 30, "found at {found}, sure at {sure}");
}
