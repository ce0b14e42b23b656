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
    (Look { from_m: 0.0, to_m: end_m, turned_at_m: None, percepts, hidden: Vec::new() }, end_m)
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

/// What is seen of three doors on the left, of which the last is a hallway or open: asked for the third hallway, with
/// what hides a part of it.
fn third_left(third: Percept, hidden_m: Option<(f64, f64)>) -> Judgement {
    let (mut look, end_m) = look(&[OpenDoor, OpenDoor], &[]);
    look.percepts.push(third);
    look.hidden.extend(hidden_m.map(|(from_m, to_m)| HiddenWall { side: Side::Left, from_m, to_m }));
    let end_m = end_m + 4.0;
    look.to_m = end_m;
    Judgement::of(goal(3, Side::Left, Hallway), &[look], Some(end_m), &Expectation::of_event(Matrix::SONAR))
}

#[test]
fn an_opening_of_which_something_hides_a_part_may_be_wider() {
    let (_, at_m) = look(&[OpenDoor, OpenDoor], &[]);
    let door = Percept { from_m: at_m, to_m: at_m + 1.0, ..percept(7, Side::Left, OpenDoor, at_m) };
    let clear = third_left(door, None);
    let partly_hidden = third_left(door, Some((at_m - 1.0, at_m + 0.4)));
    assert!(clear.right < 0.3, "{}", clear.right);
    assert!(partly_hidden.right > 2.0 * clear.right && partly_hidden.right < 0.8, "{}", partly_hidden.right);
    assert_eq!(partly_hidden.verdict(), Verdict::LookAgain);
}

#[test]
fn what_is_seen_where_somebody_stands_is_not_counted() {
    let (_, at_m) = look(&[OpenDoor, OpenDoor], &[]);
    let hallway = Percept { from_m: at_m, to_m: at_m + 2.0, ..percept(7, Side::Left, Hallway, at_m) };
    assert!(third_left(hallway, None).right > 0.95);
    let behind_somebody = third_left(hallway, Some((at_m - 0.8, at_m + 2.8)));
    assert!(behind_somebody.right < 0.6, "{}", behind_somebody.right);
}

#[test]
fn who_stands_in_a_hallway_makes_no_two_doors_of_it() {
    let (mut parted, end_m) = look(&[OpenDoor], &[]);
    let at_m = end_m;
    let part = |from_m: f64, to_m: f64| Percept { from_m, to_m, ..percept(7, Side::Left, OpenDoor, from_m) };
    parted.percepts.extend([part(at_m, at_m + 0.9), part(at_m + 1.1, at_m + 2.2)]);
    let end_m = end_m + 4.0;
    parted.to_m = end_m;
    let expectation = Expectation::of_event(Matrix::SONAR);
    let second = Judgement::of(goal(2, Side::Left, Hallway), &[parted], Some(end_m), &expectation);
    assert!(second.right > 0.95, "{}", second.right);
    let middle_m = second.at.expect("it was seen").middle_m();
    assert!((middle_m - at_m - 1.1).abs() < 0.01, "{middle_m}");
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
    let at_end = Judgement::of(goal, std::slice::from_ref(&look), Some(end_m), &expectation);
    assert_eq!(at_end.verdict(), Verdict::LookAgain, "whoever walked beside the robot hid what he passed");
    let seen_twice = Judgement::of(goal, &[look.clone(), look], Some(end_m), &expectation);
    assert_eq!(seen_twice.verdict(), Verdict::Wrong(FaultKind::NoSuchOpening));
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

const MOST_LOOKS: usize = 3;

/// What is perceived of a hallway's side by looks, of which each but the first sees what the first did as often
/// as is said.
fn all_looks(
    openings: &Openings,
    side: Side,
    expectation: &Expectation,
    stream: &mut Stream,
) -> [Vec<Percept>; MOST_LOOKS] {
    let mut looks = [const { Vec::new() }; MOST_LOOKS];
    let mut last_m = 0.0;
    for &(kind, at_m) in openings {
        for (feature, middle_m) in [(Feature::Wall, (last_m + at_m) / 2.0), (kind, at_m)] {
            let first = expectation.matrix.draw(feature, stream);
            for (number, look) in looks.iter_mut().enumerate() {
                let is_first = number == 0 || stream.chance(expectation.same_again);
                let seen = if is_first { first } else { expectation.matrix.draw(feature, stream) };
                if seen != Feature::Wall {
                    // They are nearer to each other here than in a building, where none overlap.
                    let (from_m, to_m) = (middle_m - 0.4, middle_m + 0.4);
                    look.push(Percept { from_m, to_m, ..percept(look.len() as u64, side, seen, middle_m) });
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
        let seen = [0, 1].map(|side| all_looks(&sides[side], Side::ALL[side], expectation, &mut stream));
        let all: [Look; MOST_LOOKS] = std::array::from_fn(|look| Look {
            from_m: 0.0,
            to_m: end_m,
            turned_at_m: None,
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
        let judged = |looks: usize| Judgement::of(asked, &all[..looks], Some(end_m), expectation).verdict();
        let said = (1..=MOST_LOOKS).map(judged).find(|verdict| *verdict != Verdict::LookAgain);
        let said = match said.expect("these looks suffice") {
            Verdict::Wrong(kind) => Some(kind),
            Verdict::Right | Verdict::LookAgain => None,
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
