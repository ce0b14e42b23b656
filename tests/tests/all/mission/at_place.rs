//! Work at a place: what leads the robot away from it, whether a plan or somebody's hands, it comes back from.

use rpl_tests::mission::{Mission, Run, test_room};

/// Looks for six seconds in all, and tells after each second how far it is from the place. The second half of what
/// it says stands a step after the time in which it looked.
const INSPECTION: &str = "
(at-place 'table-side
  (dotimes (second 6)
    (wait-time 1 :active)
    (print (list (now) (distance-to 'table-side)))))";

/// Times and distances, as they were told.
fn told(run: &Run) -> Vec<(f64, f64)> {
    let pair = |line: &String| {
        let (time, distance) = line.trim_matches(['(', ')']).split_once(' ').expect("two numbers");
        (time.parse().expect("a time"), distance.parse().expect("a distance"))
    };
    run.output.iter().map(pair).collect()
}

fn run(plan: &str, scenario: &str) -> Vec<(f64, f64)> {
    let run = Mission::new(test_room(), plan).with_scenario(scenario).run(1, 300.0);
    assert!(run.outcome().starts_with("=>"), "{}\n{}", run.outcome(), run.trace());
    told(&run)
}

#[track_caller]
fn comes_back(told: &[(f64, f64)]) {
    assert_eq!(told.len(), 6, "{told:?}");
    assert!(told.iter().all(|&(_, distance_m)| distance_m < 0.5), "{told:?}");
    let longest_s = told.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max);
    assert!(longest_s > 10.0, "nothing came between: {told:?}");
}

#[test]
fn an_errand_that_leads_away_is_come_back_from() {
    let errand = "(def-plan errand () (wait-time 10) (with-valve wheels (go-to 'corner)))";
    comes_back(&run(&format!("{errand} (with-policy (errand) {INSPECTION})"), "nil"));
}

#[test]
fn hands_that_carry_the_robot_away_are_come_back_from() {
    let told = run(INSPECTION, "(wait-time 10.5) (teleport-robot! 6.5 1.5 0)");
    // Until the sensors show that it was carried away it believes itself to be there.
    comes_back(&told);
}

/// Without it, whoever waits goes on wherever the errand has ended.
#[test]
fn a_place_that_cannot_be_come_back_to_fails_the_work() {
    let errand = "(def-plan errand () (wait-time 10) (with-valve wheels (go-to 'corner)))";
    let plan = format!("{errand} (with-policy (errand) {INSPECTION})");
    let scenario = "(wait-time 30) (close-door! 'east)";
    let run = Mission::new(test_room(), &plan).with_scenario(scenario).run(1, 600.0);
    assert!(run.outcome().starts_with("failed: blocked"), "{}", run.outcome());
    assert!(told(&run).len() < 6);
}

#[test]
fn the_patience_of_a_place_is_that_of_the_way_to_it() {
    let failed_at_s = |patience: &str| {
        let plan = format!(
            "(with-failure-handling ((blocked (f) (print (now)))) (at-place 'table-side {patience} (wait-time 600 :active)))"
        );
        let scenario = "(wait-time 20) (teleport-robot! 6.5 1.5 0) (close-door! 'east)";
        let run = Mission::new(test_room(), &plan).with_scenario(scenario).run(1, 900.0);
        run.output.first().and_then(|line| line.parse::<f64>().ok())
    };
    let (patient_s, impatient_s) = (failed_at_s("").expect("it fails"), failed_at_s(":patience 5").expect("it fails"));
    assert!(impatient_s + 5.0 < patient_s, "{impatient_s} and {patient_s}");
}
