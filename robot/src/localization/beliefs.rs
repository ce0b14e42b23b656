//! The fine belief, the coarse one that watches over it, and which of the two leads.

use super::belief::Belief;
use super::contest::{Claim, Contest, Verdict};
use super::gating::Company;
use super::landmark::LandmarkSighting;
use super::map_fit::MapFit;
use super::model::{FEW_STATES, LocalizationModel, Misfit};
use super::parameters::{OdometryError, Spread, Watch};
use super::review::Review;
use super::scan::Weighing;
use super::scan_match::Fix;
use super::sensor::BinnedScan;
use super::slip::Slip;
use super::summary::{Maximum, NEAR_M, NEAR_RAD};
use super::watcher::{ASSURED, Update, Watcher};
use crate::geometry::{Pose, wrap_angle_rad};
use serde::{Deserialize, Serialize};

/// While the fine belief explains the scans, the coarse one takes in every nth beam, beginning with the next
/// one at each update: beams far apart in turn, whose evidence overlaps less.
const WATCH_BEAM_STRIDE: u64 = 3;

/// θ of a coarse belief that has to find the robot, as a share of the prior probability of a cell: far above what mixing
/// adds to each cell at every update. What sleeps comes to be worth that, and all of it wakes, once scans fit what is awake
/// less than twice as well as the average state. It holds from when the belief leads until it falls asleep as a whole.
///
/// Of one that was woken to watch nothing sleeps: a wrong pose that fits nearly as well as the right one is found out by
/// what each pose has gathered scan by scan, which an average hides.
const LED_ACTIVITY: f64 = 1e-3;

/// With more of the fine belief asleep than this, it knows too little to lead.
const MOST_ASLEEP: f64 = 0.5;

/// Dead reckoning may have led the robot this many standard deviations away from the mode; the mode itself may be off
/// by two of them.
const REACH_SIGMAS: f64 = 4.0;

/// With less agreement than this it is asked whether another place explains the scans ...
const LEAST_AGREED: f64 = 0.98;

/// ... unless the fine belief holds less of the pose than this.
const CONTESTED: f64 = 0.9;

/// The most places of the coarse belief that are looked at, with this much of it at the least.
const MOST_PLACES: usize = 12;
const LEAST_PLACE: f64 = 1e-4;

/// The widest normal distribution that has [`ASSURED`] of its mass within 0.5 m (3.03 standard deviations, by Rayleigh's
/// distribution), and within 15° (2.58).
const JUST_ASSURED: Spread = Spread { position_m: NEAR_M / 3.03, heading_rad: NEAR_RAD / 2.58 };

/// The scan of one sensor as it is heard.
#[derive(Clone, Debug)]
pub(super) struct Heard {
    /// As measured.
    pub whole: BinnedScan,
    /// Without the readings that are left out.
    pub gated: BinnedScan,
    /// Whether people stand around, and what became of their readings.
    pub company: Company,
    /// Exponent of its likelihood, beyond its tempering: what it tells beyond the last one.
    pub power: f64,
}

/// What is believed: on one grid or, where a coarse belief watches, on two.
///
/// # Deviation
/// The papers update all states when the robot is lost. Where a coarse belief watches, it leads then and takes in all
/// beams, until so little may be true that the fine belief can be made of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Beliefs {
    /// Asleep while the coarse one leads.
    fine: Belief,
    /// Awake while it leads; none if none watches.
    watcher: Option<Watcher>,
    is_led_by_coarse: bool,
    /// The mode of the one that leads.
    pub mode: Maximum,
    /// What the coarse one gives the mode of the fine one: as much as it ever does if it sleeps, 1 if it leads or none
    /// watches.
    pub agreed: f64,
    /// How well dead reckoning alone knows the pose, since the belief was last assured of it; none since it was given up.
    reckoned: Option<Fix>,
    /// The scans since then.
    contest: Contest,
    /// What they tell of the odometry.
    slip: Slip,
    /// And of the map.
    map_fit: MapFit,
    /// Probability of the poses that dead reckoning may have led to: at least that of the mode.
    pub held: f64,
    /// How far the readings that are not short bear the mode out among people, in nats, tempered; 0 where nobody stands
    /// around.
    support_nats: f64,
    /// Whether the position was given up, and both beliefs have not agreed for long since.
    is_unsettled: bool,
    /// When all places are to be compared next.
    review: Review,
}

