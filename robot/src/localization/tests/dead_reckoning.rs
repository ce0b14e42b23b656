//! Where nothing is in reach of the sensors: uncertain, and not lost.

use super::*;
use crate::description::{OdometryDrift, RobotDescription};

/// A walled hall of 40 × 30 m.
fn hall() -> LocalizationModel {
    let mut map = OccupancyGrid::filled(Point::origin(), 0.1, 400, 300, Cell::Free);
    for (column, row) in (0..300).flat_map(|row| (0..400).map(move |column| (column, row))) {
        if column == 0 || row == 0 || column == 399 || row == 299 {
            map.set(column, row, Cell::Occupied);
        }
    }
    LocalizationModel::new(&map, LocalizationParameters { angle_step_deg: 5, ..parameters() }).expect("it is a map")
}

/// Drives ahead from the middle of the hall, steps of 20 cm, and hears what is to be heard there, or else what is heard
/// elsewhere.
fn driven(model: &LocalizationModel, steps: usize, heard_from: impl Fn(Pose) -> Pose) -> Localization {
    let start = Pose::new(12.0, 15.0, 0.0);
    let mut localization = Localization::start_at(model, start, Spread::default());
    for step in 0..steps {
        let odometry = Pose::new(0.2 * step as f64, 0.0, 0.0);
        let scan_m = scan_at(model, heard_from(start.compose(odometry)));
        localization.observe(model, odometry, &[Some(&scan_m)]);
    }
    localization
}

#[test]
fn a_robot_that_hears_nothing_where_nothing_is_to_be_heard_is_uncertain_and_not_lost() {
    let model = hall();
    let near = driven(&model, 10, |pose| pose);
    let far = driven(&model, 80, |pose| pose);
    let certainty = |localization: &Localization| localization.estimate(&model).certainty;
    assert!(certainty(&far) < 0.6 && certainty(&far) < certainty(&near), "{}", certainty(&far));
    assert!(far.tracking(&model) > 0.95, "{}", far.tracking(&model));
    assert!(far.estimate(&model).pose_in_map.distance_m(Pose::new(27.8, 15.0, 0.0)) < 0.3);
    assert!(certainty(&near) <= near.tracking(&model));
}

#[test]
fn a_robot_that_hears_a_corner_where_nothing_is_to_be_heard_is_lost() {
    let model = hall();
    let corner = |pose: Pose| if pose.x_m < 17.0 { pose } else { Pose::new(pose.x_m - 15.2, 1.4, 0.0) };
    let carried = driven(&model, 40, corner);
    assert!(carried.tracking(&model) < 0.8, "{}", carried.tracking(&model));
}

#[test]
fn a_scan_without_an_echo_where_none_is_expected_tells_nothing() {
    let model = hall();
    let told = |pose: Pose, heard_at: Pose| {
        let scan_m = scan_at(&model, heard_at);
        model.told(pose, &model.binned(&[Some(&scan_m)]))
    };
    let (middle, wall) = (Pose::new(20.0, 15.0, 0.0), Pose::new(20.0, 1.0, 0.0));
    assert_eq!(told(middle, middle), 0.0);
    assert!(told(middle, wall) > 0.2 && told(wall, middle) > 0.2 && told(wall, wall) > 0.2);
}

#[test]
fn what_odometry_is_said_to_stray_by_is_what_the_belief_spreads_by() {
    let drift = |heading_deg: f64| OdometryDrift {
        rotation_noise_rad_per_sqrt_m: heading_deg.to_radians(),
        ..RobotDescription::papers().odometry
    };
    let error = |heading_deg| OdometryError::of(&drift(heading_deg));
    assert!(error(8.0).turn_per_metre_rad >= 8f64.to_radians());
    assert!(error(8.0).turn_per_metre_rad < 10f64.to_radians());
    assert_eq!(error(8.0).forward_m, error(0.5).forward_m);
    // No odometry is without errors.
    let least = OdometryError::of(&OdometryDrift::NONE);
    assert!(least.forward_m > 0.0 && least.turn_per_metre_rad > 0.0 && least.turn_per_radian_rad > 0.0);
}

#[test]
fn what_is_awake_within_a_distance_is_what_is_there() {
    let model = model(fine());
    let pose = Pose::new(2.0, 2.0, 0.3);
    let belief = Belief::around(&model, pose, Spread { position_m: 0.4, heading_rad: 0.2 });
    for (radius_m, angle_rad) in [(0.5, 0.26), (1.0, 0.5), (1.7, 0.9)] {
        let [all, awake] =
            [Belief::mass_within, Belief::awake_within].map(|of| of(&belief, &model, pose, radius_m, angle_rad));
        assert!((all - awake).abs() < 0.01 && awake <= all + 1e-9, "{all} {awake}");
    }
}
