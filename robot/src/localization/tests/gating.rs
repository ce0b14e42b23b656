//! Readings that are left out because they may have measured people.

use super::*;
use crate::localization::gating::{Company, Crowd, leave_out_confusing, leave_out_novel, leave_out_short};
use crate::localization::sensor::BinnedScan;

/// A belief around a pose, in full view of all states.
fn belief(model: &LocalizationModel) -> Belief {
    Belief::around(model, Pose::new(2.5, 2.1, 0.3), Spread { position_m: 0.4, heading_rad: 0.3 })
}

/// A scan of noise and chance, some of it short.
fn scan(model: &LocalizationModel, stream: &mut Stream) -> BinnedScan {
    let expected = model.expected_scan(0, model.state_at(Pose::new(2.5, 2.1, 0.3)).expect("on the map"));
    let reading = |bin: u8| match stream.index(4) {
        0 => None,
        1 => Some((f64::from(bin) * stream.uniform()) as u8),
        2 => Some(stream.index(256) as u8),
        _ => Some(bin),
    };
    expected.into_iter().map(reading).collect()
}

/// Every state with its probability, and what a beam is expected to measure there.
fn expectations(model: &LocalizationModel, belief: &Belief, beam: usize) -> Vec<(f64, u8)> {
    let all = belief.all_states(model).into_iter().filter(|state| state.share > 0.0);
    all.map(|state| (state.share, model.expected_scan(0, state.state)[beam])).collect()
}

#[test]
fn the_entropy_filter_leaves_out_just_the_readings_that_raise_the_entropy() {
    let model = model(LocalizationParameters { activity_threshold: 0.0, watch: None, ..parameters() });
    let belief = belief(&model);
    let entropy = |shares: &[f64]| {
        let mass: f64 = shares.iter().sum();
        shares.iter().filter(|share| **share > 0.0).map(|share| -share / mass * libm::log(share / mass)).sum::<f64>()
    };
    let (mut kept, mut left_out) = (0, 0);
    let mut stream = Stream::new(10_330, "gating");
    for _ in 0..4 {
        let before = scan(&model, &mut stream);
        let mut after = before.clone();
        leave_out_confusing(&belief, &model, 0, &mut after);
        for (beam, bin) in before.iter().enumerate() {
            let Some(bin) = bin else { continue };
            let states = expectations(&model, &belief, beam);
            let prior: Vec<f64> = states.iter().map(|(share, _)| *share).collect();
            let likelihood = |expected| libm::exp(-model.sensors[0].likelihood.nats(*bin, expected));
            let posterior: Vec<f64> = states.iter().map(|(share, expected)| share * likelihood(*expected)).collect();
            let raised = entropy(&posterior) - entropy(&prior);
            if raised.abs() > 1e-5 {
                assert_eq!(after[beam].is_none(), raised > 0.0, "{beam}: {raised}");
                kept += usize::from(raised < 0.0);
                left_out += usize::from(raised > 0.0);
            }
        }
    }
    assert!(kept > 10 && left_out > 10, "{kept} and {left_out}");
}

#[test]
fn the_novelty_filter_leaves_out_just_the_readings_that_are_probably_shorter_than_the_map_shows() {
    let model = model(LocalizationParameters { activity_threshold: 0.0, watch: None, ..parameters() });
    let belief = belief(&model);
    let beam_model = &model.sensors[0].parameters.beam;
    // Φ by its sum, for the Gaussian of a beam around what is expected.
    let longer = |expected: u8, measured: u8| -> f64 {
        if expected == NO_ECHO {
            return if measured == NO_ECHO { 0.0 } else { 1.0 };
        }
        let at_m = |bin: u8| model.sensors[0].likelihood.range_m(bin);
        let sigma_m = beam_model.sigma_m + beam_model.sigma_per_m * at_m(expected);
        let sigmas = |bin: u8| (at_m(bin) - at_m(expected)) / sigma_m;
        let weight = |bin: u8| libm::exp(-0.5 * sigmas(bin) * sigmas(bin));
        let sum = |bins: std::ops::Range<u8>| bins.map(weight).sum::<f64>();
        if measured == NO_ECHO { 0.0 } else { sum(measured + 1..NO_ECHO) / sum(0..NO_ECHO) }
    };
    let (mut kept, mut left_out) = (0, 0);
    let mut stream = Stream::new(10_331, "gating");
    for _ in 0..4 {
        let before = scan(&model, &mut stream);
        let mut after = before.clone();
        leave_out_novel(0.9, &belief, &model, 0, &mut after);
        for (beam, bin) in before.iter().enumerate() {
            let Some(bin) = bin else { continue };
            let states = expectations(&model, &belief, beam);
            let mass: f64 = states.iter().map(|(share, _)| share).sum();
            let novel = states.iter().map(|(share, expected)| share * longer(*expected, *bin)).sum::<f64>() / mass;
            if (novel - 0.9).abs() > 1e-6 {
                assert_eq!(after[beam].is_none(), novel > 0.9, "{beam}: {novel}");
                kept += usize::from(novel < 0.9);
                left_out += usize::from(novel > 0.9);
            }
        }
    }
    assert!(kept > 10 && left_out > 10, "{kept} and {left_out}");
}

