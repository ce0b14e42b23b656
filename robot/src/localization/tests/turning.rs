//! A robot that turns on the spot.

use super::*;

/// A walled room of 8 × 9 m, as large as a robot's sensors reach.
fn wide() -> OccupancyGrid {
    let mut map = OccupancyGrid::filled(Point::origin(), 0.1, 80, 90, Cell::Free);
    for (column, row) in (0..90).flat_map(|row| (0..80).map(move |column| (column, row))) {
        let desk = (30..50).contains(&column) && (70..80).contains(&row);
        if column == 0 || row == 0 || column == 79 || row == 89 || desk {
            map.set(column, row, Cell::Occupied);
        }
    }
    map
}

/// How far off the heading is at the worst, and how sure the robot is then, while it makes `quarters` quarter turns.
fn worst(parameters: LocalizationParameters, quarters: usize, seed: u64) -> (f64, f64) {
    let model = LocalizationModel::new(&wide(), parameters).expect("it is a map");
    let start = Pose::new(3.92, 4.47, 0.0);
    let mut localization = Localization::start_at(&model, start, Spread::default());
    let mut noise = Stream::new(seed, "turning");
    let (mut true_rad, mut told_rad) = (0.0, 0.0);
    let mut worst = (0.0, 0.0);
    for _ in 0..9 * quarters {
        let step_rad = 10.0_f64.to_radians();
        true_rad += step_rad;
        told_rad += step_rad + 1.5_f64.to_radians() * libm::sqrt(step_rad) * noise.normal();
        let truly = Pose::new(start.x_m, start.y_m, true_rad);
        let mut scan_m = scan_at(&model, truly);
        scan_m.iter_mut().for_each(|range_m| *range_m += 0.03 * noise.normal() as f32);
        localization.observe(&model, Pose::new(0.0, 0.0, told_rad), &[Some(&scan_m)]);
        let Estimate { pose_in_map, certainty } = localization.estimate(&model);
        let off_rad = wrap_angle_rad(pose_in_map.heading_rad - true_rad).abs();
        if off_rad > worst.0 {
            worst = (off_rad, certainty);
        }
    }
    worst
}

#[test]
fn a_robot_that_turns_on_the_spot_far_from_walls_keeps_its_heading() {
    for seed in 10_441..10_444 {
        let (off_rad, certainty) = worst(LocalizationParameters::default(), 60, seed);
        assert!(off_rad < 10.0_f64.to_radians(), "{seed}: {}° off at {certainty}", off_rad.to_degrees());
    }
}

#[test]
fn a_position_is_known_less_well_after_turning() {
    let model = model(fine());
    let pose = Pose::new(3.0, 2.0, 0.0);
    let near = |belief: &Belief| belief.mass_within(&model, pose, 0.3, PI);
    let turned = |odometry: &OdometryError| {
        let mut belief = Belief::around(&model, pose, Spread { position_m: 0.1, heading_rad: 0.05 });
        let before = near(&belief);
        for _ in 0..108 {
            belief.advance(&model, Pose::new(0.0, 0.0, 10.0_f64.to_radians()), odometry);
        }
        belief.sense(&model, &[]);
        before - near(&belief)
    };
    let scrubbing = OdometryError::default();
    assert!(turned(&scrubbing) > 0.1, "{}", turned(&scrubbing));
    let exact = OdometryError { position_per_radian_m: 0.0, ..scrubbing };
    assert!(turned(&exact).abs() < 0.02, "{}", turned(&exact));
}
