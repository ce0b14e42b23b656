//! Whether an instruction is wrong.

use crate::synthetic::{Openings, openings, percept};
use rpl_lola::feature::{Feature, HiddenWall, Percept, Side};
use rpl_lola::instruction::Goal;
use rpl_lola::judgement::{Expectation, FaultKind, Judgement, Look, Verdict};
use rpl_lola::state_set::Matrix;
use rpl_random::Stream;

use Feature::{ClosedDoor, Hallway, OpenDoor};

fn goal(ordinal: u8, side: Side, kind: Feature) -> Goal {
    Goal { ordinal, side, kind }
}

/// A look along a whole hallway with these percepts, 4 m apart, on the sides; it ends 4 m behind the last.
fn look(left: &[Feature], right: &[Feature]) -> (Look, f64) {
    let of = |side, seen: &[Feature]| -> Vec<Percept> {
        let at = |(at, &seen): (usize, &Feature)| percept(at as u64, side, seen, 4.0 * (at + 1) as f64);
        seen.iter().enumerate().map(at).collect()
    };
    let end_m = 4.0 * (left.len().max(right.len()) + 1) as f64;
    let percepts = [of(Side::Left, left), of(Side::Right, right)].concat();
    (Look { from_m: 0.0, to_m: end_m, percepts, hidden: Vec::new() }, end_m)
}

fn judged(goal: Goal, left: &[Feature], right: &[Feature]) -> Judgement {
    let (look, end_m) = look(left, right);
    Judgement::of(goal, &[look], Some(end_m), &Expectation::of_event(Matrix::MARKED))
}

#[test]
fn what_was_seen_is_said() {
    let (third_left, fourth_left) = (goal(3, Side::Left, Hallway), goal(4, Side::Left, Hallway));
    let cases = [
        (
            third_left,
            &[Hallway, Hallway, OpenDoor][..],
            &[][..],
            "the third left is a door; I saw hallways at the first and second",
        ),
        (
            third_left,
            &[ClosedDoor, Hallway],
            &[],
            "there is no third left; I saw a closed door at the first, and a hallway at the second",
        ),
        (
            fourth_left,
            &[OpenDoor, Hallway, OpenDoor],
            &[OpenDoor, ClosedDoor, OpenDoor, Hallway],
            "there is no fourth left, but the fourth right is a hallway; I saw doors at the first and third, and a hallway at the second",
        ),
        (goal(1, Side::Right, OpenDoor), &[], &[ClosedDoor, OpenDoor], "the first right is a closed door"),
        (
            goal(1, Side::Right, OpenDoor),
            &[OpenDoor, OpenDoor],
            &[],
            "there is no first right, but the first left is a door; I saw no opening on the right",
        ),
    ];
    for (goal, left, right, sentence) in cases {
        let judgement = judged(goal, left, right);
        assert_eq!(judgement.sentence, sentence);
        assert!(judgement.right < 0.5, "{goal}: {judgement:?}");
    }
}

#[test]
fn what_is_right_is_where_it_was_seen() {
    let goal = goal(2, Side::Right, OpenDoor);
    let judgement = judged(goal, &[Hallway], &[ClosedDoor, OpenDoor, Hallway]);
    assert_eq!(judgement.verdict(), Verdict::Right);
    assert_eq!(judgement.at.map(|percept| percept.middle_m()), Some(8.0));
}

/// The second left is asked for, and one opening was seen: another may be behind a box, if there is one.
#[test]
fn a_box_speaks_for_an_opening_that_was_not_seen() {
    let asked = goal(2, Side::Left, Hallway);
    let (clear, end_m) = look(&[Hallway], &[]);
    let behind = |side| {
        let hidden = vec![HiddenWall { side, from_m: 0.8, to_m: 2.4 }];
        Judgement::of(asked, &[Look { hidden, ..clear.clone() }], Some(end_m), &Expectation::of_event(Matrix::SONAR))
    };
    let open = Judgement::of(asked, std::slice::from_ref(&clear), Some(end_m), &Expectation::of_event(Matrix::SONAR));
    assert!(behind(Side::Left).right > 2.0 * open.right, "{} against {}", behind(Side::Left).right, open.right);
    assert_eq!(behind(Side::Right).right, open.right, "on the other side");
}