/// How many readings of a scan from the middle of the room, where walls are far enough for somebody to stand before them,
/// are left out, and for whom: half of them are short, and the others are off by `others_m`.
fn half_short(model: &LocalizationModel, others_m: f64, certainty: f64, crowd: &mut Crowd) -> (usize, Company) {
    let (short, sensor) = (ShortReadings::default(), &model.sensors[0]);
    let expected = model.expected_scan(0, model.state_at(Pose::new(2.5, 2.1, 0.3)).expect("on the map"));
    let range_m = |(beam, &bin): (usize, &u8)| {
        let off_m = if beam % 2 == 0 { -1.0 } else { others_m };
        (sensor.likelihood.range_m(bin) + off_m) as f32
    };
    let ranges_m: Vec<f32> = expected.iter().enumerate().map(range_m).collect();
    let mut scan = sensor.likelihood.scan(&ranges_m);
    let company = leave_out_short(&short, sensor, &expected, &ranges_m, certainty, crowd, &mut scan);
    (scan.iter().filter(|bin| bin.is_none()).count(), company)
}

#[test]
fn short_readings_are_left_out_where_the_others_have_fitted_and_count_where_they_come_from_farther() {
    let model = model(LocalizationParameters { activity_threshold: 0.0, watch: None, ..parameters() });
    let mut crowd = Crowd::default();
    for _ in 0..4 {
        assert_eq!(half_short(&model, 0.1, 0.9, &mut crowd), (12, Company::LeftOut));
    }
    // Carried elsewhere: within two scans everything counts, and goes on to count.
    let elsewhere: Vec<_> = (0..6).map(|_| half_short(&model, 0.8, 0.9, &mut crowd)).collect();
    assert_eq!(elsewhere[1..], [(0, Company::Few); 5]);
    // Of a pose that is as good as given up nothing is left out, whatever fits.
    let mut crowd = Crowd::default();
    assert_eq!(half_short(&model, 0.1, 0.01, &mut crowd), (0, Company::Few));
    assert_eq!(half_short(&model, 0.1, 0.1, &mut crowd), (12, Company::LeftOut));
}

#[test]
fn people_who_have_stood_around_for_long_are_still_there_when_a_scan_speaks_against_the_pose() {
    let model = model(LocalizationParameters { activity_threshold: 0.0, watch: None, ..parameters() });
    let mut crowd = Crowd::default();
    for _ in 0..30 {
        assert_eq!(half_short(&model, 0.1, 0.9, &mut crowd), (12, Company::LeftOut));
    }
    // Carried elsewhere: from the first or second scan all readings count, by the beam to which people are likely.
    let elsewhere: Vec<_> = (0..15).map(|_| half_short(&model, 0.8, 0.9, &mut crowd)).collect();
    assert_eq!(elsewhere[1..], [(0, Company::Counted); 14]);
    // Whoever is not seen for long is gone.
    let later: Vec<_> = (0..6).map(|_| half_short(&model, 0.8, 0.9, &mut crowd)).collect();
    assert_eq!(later[5], (0, Company::Few));
}
