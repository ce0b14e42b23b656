//! Odometry that jumps in its heading from one scan to the next.

use super::*;

/// The odometry of a drive, with jumps by so much at some steps.
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

/// At each step after the first, whether the estimate is right, and how sure it is.
fn judged(faults: Option<OdometryFaults>, jumps_rad: &[(usize, f64)]) -> Vec<(bool, f64)> {
    let sensors = vec![ScanParameters { gating: None, tempering: 0.2, ..ScanParameters::default() }];
    let model = model(LocalizationParameters {
        faults,
        sensors,
        watch: None,
        calibration: None,
        update_distance_m: 0.1,
        ..fine()
    });
    let start = Pose::new(2.0, 2.0, 0.0);
    let mut localization = Localization::start_at(&model, start, Spread::default());
    let driven = drive(&model, 10_332, 48);
    let steps = driven.iter().zip(jumping(&driven, jumps_rad)).map(|((exact, scan_m), odometry)| {
        localization.observe(&model, odometry, &[Some(scan_m)]);
        let Estimate { pose_in_map, certainty } = localization.estimate(&model);
        let truth = start.compose(*exact);
        let off_rad = wrap_angle_rad(pose_in_map.heading_rad - truth.heading_rad).abs();
        (pose_in_map.distance_m(truth) < 0.4 && off_rad < 0.2, certainty)
    });
    steps.collect()
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
