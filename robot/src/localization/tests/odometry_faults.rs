//! Odometry that jumps in its heading from one scan to the next, or that has no sign.

use super::*;

/// The odometry of a drive, with jumps by these angles at these steps.
fn jumping(drive: &[(Pose, Vec<f32>)], jumps_rad: &[(usize, f64)]) -> Vec<Pose> {
    let (mut before, mut odometry) = (Pose::default(), Pose::default());
    let step = |(step, (exact, _)): (usize, &(Pose, Vec<f32>))| {
        let jump_rad = jumps_rad.iter().find(|(at, _)| *at == step).map_or(0.0, |(_, jump_rad)| *jump_rad);
        odometry = odometry.compose(exact.relative_to(before)).compose(Pose::new(0.0, 0.0, jump_rad));
        before = *exact;
        odometry
    };
    drive.iter().enumerate().map(step).collect()
}

const START: Pose = Pose { x_m: 2.0, y_m: 2.0, heading_rad: 0.0 };

fn expecting(faults: Option<OdometryFaults>) -> LocalizationModel {
    let sensors = vec![ScanParameters { gating: None, tempering: 0.2, ..ScanParameters::default() }];
    model(LocalizationParameters { faults, sensors, watch: None, calibration: None, update_distance_m: 0.1, ..fine() })
}

/// At each step, whether the estimate is right, and how sure it is.
fn followed(model: &LocalizationModel, drive: &[(Pose, Vec<f32>)], odometry: &[Pose]) -> Vec<(bool, f64)> {
    let mut localization = Localization::start_at(model, START, Spread::default());
    let steps = drive.iter().zip(odometry).map(|((exact, scan_m), odometry)| {
        localization.observe(model, *odometry, &[Some(scan_m)]);
        let Estimate { pose_in_map, certainty } = localization.estimate(model);
        let truth = START.compose(*exact);
        let off_rad = wrap_angle_rad(pose_in_map.heading_rad - truth.heading_rad).abs();
        (pose_in_map.distance_m(truth) < 0.4 && off_rad < 0.2, certainty)
    });
    steps.collect()
}

fn judged(faults: Option<OdometryFaults>, jumps_rad: &[(usize, f64)]) -> Vec<(bool, f64)> {
    let model = expecting(faults);
    let driven = drive(&model, 10_332, 48);
    followed(&model, &driven, &jumping(&driven, jumps_rad))
}

#[test]
fn a_jump_of_the_odometry_is_seen_through_at_once() {
    let jumps_rad: Vec<(usize, f64)> = [(10, 0.5), (19, -0.4), (28, 0.3), (37, -0.5)].to_vec();
    let wrong = |faults| judged(faults, &jumps_rad).iter().filter(|(is_right, _)| !is_right).count();
    let sure = |faults| judged(faults, &jumps_rad).iter().filter(|(right, sure)| !right && *sure >= 0.9).count();
    let expects = || Some(OdometryFaults::default());
    assert!(wrong(None) >= 8, "{} {} {}", wrong(None), wrong(expects()), sure(expects()));
    assert!(wrong(expects()) <= 2 && sure(expects()) == 0, "{} {}", wrong(expects()), sure(expects()));
}

#[test]
fn who_expects_jumps_believes_the_same_where_there_are_none() {
    let [expecting, not] = [Some(OdometryFaults::default()), None].map(|faults| judged(faults, &[]));
    assert!(expecting.iter().all(|(is_right, _)| *is_right));
    for (step, (expecting, not)) in expecting.iter().zip(&not).enumerate() {
        assert!((expecting.1 - not.1).abs() < 0.02, "{step}: {expecting:?} {not:?}");
    }
}

/// Steps along a line, and the scans there.
fn along(model: &LocalizationModel, steps_m: &[f64], turn_at: Option<(usize, f64)>) -> Vec<(Pose, Vec<f32>)> {
    let mut exact = Pose::default();
    let step = |(step, along_m): (usize, &f64)| {
        let turn_rad = turn_at.filter(|(at, _)| *at == step).map_or(0.0, |(_, turn_rad)| turn_rad);
        exact = exact.compose(Pose::new(*along_m, 0.0, turn_rad));
        (exact, scan_at(model, START.compose(exact)))
    };
    steps_m.iter().enumerate().map(step).collect()
}

#[test]
fn a_way_backward_that_was_counted_as_one_forward_is_found_out() {
    let steps_m: Vec<f64> = [[0.2; 8], [-0.2; 8], [0.2; 8]].concat();
    let counted: Vec<Pose> = (1..=24).map(|step| Pose::new(0.2 * f64::from(step), 0.0, 0.0)).collect();
    let wrong = |faults| {
        let model = expecting(faults);
        let steps = followed(&model, &along(&model, &steps_m, None), &counted);
        assert!(steps.iter().take(8).all(|(is_right, _)| *is_right));
        steps.iter().filter(|(is_right, _)| !is_right).count()
    };
    let [without, with] = [0.0, 0.01].map(|reversal| wrong(Some(OdometryFaults { reversal, ..Default::default() })));
    // Half a metre of a way backward looks like one forward still.
    assert!(with <= 2 && without >= 5, "{with} {without}");
}

#[test]
fn a_turn_that_the_odometry_did_not_tell_is_noticed_by_the_scan() {
    let right = |faults| {
        let model = expecting(faults);
        let steps_m: Vec<f64> = [[0.2; 5], [0.0; 5]].concat();
        let driven = along(&model, &steps_m, Some((6, 0.4)));
        let odometry: Vec<Pose> = driven.iter().map(|(exact, _)| Pose { heading_rad: 0.0, ..*exact }).collect();
        followed(&model, &driven, &odometry)[6..].iter().filter(|(is_right, _)| *is_right).count()
    };
    assert_eq!((right(None), right(Some(OdometryFaults::default()))), (0, 4));
}