impl Beliefs {
    /// Every state alike.
    pub(super) fn uniform(model: &LocalizationModel) -> Self {
        let watcher = model.watch.as_ref().map(|coarse| Watcher::awake(Belief::uniform(coarse)));
        Self { is_unsettled: watcher.is_some(), ..Self::of(model, Belief::uniform(model), watcher) }
    }

    /// Around a known pose. The coarse belief sleeps if it is known well.
    pub(super) fn around(model: &LocalizationModel, pose_in_map: Pose, spread: Spread) -> Self {
        let fine = Belief::around(model, pose_in_map, spread);
        let is_known = fine.mode(model).mass >= ASSURED;
        let watcher = model.watch.as_ref().map(|coarse| match is_known {
            true => Watcher::asleep(),
            false => Watcher::awake(Belief::around(coarse, pose_in_map, spread)),
        });
        Self::of(model, fine, watcher)
    }

    fn of(model: &LocalizationModel, fine: Belief, watcher: Option<Watcher>) -> Self {
        let mode = fine.mode(model);
        let mut beliefs = Self {
            fine,
            watcher,
            is_led_by_coarse: false,
            mode,
            agreed: 1.0,
            reckoned: None,
            contest: Contest::default(),
            slip: Slip::default(),
            map_fit: MapFit::default(),
            held: mode.mass,
            support_nats: 0.0,
            is_unsettled: false,
            review: Review::default(),
        };
        beliefs.settle(model);
        beliefs
    }

    /// Half of these and half of others, to half a cell.
    pub(super) fn merged(&self, model: &LocalizationModel, other: &Self) -> Self {
        let watcher = model.watch.as_ref().and_then(|coarse| {
            let belief = self.woken(coarse)?.merged(coarse, &other.woken(coarse)?);
            Some(Watcher::awake(belief))
        });
        Self::of(model, self.fine.merged(model, &other.fine), watcher)
    }

    /// The coarse belief, told of all that it has missed.
    fn woken(&self, coarse: &LocalizationModel) -> Option<Belief> {
        let mut watcher = self.watcher.clone()?;
        watcher.wake(coarse, self.mode.pose_in_map);
        watcher.belief().cloned()
    }

