//! Active sensing (Fox, Burgard, Thrun §4.3): which direction of which sensor to read next.

use crate::localization::{LocalizationModel, ReadingModel, StateShare};
use rayon::prelude::*;

/// The sensors of a model that can be pointed, each with its beams as directions.
#[derive(Debug)]
pub struct SensingModel<'m> {
    model: &'m LocalizationModel,
    /// Of each sensor of the model.
    readings: Vec<ReadingModel>,
    /// Every direction that can be read.
    directions: Vec<Direction>,
}

/// A direction of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Direction {
    /// Index of the sensor in the model.
    pub sensor: usize,
    /// Index of its beam.
    pub beam: usize,
}

/// The chosen direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensingChoice {
    /// Where to look.
    pub direction: Direction,
    /// U(a), Eq. (4), in nats: by how much the entropy of the belief is expected to fall.
    pub utility: f64,
}

impl<'m> SensingModel<'m> {
    /// For these sensors of a model.
    pub fn new(model: &'m LocalizationModel, sensors: &[usize]) -> Self {
        let directions_of =
            |&sensor: &usize| (0..model.sensors[sensor].bearings.beams()).map(move |beam| Direction { sensor, beam });
        Self {
            readings: model.sensors.iter().map(|sensor| ReadingModel::new(&sensor.parameters.beam)).collect(),
            directions: sensors.iter().flat_map(directions_of).collect(),
            model,
        }
    }

    /// Every direction that can be read.
    pub fn directions(&self) -> &[Direction] {
        &self.directions
    }

    /// U(a) of Eq. (4) with E_a\[H\] of Eq. (13), in nats.
    ///
    /// The two equations together say H(L) − E_a[H(L | s)], which is H(s) − E[H(s | L)]; and a
    /// reading depends on the state through the expected distance alone. So the belief need only be
    /// summed up by expected distance: O(states + distances²) in place of O(states · distances),
    /// and exact.
    pub fn utility(&self, direction: Direction, states: &[StateShare]) -> f64 {
        let shares = self.model.expected_shares(direction.sensor, direction.beam, states);
        self.readings[direction.sensor].information(&shares)
    }