#[test]
fn probabilities_sum_to_one() {
    let mut stream = Stream::new(3, "judged");
    for _ in 0..300 {
        let mut side = || -> Vec<Feature> {
            let count = stream.index(8);
            (0..count).map(|_| Feature::ALL[1 + stream.index(4)]).collect()
        };
        let (left, right) = (side(), side());
        for ordinal in [1, 4, 10] {
            let judgement = judged(goal(ordinal, Side::Left, Hallway), &left, &right);
            let sum = judgement.right + judgement.no_such_opening + judgement.other_kind;
            assert!((sum - 1.0).abs() < 1e-9, "{judgement:?}");
            let readings: f64 = judgement.readings.iter().map(|reading| reading.probability).sum();
            assert!(judgement.readings.is_empty() || (readings - 1.0).abs() < 1e-9, "{judgement:?}");
        }
    }
}

#[test]
fn what_was_meant_is_guessed() {
    let other_side =
        judged(goal(3, Side::Left, Hallway), &[OpenDoor, ClosedDoor, ClosedDoor], &[OpenDoor, OpenDoor, Hallway]);
    assert_eq!(other_side.likeliest_reading().map(|reading| reading.goal), Some(goal(3, Side::Right, Hallway)));
    assert!(other_side.other_side() > 0.5);
    let one_too_many = judged(goal(4, Side::Right, Hallway), &[], &[OpenDoor, ClosedDoor, Hallway, OpenDoor]);
    assert_eq!(one_too_many.likeliest_reading().map(|reading| reading.goal), Some(goal(3, Side::Right, Hallway)));
    assert_eq!(one_too_many.likeliest_reading().map(|reading| reading.at.middle_m()), Some(12.0));
}

#[test]
fn before_the_end_nothing_is_missing() {
    let goal = goal(4, Side::Left, Hallway);
    let (look, end_m) = look(&[OpenDoor, Hallway], &[]);
    let expectation = Expectation::of_event(Matrix::MARKED);
    let under_way = Judgement::of(goal, std::slice::from_ref(&look), None, &expectation);
    assert_eq!(under_way.verdict(), Verdict::Right);
    assert_eq!(under_way.no_such_opening, 0.0);
    let at_end = Judgement::of(goal, &[look], Some(end_m), &expectation);
    assert_eq!(at_end.verdict(), Verdict::Wrong(FaultKind::NoSuchOpening));
}

#[test]
fn a_second_look_that_sees_the_same_speaks_less_than_one_that_sees_something_else() {
    let goal = goal(3, Side::Left, OpenDoor);
    let (first, end_m) = look(&[Hallway, OpenDoor], &[]);
    let mut more = first.clone();
    more.percepts.push(percept(9, Side::Left, ClosedDoor, 6.0));
    more.percepts.sort_by(|a, b| a.from_m.total_cmp(&b.from_m));
    let expectation = Expectation::of_event(Matrix::SONAR);
    let right = |looks: &[Look]| Judgement::of(goal, looks, Some(end_m), &expectation).right;
    let (once, again) = (right(std::slice::from_ref(&first)), right(&[first.clone(), first.clone()]));
    let found = right(&[first.clone(), more]);
    assert!(again < once, "{again} {once}");
    // Were looks independent, twice nothing would be as if it were the square.
    let odds = |right: f64| right / (1.0 - right);
    let independent = Expectation { same_again: 0.0, ..expectation.clone() };
    let independent = Judgement::of(goal, &[first.clone(), first.clone()], Some(end_m), &independent).right;
    assert!(odds(again) > 2.0 * odds(independent), "{again} {independent}");
    assert!(found > 0.8, "a closed door that the first look missed: {found}");
}

