//! What sleeps, wakes, and is shared.

use super::*;

#[test]
fn a_selective_update_stays_close_to_the_full_one() {
    let selective = model(LocalizationParameters { watch: None, ..fine() });
    let full = model(LocalizationParameters { activity_threshold: 0.0, watch: None, ..fine() });
    let mut belief = Belief::uniform(&selective);
    let (mut before, mut slept) = (Pose::default(), 0);
    for (odometry, scan_m) in drive(&selective, 10_001, 60) {
        let mut other = belief.clone();
        other.sleep_below(0.0);
        other.mix(&full, 0.0);
        for (model, belief) in [(&selective, &mut belief), (&full, &mut other)] {
            belief.advance(model, odometry.relative_to(before), &model.parameters.odometry);
            belief.sense_ranges(model, &[Some(&scan_m)]);
        }
        let apart = total_variation(&probabilities(&selective, &belief), &probabilities(&full, &other));
        assert!(apart < 1e-3, "{apart}");
        assert_eq!(other.active_planes(), full.grid.headings);
        slept += full.grid.headings - belief.active_planes();
        before = odometry;
    }
    assert!(slept > 0);
}

#[test]
fn what_is_left_of_a_motion_does_not_depend_on_when_a_plane_slept() {
    let selective = model(fine());
    let full = model(LocalizationParameters { activity_threshold: 0.0, ..fine() });
    let around = |model| Belief::around(model, Pose::new(2.0, 2.0, 0.0), Spread::default());
    let (mut belief, mut always) = (around(&selective), around(&full));
    let (mut before, mut forgotten) = (Pose::default(), 0);
    for (odometry, scan_m) in drive(&selective, 10_003, 60) {
        for (model, belief) in [(&selective, &mut belief), (&full, &mut always)] {
            belief.advance(model, odometry.relative_to(before), &model.parameters.odometry);
            belief.sense_ranges(model, &[Some(&scan_m)]);
        }
        for (plane, other) in belief.planes().iter().zip(always.planes()) {
            assert_eq!((plane.offset_cells, plane.variance_cells), (other.offset_cells, other.variance_cells));
            forgotten += usize::from(!plane.is_active());
        }
        before = odometry;
    }
    assert!(forgotten > 0);
}

#[test]
fn what_a_localized_belief_keeps_does_not_grow_with_the_map() {
    let alone = room();
    let tiles = [1, 6].map(|times| {
        let columns = alone.columns * times;
        let mut map = OccupancyGrid::filled(Point::origin(), 0.1, columns, alone.rows * times, Cell::Free);
        for (column, row) in (0..map.rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
            map.set(column, row, alone.get(column % alone.columns, row % alone.rows));
        }
        let parameters = LocalizationParameters { watch: None, ..fine() };
        let model = LocalizationModel::new(&map, parameters).expect("the rooms are a map");
        let mut belief = Belief::around(&model, Pose::new(2.0, 2.0, 0.0), Spread::default());
        let (mut before, mut most) = (Pose::default(), 0);
        for (odometry, scan_m) in drive(&model, 10_005, 40) {
            belief.advance(&model, odometry.relative_to(before), &model.parameters.odometry);
            belief.sense_ranges(&model, &[Some(&scan_m)]);
            most = most.max(belief.tiles().count());
            before = odometry;
        }
        (most, model.ground.numbers().len())
    });
    let [(few, one), (still_few, many)] = tiles;
    assert!(many >= 20 * one && still_few <= 3 * few, "{few} of {one}, {still_few} of {many}");
}

#[test]
fn planes_that_slept_come_back_when_the_robot_was_turned() {
    let model = LocalizationModel::new(&corridor(), fine()).expect("the corridor is a map");
    let mut localization = Localization::start_at(&model, Pose::new(8.0, 1.5, 0.0), Spread::default());
    assert!(localization.belief(&model).0.active_planes() < 15);
    // Turned by hand: odometry goes on as if nothing had happened.
    let mut truth = Pose::new(8.0, 1.5, FRAC_PI_2);
    let mut odometry = Pose::default();
    for step in 0..30 {
        let motion = if step < 10 { Pose::new(0.0, 0.0, FRAC_PI_2 / 10.0) } else { Pose::new(0.15, 0.0, 0.0) };
        (truth, odometry) = (truth.compose(motion), odometry.compose(motion));
        localization.observe(&model, odometry, &[Some(&scan_at(&model, truth))]);
    }
    let estimate = localization.estimate(&model);
    assert!(estimate.pose_in_map.distance_m(truth) < 0.5 && estimate.certainty > 0.8, "{estimate:?} {truth:?}");
}

#[test]
fn forks_share_tiles_until_one_writes() {
    let model = model(parameters());
    let mut localization = Localization::start_at(&model, Pose::new(2.0, 2.0, 0.0), Spread::default());
    let fork = localization.clone();
    let shared = |a: &Localization, b: &Localization| {
        let pairs = a.belief(&model).0.planes().iter().zip(b.belief(&model).0.planes());
        pairs.map(|(a, b)| a.shared_tiles(b)).sum::<usize>()
    };
    let tiles = localization.belief(&model).0.tiles().count();
    assert!(tiles > 0 && shared(&localization, &fork) == tiles);
    let before = fork.clone();
    localization.observe(&model, Pose::default(), &[Some(&scan_at(&model, Pose::new(2.0, 2.0, 0.0)))]);
    assert!(shared(&localization, &fork) < tiles);
    assert_eq!(fork, before);
}