    /// The direction of the greatest utility, the first of equals; none if there is none. All
    /// directions cost the same. Some 10 ms for 205 directions and 4,096 states on one core.
    pub fn choose(&self, states: &[StateShare]) -> Option<SensingChoice> {
        let utility = |&direction: &Direction| SensingChoice { direction, utility: self.utility(direction, states) };
        let choices: Vec<SensingChoice> = self.directions.par_iter().map(utility).collect();
        choices.into_iter().reduce(|best, next| if next.utility > best.utility { next } else { best })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::localization::{BeamParameters, Belief, LocalizationParameters, ReadingModel, ScanParameters, State};
    use crate::occupancy::{Cell, OccupancyGrid};
    use crate::sensors::RangeSensor;

    /// A room of 8 x 4 m, the same after half a turn, with or without a box at its upper wall.
    fn room(boxed: bool) -> OccupancyGrid {
        let mut map = OccupancyGrid::filled(Point::origin(), 0.1, 80, 40, Cell::Free);
        for row in 0..40 {
            for column in 0..80 {
                let is_wall = row == 0 || row == 39 || column == 0 || column == 79;
                let is_box = boxed && (32..39).contains(&row) && (12..24).contains(&column);
                if is_wall || is_box {
                    map.set(column, row, Cell::Occupied);
                }
            }
        }
        map
    }

    const SONARS: usize = 0;
    const LASER: usize = 1;

    /// Sonars that see the box, and a laser that does not.
    fn model() -> LocalizationModel {
        let laser = ScanParameters {
            source: RangeSensor::Laser,
            beams_deg: (-90..=90).step_by(10).collect(),
            beam: BeamParameters::laser(),
            ..ScanParameters::default()
        };
        let parameters = LocalizationParameters {
            cell_m: 0.4,
            angle_step_deg: 30,
            activity_threshold: 0.0,
            sensors: vec![ScanParameters::default(), laser],
            ..LocalizationParameters::default()
        };
        let (boxed, bare) = (room(true), room(false));
        LocalizationModel::seeing(&boxed, &[&boxed, &bare], parameters.literal()).expect("the room is a map")
    }

    fn choices(sensing: &SensingModel<'_>, states: &[StateShare]) -> Vec<SensingChoice> {
        let utility = |&direction: &Direction| SensingChoice { direction, utility: sensing.utility(direction, states) };
        sensing.directions().iter().map(utility).collect()
    }

    /// A pose below the box that looks along the room, and its mirror image.
    fn two_mirror_states(model: &LocalizationModel) -> [StateShare; 2] {
        let (row, column) = (4, 4);
        let mirrored = State {
            heading: model.grid.headings / 2,
            row: model.grid.rows - 1 - row,
            column: model.grid.columns - 1 - column,
        };
        [State { heading: 0, row, column }, mirrored].map(|state| StateShare { state, share: 0.5 })
    }

    /// Eq. (13), term by term.
    fn expected_entropy(model: &LocalizationModel, sensor: usize, beam: usize, states: &[StateShare]) -> f64 {
        let readings = ReadingModel::new(&model.parameters.sensors[sensor].beam);
        let likelihood =
            |state: State, measured: usize| readings.likelihood(model.expected_scan(sensor, state)[beam])[measured];
        let mut sum = 0.0;
        for measured in 0..256 {
            let sensed: f64 = states.iter().map(|at| likelihood(at.state, measured) * at.share).sum();
            for at in states.iter().filter(|at| at.share > 0.0) {
                let joint = likelihood(at.state, measured) * at.share;
                sum -= if joint > 0.0 { joint * libm::log(joint / sensed) } else { 0.0 };
            }
        }
        sum
    }

    #[test]
    fn the_utility_is_the_entropy_less_equation_13_term_by_term() {
        let model = model();
        let mut belief = Belief::uniform(&model);
        belief.sense_reading(&model, SONARS, 3, 1.7);
        belief.sense_reading(&model, LASER, 9, 3.1);
        let states = belief.all_states(&model);
        let entropy: f64 = -states.iter().map(|at| at.share * libm::log(at.share)).sum::<f64>();
        let sensing = SensingModel::new(&model, &[SONARS, LASER]);
        for (sensor, beam) in [(SONARS, 0), (SONARS, 17), (LASER, 4)] {
            let utility = sensing.utility(Direction { sensor, beam }, &states);
            let exact = entropy - expected_entropy(&model, sensor, beam, &states);
            assert!((utility - exact).abs() < 1e-6, "{sensor} {beam}: {utility} {exact}");
        }
    }

    #[test]
    fn what_tells_two_mirror_poses_apart_is_read() {
        let model = model();
        let states = two_mirror_states(&model);
        let sensing = SensingModel::new(&model, &[SONARS, LASER]);
        let choice = sensing.choose(&states).expect("there are directions");
        let expected = states.map(|at| model.expected_scan(SONARS, at.state));
        let beam = choice.direction.beam;
        assert!(choice.direction.sensor == SONARS && expected[0][beam] != expected[1][beam], "{choice:?}");
        assert!(choice.utility > 0.3 && choice.utility < std::f64::consts::LN_2, "{choice:?}");
        for other in choices(&sensing, &states) {
            let Direction { sensor, beam } = other.direction;
            let is_blind = sensor == LASER || expected[0][beam] == expected[1][beam];
            assert_eq!(is_blind, other.utility < 1e-9, "{other:?}");
        }
    }

    #[test]
    fn a_laser_that_does_not_see_the_box_leaves_two_mirror_poses_alone() {
        let model = model();
        let mut belief = Belief::uniform(&model);
        let expected = model.expected_scan(LASER, two_mirror_states(&model)[0].state);
        for beam in [9, 0, 18, 12] {
            belief.sense_reading(&model, LASER, beam, model.sensors[LASER].likelihood.range_m(expected[beam]));
        }
        let [here, there] = two_mirror_states(&model).map(|at| belief.probability(&model, at.state));
        assert!(here > model.prior() && here == there, "{here} {there}");
        let seen = two_mirror_states(&model).map(|at| model.expected_scan(SONARS, at.state));
        let beam =
            (0..seen[0].len()).find(|&beam| seen[0][beam].abs_diff(seen[1][beam]) > 20).expect("the box is seen");
        belief.sense_reading(&model, SONARS, beam, model.sensors[SONARS].likelihood.range_m(seen[0][beam]));
        let [here, there] = two_mirror_states(&model).map(|at| belief.probability(&model, at.state));
        assert!(here > 2.0 * there, "{here} {there}");
    }

    #[test]
    fn drawn_states_choose_as_well_as_all_of_them() {
        let model = model();
        let sensing = SensingModel::new(&model, &[SONARS, LASER]);
        let mut belief = Belief::uniform(&model);
        for (beam, range_m) in [(0, 3.0), (6, 1.2), (19, 1.9), (12, 4.1)] {
            let all = choices(&sensing, &belief.all_states(&model));
            let drawn = belief.drawn_states(&model, 300);
            assert!((drawn.iter().map(|at| at.share).sum::<f64>() - 1.0).abs() < 1e-12);
            let choice = sensing.choose(&drawn).expect("there are directions");
            assert_eq!(sensing.choose(&drawn), Some(choice));
            let worth = all.iter().find(|other| other.direction == choice.direction).map_or(0.0, |other| other.utility);
            let best = all.iter().map(|other| other.utility).fold(0.0, f64::max);
            assert!(worth > best - 0.03, "{worth} of {best}");
            belief.sense_reading(&model, SONARS, beam, range_m);
        }
    }
}