    /// The belief that leads, and the model of its grid.
    pub(super) fn leading<'a>(&'a self, model: &'a LocalizationModel) -> (&'a Belief, &'a LocalizationModel) {
        match (self.watcher.as_ref().and_then(Watcher::belief), &model.watch) {
            (Some(coarse), Some(coarse_model)) if self.is_led_by_coarse => (coarse, coarse_model),
            _ => (&self.fine, model),
        }
    }

    /// Bytes of tiles that earlier ones do not share.
    pub(super) fn bytes_apart(&self, earlier: &Self) -> usize {
        let watcher = match (&self.watcher, &earlier.watcher) {
            (Some(watcher), Some(earlier)) => watcher.bytes_apart(earlier),
            (Some(_) | None, _) => 0,
        };
        self.fine.bytes_apart(&earlier.fine) + watcher
    }

    /// Probability of each cell of (x, y) of the fine grid, `[row][column]`.
    pub(super) fn xy(&self, model: &LocalizationModel) -> Vec<f64> {
        let (belief, leading) = self.leading(model);
        let (xy, grid) = (belief.xy(leading), &model.grid);
        if !self.is_led_by_coarse {
            return xy;
        }
        // A coarse cell is spread over the fine ones in it.
        let at = |cell: usize| {
            let (column, row) = (cell % grid.columns, cell / grid.columns);
            let here = leading.grid.cell_at(grid.centre(column, row)).filter(|_| model.is_admissible(column, row));
            here.map_or(0.0, |(column, row)| xy[row * leading.grid.columns + column])
        };
        let spread: Vec<f64> = (0..grid.cells()).map(at).collect();
        let total: f64 = spread.iter().sum();
        spread.into_iter().map(|mass| mass / total.max(f64::MIN_POSITIVE)).collect()
    }

    /// Entropy in nats, of states of the fine grid: a coarse one stands for several that are alike.
    pub(super) fn entropy(&self, model: &LocalizationModel) -> f64 {
        let (belief, leading) = self.leading(model);
        belief.entropy(leading) + libm::log(leading.prior() / model.prior())
    }

    /// Eq. (1) for a motion; [`Beliefs::sense`] must follow.
    pub(super) fn advance(&mut self, model: &LocalizationModel, motion: Pose) {
        let error = self.odometry_error(model);
        if !self.is_led_by_coarse {
            self.fine.advance(model, motion, &error);
        }
        if let (Some(coarse), Some(coarse_model)) = (self.watcher.as_mut().and_then(Watcher::belief_mut), &model.watch)
        {
            coarse.advance(coarse_model, motion, &error);
        }
        self.reckoned = self.reckoned.map(|fix| fix.advanced(motion, &error));
        self.slip.advance(motion, &model.parameters.odometry);
    }

    /// How far odometry strays, as the scans tell.
    pub(super) fn odometry_error(&self, model: &LocalizationModel) -> OdometryError {
        self.slip.error(&model.parameters.odometry)
    }

    /// How well what is seen fits the map.
    pub(super) fn map_fit(&self) -> &MapFit {
        &self.map_fit
    }

    /// Whether the position was given up, and was not found again for long enough to be sure of it.
    pub(super) fn is_unsettled(&self) -> bool {
        self.is_unsettled
    }

    /// How many times as far as its description says it strays.
    pub(super) fn slip(&self) -> f64 {
        self.slip.factor()
    }

    /// Eq. (2) for a scan of each sensor after a motion; `updates` is how many have been before. `support_nats` is how
    /// far the readings that are not short have borne the mode out, and `is_explained` whether the scans fit as usual
    /// where the motion has led.
    ///
    /// Where people stand around, the coarse belief hears the whole scan, with a beam to which people are likely: who left
    /// out there what the fine one takes for people could not object to a wrong pose. So does the fine one where nothing is
    /// left out.
    pub(super) fn sense(
        &mut self,
        model: &LocalizationModel,
        motion: Pose,
        heard: Vec<Heard>,
        support_nats: f64,
        is_explained: bool,
        updates: u64,
    ) {
        let powers: Vec<f64> = heard.iter().map(|scan| scan.power).collect();
        let is_crowd: Vec<bool> = heard.iter().map(|scan| scan.company.is_crowd()).collect();
        let are_people_around = is_crowd.contains(&true);
        self.support_nats = if are_people_around { support_nats } else { 0.0 };
        let counted = |heard: &Heard| Weighing { power: heard.power, is_crowd: heard.company == Company::Counted };
        let counted: Vec<Weighing> = heard.iter().map(counted).collect();
        let watched = |heard: &Heard| if heard.company.is_crowd() { heard.whole.clone() } else { heard.gated.clone() };
        let watched: Vec<BinnedScan> = heard.iter().map(watched).collect();
        let (whole, gated): (Vec<BinnedScan>, Vec<BinnedScan>) =
            heard.into_iter().map(|heard| (heard.whole, heard.gated)).unzip();
        let from_in_map = self.mode.pose_in_map;
        let predicted_in_map = from_in_map.compose(motion);
        let told = if self.is_led_by_coarse { 1.0 } else { model.told(predicted_in_map, &whole) };
        let error = self.odometry_error(model);
        if !self.is_led_by_coarse {
            let mixed = told * model.parameters.mixing;
            self.fine.sense_after_motion(model, motion, &gated, mixed, &counted, is_explained);
            self.mode = self.fine.mode(model);
            self.contest.hear(motion, self.mode.pose_in_map, &whole);
        }
        if let (Some(watcher), Some(coarse_model)) = (&mut self.watcher, &model.watch) {
            // Among people the fine belief hears little, and what sleeps comes to be worth θ by mixing alone.
            let hears_all = self.is_led_by_coarse || self.fine.is_adrift(model) && !are_people_around;
            let scans = if hears_all { watched } else { in_turn(&watched, updates) };
            // What the fine belief would count a scan for.
            let tempering = |of: &LocalizationModel, sensor: usize| of.sensors[sensor].parameters.tempering;
            let of_fine =
                |sensor| if hears_all { tempering(model, sensor) / tempering(coarse_model, sensor) } else { 1.0 };
            let power = |sensor: usize| powers[sensor] * of_fine(sensor);
            let weighing = |(sensor, is_crowd)| Weighing { power: power(sensor), is_crowd };
            let weighings = is_crowd.into_iter().enumerate().map(weighing).collect();
            let mode_in_map = self.mode.pose_in_map;
            // What is left out counts here as well: it may tell of a wrong pose.
            let misfit = if hears_all { Some(Misfit::default()) } else { model.misfit(mode_in_map, &whole) };
            let mixed = told * coarse_model.parameters.mixing;
            let update = Update { from_in_map, motion, error, scans, weighings, mixed, sightings: Vec::new() };
            watcher.hear(coarse_model, update, misfit);
        }
        self.review(model);
        self.decide(model);
        if !self.is_led_by_coarse && !are_people_around && self.held.min(self.agreed) >= ASSURED {
            self.map_fit.hear(model, self.mode.pose_in_map, &gated);
        }
    }

    /// Takes in whether the robot gets no nearer where the map shows a way.
    pub(super) fn note_held_up(&mut self, is_held_up: bool) {
        self.review.note_held_up(is_held_up);
    }

    /// Compares the tracked pose with all places when that is due, if scans of late are explained badly there. If one of
    /// them wins, the belief of them all objects.
    fn review(&mut self, model: &LocalizationModel) {
        let (Some(watcher), Some(coarse_model), Some(watch)) =
            (&mut self.watcher, &model.watch, &model.parameters.watch)
        else {
            return;
        };
        if self.is_led_by_coarse || !self.review.pass_update() {
            return;
        }
        if !self.contest.may_be_won(model) {
            return self.review.begin_anew();
        }
        let error = self.slip.error(&model.parameters.odometry);
        let anywhere = self.contest.heard_anywhere(coarse_model, &error, led_threshold(model, coarse_model));
        let places = elsewhere(&anywhere, coarse_model, self.mode.pose_in_map, watch);
        match self.contest.verdict(model, &places, self.review.claim(Claim::Review)) {
            Verdict::Won => watcher.take_over(anywhere),
            Verdict::Pending | Verdict::Dismissed => self.review.put_off(),
        }
    }

    /// Takes in a landmark that was seen at the last update; [`Beliefs::settle`] must follow.
    pub(super) fn see(&mut self, model: &LocalizationModel, sighting: &LandmarkSighting) {
        if !self.is_led_by_coarse {
            self.fine.see(model, sighting);
            self.contest.see(sighting);
        }
        if let (Some(watcher), Some(coarse_model)) = (&mut self.watcher, &model.watch) {
            watcher.see(coarse_model, sighting, self.mode.pose_in_map);
        }
    }

    /// Mixes a share of the uniform distribution into both.
    pub(super) fn mix(&mut self, model: &LocalizationModel, share: f64) {
        (self.support_nats, self.reckoned, self.is_unsettled) = (0.0, None, model.watch.is_some());
        self.contest.forget();
        self.slip.begin_anew();
        if let (Some(watcher), Some(coarse_model)) = (&mut self.watcher, &model.watch) {
            watcher.wake(coarse_model, self.mode.pose_in_map);
            watcher.disagree();
            watcher.belief_mut().into_iter().for_each(|coarse| coarse.mix(coarse_model, share));
        }
        self.fine.mix(model, share);
        self.settle(model);
    }

    /// Finds the mode, and who leads.
    pub(super) fn settle(&mut self, model: &LocalizationModel) {
        if !self.is_led_by_coarse {
            self.mode = self.fine.mode(model);
        }
        self.decide(model);
    }

    /// How far from the mode dead reckoning may have led, in metres and in the heading.
    fn reach(&self) -> [f64; 2] {
        let spread = self.reckoned.map(|fix| fix.spread());
        spread.map_or([NEAR_M, NEAR_RAD], |Spread { position_m, heading_rad }| {
            [NEAR_M.max(REACH_SIGMAS * position_m), NEAR_RAD.max(REACH_SIGMAS * heading_rad)]
        })
    }

    /// Finds who leads: the fine belief, unless much of it sleeps or the coarse one disagrees. As soon as little enough
    /// may be true, the fine belief is made of the coarse one.
    ///
    /// Among people, what the coarse one gives the mode is first brought in line with its support (Bayes' rule: odds times
    /// a ratio of likelihoods). People who walk along are heard again and again, and where some other pose has walls
    /// there, it gains by each scan; the readings that go past them are those that can tell. If it objects nevertheless,
    /// and no other place wins the [`Contest`], it is laid around the mode anew.
    fn decide(&mut self, model: &LocalizationModel) {
        if self.mode.mass >= ASSURED {
            self.reckoned = Some(Fix::around(self.mode.pose_in_map, JUST_ASSURED));
        }
        let [reach_m, reach_rad] = self.reach();
        self.held = match self.is_led_by_coarse || self.mode.mass >= ASSURED || self.reckoned.is_none() {
            true => self.mode.mass,
            false => {
                // Furniture that was moved by a metre makes two modes of one place: neither speaks against the other.
                let [near_m, near_rad] =
                    model.parameters.watch.as_ref().map_or([0.0; 2], |watch| [watch.near_m, watch.near_rad]);
                let (reach_m, reach_rad) = (reach_m.max(near_m), reach_rad.max(near_rad));
                self.fine.awake_within(model, self.mode.pose_in_map, reach_m, reach_rad).max(self.mode.mass)
            }
        };
        let (Some(watcher), Some(coarse_model), Some(watch)) =
            (&mut self.watcher, &model.watch, &model.parameters.watch)
        else {
            return;
        };
        let is_assured = self.held >= ASSURED;
        if !is_assured || self.fine.is_adrift(model) {
            watcher.wake(coarse_model, self.mode.pose_in_map);
        }
        let Some(coarse) = watcher.belief() else {
            (self.agreed, self.is_unsettled) = (1.0 - watch.mixing, false);
            if self.mode.mass >= ASSURED {
                self.slip.learn(self.mode.pose_in_map);
            }
            return;
        };
        let support_nats = self.support_nats;
        let agreement = |mode: &Maximum| {
            let near = [watch.near_m + reach_m - NEAR_M, watch.near_rad + reach_rad - NEAR_RAD];
            let mass = coarse.mass_within(coarse_model, mode.pose_in_map, near[0], near[1]);
            let ratio = libm::exp(support_nats);
            ratio * mass / (1.0 + (ratio - 1.0) * mass)
        };
        if !self.is_led_by_coarse {
            self.agreed = agreement(&self.mode);
            if self.contest.can_be_held() && self.agreed < LEAST_AGREED && self.held >= CONTESTED {
                let places = elsewhere(coarse, coarse_model, self.mode.pose_in_map, watch);
                let verdict = match places.is_empty() {
                    true => Verdict::Won,
                    false => self.contest.verdict(model, &places, self.review.claim(Claim::Objection)),
                };
                if verdict != Verdict::Won {
                    self.agreed = 1.0 - watch.mixing;
                    if verdict == Verdict::Dismissed {
                        watcher.begin_anew(coarse_model, self.mode.pose_in_map);
                    }
                    return;
                }
            }
            let agrees = self.agreed >= watch.agreement * self.held;
            if agrees && self.fine.mass_asleep(model) <= MOST_ASLEEP {
                self.fine.wake_near(model, self.mode.pose_in_map, watch.near_m, watch.near_rad);
                let is_sure = is_assured && self.agreed >= ASSURED;
                if is_sure && self.mode.mass >= ASSURED {
                    self.slip.learn(self.mode.pose_in_map);
                }
                watcher.agree(is_sure);
                return;
            }
        }
        (self.reckoned, self.is_unsettled) = (None, true);
        self.review.begin_anew();
        self.contest.forget();
        self.slip.begin_anew();
        self.is_led_by_coarse = model.sleeps() && likely_states(model, coarse, coarse_model) > FEW_STATES;
        if self.is_led_by_coarse {
            self.fine = Belief::uniform(model);
            (self.mode, self.agreed) = (coarse.mode(coarse_model), 1.0);
            let threshold = led_threshold(model, coarse_model);
            watcher.belief_mut().into_iter().for_each(|coarse| coarse.sleep_below(threshold));
        } else {
            self.fine = Belief::resampled(model, coarse, coarse_model);
            self.mode = self.fine.mode(model);
            self.agreed = agreement(&self.mode);
        }
        self.held = self.mode.mass;
        watcher.disagree();
    }
}