#[test]
fn the_way_back_is_the_way_there_turned() {
    let seen = percept(4, Side::Left, Hallway, 5.0);
    let turned = seen.turned(20.0);
    assert_eq!((turned.side, turned.middle_m()), (Side::Right, 15.0));
    let back = turned.turned(20.0);
    assert!(back.side == seen.side && (back.from_m - seen.from_m).abs() < 1e-9 && (back.to_m - seen.to_m).abs() < 1e-9);
}

/// What is perceived of a hallway's side by two looks, of which the second sees what the first did as often
/// as is said.
fn two_looks(openings: &Openings, side: Side, expectation: &Expectation, stream: &mut Stream) -> [Vec<Percept>; 2] {
    let mut looks = [Vec::new(), Vec::new()];
    let mut last_m = 0.0;
    for &(kind, at_m) in openings {
        for (feature, middle_m) in [(Feature::Wall, (last_m + at_m) / 2.0), (kind, at_m)] {
            let first = expectation.matrix.draw(feature, stream);
            let again =
                if stream.chance(expectation.same_again) { first } else { expectation.matrix.draw(feature, stream) };
            for (look, seen) in looks.iter_mut().zip([first, again]) {
                if seen != Feature::Wall {
                    look.push(percept(look.len() as u64, side, seen, middle_m));
                }
            }
        }
        last_m = at_m;
    }
    looks
}

/// How many of the wrong instructions that can be found are found, of these how many with what is wrong, and how
/// many right ones are called wrong.
fn experiment(expectation: &Expectation, hallways: u64) -> (f64, f64, f64) {
    let (mut faults, mut found, mut named, mut right, mut accused) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for seed in 0..hallways {
        let mut stream = Stream::new(seed, "judgement");
        let sides = [(); 2].map(|()| {
            let count = 3 + stream.index(5);
            openings(count, None, &mut stream)
        });
        let end_m = sides.iter().flatten().map(|(_, at_m)| at_m + 3.0).fold(0.0, f64::max);
        let seen = [0, 1].map(|side| two_looks(&sides[side], Side::ALL[side], expectation, &mut stream));
        let looks = [0, 1].map(|look| Look {
            from_m: 0.0,
            to_m: end_m,
            percepts: [seen[0][look].clone(), seen[1][look].clone()].concat(),
            hidden: Vec::new(),
        });
        let asked = goal(1 + stream.index(8) as u8, Side::ALL[stream.index(2)], [Hallway, OpenDoor][stream.index(2)]);
        let truth = sides[asked.side as usize].get(usize::from(asked.ordinal) - 1).map(|(kind, _)| *kind);
        let fact = match truth {
            None => Some(FaultKind::NoSuchOpening),
            Some(kind) if kind != asked.kind => Some(FaultKind::OtherKind),
            Some(_) => None,
        };
        let first = Judgement::of(asked, &looks[..1], Some(end_m), expectation);
        let judgement = match first.verdict() {
            Verdict::LookAgain => Judgement::of(asked, &looks, Some(end_m), expectation),
            Verdict::Right | Verdict::Wrong(_) => first,
        };
        let said = match judgement.verdict() {
            Verdict::Wrong(kind) => Some(kind),
            Verdict::Right => None,
            Verdict::LookAgain => unreachable!("two looks suffice"),
        };
        match fact {
            None => (right, accused) = (right + 1.0, accused + f64::from(u8::from(said.is_some()))),
            Some(_) => {
                faults += 1.0;
                found += f64::from(u8::from(said.is_some()));
                named += f64::from(u8::from(said == fact));
            }
        }
    }
    (found / faults, named / found, accused / right)
}

#[test]
fn faults_are_found_and_right_instructions_left_alone() {
    let of_markers = experiment(&Expectation::of_event(Matrix::MARKED), 3_000);
    assert!(of_markers.0 >= 0.95 && of_markers.1 >= 0.97 && of_markers.2 <= 0.02, "{of_markers:?}");
    let of_sonar = experiment(&Expectation::of_event(Matrix::SONAR), 3_000);
    assert!(of_sonar.0 >= 0.92 && of_sonar.1 >= 0.93 && of_sonar.2 <= 0.06, "{of_sonar:?}");
}