/// θ of a coarse belief that has to find the robot.
fn led_threshold(model: &LocalizationModel, coarse_model: &LocalizationModel) -> f64 {
    f64::min(LED_ACTIVITY, model.parameters.activity_threshold) * coarse_model.prior()
}

/// The places that a coarse belief names besides a pose.
fn elsewhere(coarse: &Belief, coarse_model: &LocalizationModel, pose_in_map: Pose, watch: &Watch) -> Vec<Maximum> {
    let is_elsewhere = |place: &Maximum| {
        let turned_rad = wrap_angle_rad(place.pose_in_map.heading_rad - pose_in_map.heading_rad);
        place.pose_in_map.distance_m(pose_in_map) > watch.near_m || libm::fabs(turned_rad) > watch.near_rad
    };
    let mut places = coarse.maxima(coarse_model, MOST_PLACES, LEAST_PLACE);
    places.retain(is_elsewhere);
    places
}

/// How many states of the fine grid are above θ, by the coarse belief.
fn likely_states(model: &LocalizationModel, coarse: &Belief, coarse_model: &LocalizationModel) -> f64 {
    let ratio = coarse_model.prior() / model.prior();
    coarse.states_above(model.threshold() * ratio) as f64 * ratio
}

/// Every nth beam of a scan.
fn in_turn(scans: &[BinnedScan], updates: u64) -> Vec<BinnedScan> {
    let turn = (updates % WATCH_BEAM_STRIDE) as usize;
    let beam = |(beam, &bin): (usize, &Option<u8>)| bin.filter(|_| beam % WATCH_BEAM_STRIDE as usize == turn);
    scans.iter().map(|scan| scan.iter().enumerate().map(beam).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::localization::{LocalizationParameters, ScanParameters};
    use crate::occupancy::{Cell, OccupancyGrid};

    #[test]
    fn the_coarse_belief_does_not_take_over_where_readings_that_go_past_people_bear_the_pose_out() {
        let mut map = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.1, 60, 40, Cell::Free);
        (0..40).for_each(|row| map.set(59, row, Cell::Occupied));
        let sensors = vec![ScanParameters::default()];
        let model = LocalizationParameters { cell_m: 0.2, angle_step_deg: 5, sensors, ..Default::default() };
        let model = LocalizationModel::new(&map, model).expect("it is a map");
        let coarse_model = model.watch.as_ref().expect("a coarse belief watches");
        let pose_in_map = Pose::new(2.0, 2.0, 0.0);
        let fine = Belief::around(&model, pose_in_map, Spread::default());
        let mut coarse = Belief::around(coarse_model, pose_in_map, Spread::default());
        // It gives the pose about 0.3, less than half of what the fine one does.
        coarse.mix(coarse_model, 0.7);
        let agreed = |support_nats: f64| {
            let (mode, watcher) = (fine.mode(&model), Some(Watcher::awake(coarse.clone())));
            let mut beliefs = Beliefs { watcher, mode, support_nats, ..Beliefs::of(&model, fine.clone(), None) };
            beliefs.settle(&model);
            (beliefs.mode.mass > 0.9).then_some(beliefs.agreed)
        };
        assert_eq!(agreed(0.0), None);
        // Bayes' rule: odds of 3 to 7 become 11 times as much.
        let agreed = agreed(2.4).expect("the fine belief leads on");
        assert!((0.8..0.9).contains(&agreed), "{agreed}");
    }

    /// As where furniture was moved by a metre.
    #[test]
    fn two_modes_a_metre_apart_are_one_place_and_three_metres_apart_are_two() {
        let map = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.1, 90, 60, Cell::Free);
        let sensors = vec![ScanParameters::default()];
        let parameters = LocalizationParameters { angle_step_deg: 5, sensors, ..Default::default() };
        let model = LocalizationModel::new(&map, parameters).expect("it is a map");
        let at = |x_m: f64| Pose::new(x_m, 3.0, 0.0);
        let known = Spread { position_m: 0.1, heading_rad: 0.05 };
        let held = |apart_m: f64| {
            let mut beliefs = Beliefs::around(&model, at(2.0), known);
            let other = Belief::around(&model, at(2.0 + apart_m), known);
            beliefs.fine = beliefs.fine.merged(&model, &other);
            beliefs.settle(&model);
            assert!(beliefs.mode.mass < 0.6, "{}", beliefs.mode.mass);
            beliefs.held
        };
        assert!(held(1.0) > 0.95, "{}", held(1.0));
        assert!(held(3.0) < 0.6, "{}", held(3.0));
    }
}
