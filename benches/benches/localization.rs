//! Localization at the papers' size: 30 × 30 m at 15 cm and 2°, 7,200,000 states, 24 beams.
//!
//! Each row checks the result of what it times. `two` is the layout of the papers, compiled here: all
//! headings of a cell side by side, two look-ups and a multiplication a state and beam.

use rpl_benches::{Question, Report, least_ms};
use rpl_random::Stream;
use rpl_robot::geometry::{Point, Pose};
use rpl_robot::localization::once::ScanLocator;
use rpl_robot::localization::once::trial::{TrialGround, TrialScan, TrialSensor, Verdict};
use rpl_robot::localization::{
    Belief, Instructions, Localization, LocalizationModel, LocalizationParameters, ScanModel, ScanParameters, Spread,
    State,
};
use rpl_robot::occupancy::{Cell, OccupancyGrid};
use rpl_robot::sensors::LaserScanner;
use rpl_robot::world::World;
use std::hint::black_box;

const RUNS: usize = 25;
const STATES: usize = 7_200_000;
const BEAMS: f64 = 24.0;

type Ranges = Vec<f32>;

/// `times` departments along x and y, side by side.
fn departments(times: usize) -> OccupancyGrid {
    let one = department();
    let (columns, rows) = (one.columns * times, one.rows * times);
    let mut map = OccupancyGrid::filled(Point::new(0.0, 0.0), one.resolution_m, columns, rows, Cell::Free);
    for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
        map.set(column, row, one.get(column % one.columns, row % one.rows));
    }
    map
}

/// A department of 30 × 30 m: a corridor through the middle, rooms with doors on both sides, and
/// furniture everywhere.
fn department() -> OccupancyGrid {
    const CELLS: usize = 600;
    let mut map = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.05, CELLS, CELLS, Cell::Free);
    let mut stream = Stream::new(1, "department");
    for along in 0..CELLS {
        let door = along % 100 > 40 && along % 100 < 62;
        for at in [0, CELLS - 1] {
            map.set(along, at, Cell::Occupied);
            map.set(at, along, Cell::Occupied);
        }
        for wall in [270, 320] {
            if !door {
                map.set(along, wall, Cell::Occupied);
            }
        }
        if !(270..320).contains(&along) {
            (100..CELLS).step_by(100).for_each(|wall| map.set(wall, along, Cell::Occupied));
        }
    }
    for _ in 0..120 {
        let (column, row) = (stream.index(CELLS - 12), stream.index(CELLS - 12));
        if row + 12 < 270 || row > 320 {
            (0..144).for_each(|cell| map.set(column + cell % 12, row + cell / 12, Cell::Occupied));
        }
    }
    map
}

fn model(activity_threshold: f64) -> LocalizationModel {
    let parameters = LocalizationParameters { activity_threshold, ..LocalizationParameters::default() };
    match LocalizationModel::new(&department(), parameters) {
        Ok(model) => {
            assert_eq!(model.grid.states(), STATES);
            model
        }
        Err(error) => panic!("{error}"),
    }
}

/// What the robot measures at a pose, with 3 cm of noise.
fn scan_at(model: &LocalizationModel, pose: Pose, noise: &mut Stream) -> Ranges {
    let Some(state) = model.state_at(pose) else { panic!("{pose:?} is not on the map") };
    let noisy = |bin| (model.sensors[0].likelihood.range_m(bin) + 0.03 * noise.normal()) as f32;
    model.expected_scan(0, state).into_iter().map(noisy).collect()
}

/// A drive up the corridor: the motion of each step and the scan after it.
fn drive(model: &LocalizationModel, steps: usize) -> (Pose, Vec<(Pose, Ranges)>) {
    let start = Pose::new(3.0, 14.7, 0.05);
    let (mut pose, mut noise) = (start, Stream::new(2, "noise"));
    let steps = (0..steps).map(|step| {
        let turn_rad = if step % 20 < 10 { -0.01 } else { 0.01 };
        let motion = Pose::new(0.3, 0.0, turn_rad);
        pose = pose.compose(motion);
        (motion, scan_at(model, pose, &mut noise))
    });
    let steps = steps.collect();
    (start, steps)
}

fn states() -> impl Iterator<Item = State> {
    (0..180)
        .flat_map(|heading| (0..200).flat_map(move |row| (0..200).map(move |column| State { heading, row, column })))
}

fn total_variation(model: &LocalizationModel, a: &Belief, b: &Belief) -> f64 {
    states().map(|state| (a.probability(model, state) - b.probability(model, state)).abs()).sum::<f64>() / 2.0
}

fn assert_sums_to_one(model: &LocalizationModel, belief: &Belief) {
    assert!((belief.mass(model) - 1.0).abs() < 1e-5, "{}", belief.mass(model));
    let sum: f64 = states().map(|state| belief.probability(model, state)).sum();
    assert!((sum - 1.0).abs() < 1e-5, "{sum}");
}

/// Runs on `threads` threads.
fn on<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(error) => panic!("{error}"),
    }
}

fn main() {
    let report = Report::from_arguments();
    let mut full = model(0.0);
    let admissible = full.admissible_cells() as f64 / full.grid.cells() as f64;
    println!(
        "{STATES} states, {:.0} % of them admissible; 24 beams; one thread but where it says two",
        admissible * 100.0
    );
    let mut two_ms = f64::NAN;
    report.row(Question::new("two", "full sensor update with the papers' two look-ups", "ms", 205.0, "–"), || {
        two_ms = TwoLookUps::new(&full).least_ms(&full);
        two_ms
    });
    for (instructions, names) in Instructions::available().into_iter().zip(NAMES) {
        println!("{}:", instructions.name());
        full = full.with_instructions(instructions);
        full_updates(&report, &full, names, two_ms);
    }
    selective(&report, &full);
    tracked(&report);
    one_scan(&report);
}

/// Names and targets of the rows for one set of instructions.
struct Names {
    sense: (&'static str, f64),
    beam: (&'static str, f64),
    share: (&'static str, f64),
    motion: (&'static str, f64),
    cycle: (&'static str, f64),
    threads: (&'static str, f64),
}

const NAMES: [Names; 3] = [
    Names {
        sense: ("sense", 55.0),
        beam: ("beam", 0.32),
        share: ("share", 100.0 / 3.5),
        motion: ("motion", 12.0),
        cycle: ("cycle", 75.0),
        threads: ("threads", 100.0 / 1.7),
    },
    Names {
        sense: ("sense-256", 55.0),
        beam: ("beam-256", 0.32),
        share: ("share-256", 100.0 / 3.5),
        motion: ("motion-256", 12.0),
        cycle: ("cycle-256", 75.0),
        threads: ("threads-256", 100.0 / 1.7),
    },
    Names {
        sense: ("sense-512", 15.0),
        beam: ("beam-512", 0.09),
        share: ("share-512", 100.0 / 3.5),
        motion: ("motion-512", 12.0),
        cycle: ("cycle-512", 35.0),
        threads: ("threads-512", 100.0 / 1.7),
    },
];

fn full_updates(report: &Report, model: &LocalizationModel, names: Names, two_ms: f64) {
    let mut belief = Belief::uniform(model);
    let (_, steps) = drive(model, 40);
    let mut sense_ms = f64::NAN;
    let (name, target) = names.sense;
    let peers = "the papers' two look-ups compiled here 205; no peer has a grid filter";
    report.row(Question::new(name, "full sensor update, 24 beams, normalized", "ms", target, peers), || {
        sense_ms = sense(model, &mut belief, &steps, 1, true);
        sense_ms
    });
    let (name, target) = names.beam;
    let peers = "Beluga 6.4, MRPT 28, AMCL 43 a particle and beam";
    report.row(Question::new(name, "the same, a state and beam", "ns", target, peers), || {
        sense_ms * 1e6 / (STATES as f64 * BEAMS)
    });
    let (name, target) = names.share;
    report.row(Question::new(name, "the same, of the papers' two look-ups", "%", target, "row `two`"), || {
        sense_ms / two_ms * 100.0
    });
    let (name, target) = names.threads;
    report.row(Question::new(name, "the same on two threads, of one", "%", target, "50"), || {
        let both = [1, 2].map(|threads| sense(model, &mut belief, &steps, threads, false));
        both[1] / both[0] * 100.0
    });
    let (name, target) = names.motion;
    report.row(
        Question::new(name, "full motion update that moves and blurs x, y and heading", "ms", target, "–"),
        || on(1, || motion(model, &mut belief)),
    );
    let (name, target) = names.cycle;
    let what = "motion, 24 beams, normalized, entropy and mode";
    report.row(Question::new(name, what, "ms", target, "–"), || on(1, || cycle(model, &mut belief, &steps)));
}

fn sense(model: &LocalizationModel, belief: &mut Belief, steps: &[(Pose, Ranges)], threads: usize, alone: bool) -> f64 {
    let mut scans = steps.iter().cycle();
    let mut next = || scans.next().map_or(&[][..], |(_, scan)| scan.as_slice());
    let ms = on(threads, || least_ms(RUNS, alone, || (), || belief.sense_ranges(model, &[Some(next())])));
    assert_eq!(belief.active_planes(), model.grid.headings);
    assert_sums_to_one(model, belief);
    ms
}

fn motion(model: &LocalizationModel, belief: &mut Belief) -> f64 {
    *belief = Belief::uniform(model);
    let step = Pose::new(0.3, 0.0, 0.035);
    let moved = std::cell::RefCell::new(belief);
    let normalize = || moved.borrow_mut().sense_ranges(model, &[None]);
    let ms = least_ms(RUNS, true, normalize, || moved.borrow_mut().advance(model, step, &model.parameters.odometry));
    let belief = moved.into_inner();
    // Only what has gone into walls is lost.
    let mass: f64 = states().map(|state| belief.probability(model, state)).sum();
    assert!((0.8..=1.0).contains(&mass), "{mass}");
    belief.sense_ranges(model, &[None]);
    assert_sums_to_one(model, belief);
    ms
}

fn cycle(model: &LocalizationModel, belief: &mut Belief, steps: &[(Pose, Ranges)]) -> f64 {
    *belief = Belief::uniform(model);
    let before = belief.entropy(model);
    let mut steps = steps.iter().cycle();
    let ms = least_ms(
        RUNS,
        true,
        || (),
        || {
            let Some((motion, scan)) = steps.next() else { return };
            belief.advance(model, *motion, &model.parameters.odometry);
            belief.sense_ranges(model, &[Some(scan)]);
            black_box((belief.entropy(model), belief.mode(model)));
        },
    );
    assert_sums_to_one(model, belief);
    let exact: f64 =
        states().map(|state| belief.probability(model, state)).filter(|&p| p > 0.0).map(|p| -p * p.ln()).sum();
    assert!((belief.entropy(model) - exact).abs() < 1e-4 && exact < before, "{} {exact}", belief.entropy(model));
    ms
}

/// Tracking the robot up the corridor with sleeping planes, each step beside the full update of the
/// same belief.
fn selective(report: &Report, full: &LocalizationModel) {
    let selective = model(LocalizationParameters::default().activity_threshold);
    let (start, steps) = drive(&selective, 60);
    let tracked = || Belief::around(&selective, start, Spread::default());
    let what = "localized: motion, 24 beams, normalized and mode, selectively";
    let peers = "less than 100 on a 200 MHz PentiumPro in the paper";
    report.row(Question::new("localized", what, "ms", 1.0, peers), || {
        let mut belief = tracked();
        let mut remaining = steps.iter();
        let mut worst_error_m = 0f64;
        let mut pose = start;
        let ms = on(1, || {
            least_ms(
                steps.len(),
                true,
                || (),
                || {
                    let Some((motion, scan)) = remaining.next() else { return };
                    belief.advance(&selective, *motion, &selective.parameters.odometry);
                    belief.sense_ranges(&selective, &[Some(scan)]);
                    pose = pose.compose(*motion);
                    worst_error_m = worst_error_m.max(belief.mode(&selective).pose_in_map.distance_m(pose));
                },
            )
        });
        assert!(worst_error_m < 0.15 && belief.active_planes() < 40, "{worst_error_m} {}", belief.active_planes());
        assert_sums_to_one(&selective, &belief);
        ms
    });
    let mut apart = (0f64, 0f64);
    let what = "the same: total variation to the full update of a step, the largest of 20 steps";
    report.row(Question::new("variation", what, "", 1e-3, "not said in the paper"), || {
        let (mut belief, mut always) = (tracked(), tracked());
        always.sleep_below(0.0);
        for (motion, scan) in steps.iter().take(20) {
            let mut other = belief.clone();
            other.sleep_below(0.0);
            other.mix(full, 0.0);
            for (model, belief) in [(&selective, &mut belief), (full, &mut other), (full, &mut always)] {
                belief.advance(model, *motion, &model.parameters.odometry);
                belief.sense_ranges(model, &[Some(scan)]);
            }
            assert_eq!(other.active_planes(), full.grid.headings);
            apart.0 = apart.0.max(total_variation(full, &belief, &other));
            apart.1 = total_variation(full, &belief, &always);
        }
        apart.0
    });
    let what = "the same, after all 20 steps beside a filter that never sleeps";
    report.row(Question::new("drift", what, "", 1e-3, "not said in the paper"), || apart.1);
}

/// The whole filter of a robot that knows where it is, while the coarse belief sleeps and while it is awake.
fn tracked(report: &Report) {
    let known = Spread::default();
    let doubted = Spread { position_m: 0.5, heading_rad: 0.1 };
    let rows = [
        ("tracked-30", "localized, the whole filter: 30 × 30 m", 0.2, 1, known),
        ("tracked-90", "the same: 90 × 90 m", 0.2, 3, known),
        ("tracked-180", "the same: 180 × 180 m", 0.2, 6, known),
        ("watched-30", "the same while the coarse belief is awake: 30 × 30 m", 0.8, 1, doubted),
    ];
    for (name, what, target, times, spread) in rows {
        report.row(Question::new(name, what, "ms", target, "–"), || {
            let model = match LocalizationModel::new(&departments(times), LocalizationParameters::default()) {
                Ok(model) => model,
                Err(error) => panic!("{error}"),
            };
            let (start, steps) = drive(&model, 30);
            let begun = Localization::start_at(&model, start, spread);
            let (ms, tracked) = on(1, || {
                let tracked = std::cell::RefCell::new(begun.clone());
                let begin = || *tracked.borrow_mut() = begun.clone();
                let ms = least_ms(RUNS, true, begin, || {
                    let mut odometry = Pose::default();
                    for (motion, scan) in &steps {
                        odometry = odometry.compose(*motion);
                        tracked.borrow_mut().observe(&model, odometry, &[Some(scan)]);
                    }
                });
                (ms, tracked.into_inner())
            });
            let truth = steps.iter().fold(start, |pose, (motion, _)| pose.compose(*motion));
            let estimate = tracked.estimate(&model);
            assert!(estimate.pose_in_map.distance_m(truth) < 0.15 && estimate.certainty > 0.9, "{estimate:?}");
            ms / steps.len() as f64
        });
    }
}

/// One scan of 360 rays, a third of them ending at people, against the whole science hall: 2,350 m².
fn one_scan(report: &Report) {
    let what = "one scan of 360 rays against 2,350 m²: all poses that explain it, the mean of 40 scans";
    let peers = "CBGL less than 4,000 for 2,000 m² (arXiv 2307.14247)";
    report.row(Question::new("one-scan", what, "ms", 50.0, peers), || {
        let laser = LaserScanner { readings: 360, resolution_deg: 1.0, range_m: 8.0 };
        let Some(world) = World::builtin("olin-rice") else { return f64::NAN };
        let map = world.map_centred(0.05);
        let locator = match ScanLocator::new(&map, &ScanParameters::laser(&laser).beam, 0.2) {
            Ok(locator) => locator,
            Err(error) => panic!("{error}"),
        };
        let (ground, sensor) = (TrialGround::new(map, 0.2), TrialSensor::laser(&laser));
        let mut stream = Stream::new(5, "scans");
        let scans: Vec<TrialScan> = (0..40).map(|_| ground.draw(&sensor, 1.0 / 3.0, &mut stream)).collect();
        let of_all = |scan: &TrialScan| Verdict::of(&locator.locate(&scan.beams), scan.robot_in_map);
        let named = scans.iter().filter(|scan| of_all(scan).is_named).count();
        assert!(named >= 38, "{named} of {}", scans.len());
        let all_ms = on(1, || {
            let locate = || scans.iter().for_each(|scan| drop(black_box(locator.locate(&scan.beams))));
            least_ms(RUNS / 5, true, || (), locate)
        });
        all_ms / scans.len() as f64
    });
}

/// The papers' layout: `[cell][heading]`, distances `[cell][direction]`, likelihoods as floats.
struct TwoLookUps {
    belief: Vec<f32>,
    expected: Vec<u8>,
    directions: usize,
}

impl TwoLookUps {
    fn new(model: &LocalizationModel) -> Self {
        let directions = model.sensors[0].bearings.directions;
        let mut expected = vec![0; model.grid.cells() * directions];
        for state in states() {
            let cell = state.row * model.grid.columns + state.column;
            for (sonar, bin) in model.expected_scan(0, state).into_iter().enumerate().take(2) {
                expected[cell * directions + model.sensors[0].bearings.direction(state.heading, sonar)] = bin;
            }
        }
        Self { belief: vec![0.0; STATES], expected, directions }
    }

    /// Eq. (2) as the papers compute it.
    fn sense(&mut self, model: &LocalizationModel, likelihoods: &[[f32; 256]], bearings: &[usize]) {
        let (headings, directions) = (model.grid.headings, self.directions);
        let mut sum = 0f64;
        let cells = self.belief.chunks_exact_mut(headings).zip(self.expected.chunks_exact(directions));
        for (belief, expected) in cells {
            for (heading, belief) in belief.iter_mut().enumerate() {
                let mut likelihood = 1f32;
                for (bearing, likelihoods) in bearings.iter().zip(likelihoods) {
                    let direction = heading * (directions / headings) + bearing;
                    let direction = if direction >= directions { direction - directions } else { direction };
                    likelihood *= likelihoods[usize::from(expected[direction])];
                }
                *belief *= likelihood;
                sum += f64::from(*belief);
            }
        }
        let scale = (1.0 / sum) as f32;
        self.belief.iter_mut().for_each(|belief| *belief *= scale);
    }

    fn least_ms(&mut self, model: &LocalizationModel) -> f64 {
        let (_, steps) = drive(model, 1);
        let Some((_, scan)) = steps.first() else { return f64::NAN };
        let ScanModel { parameters: ScanParameters { tempering, .. }, likelihood: sensor, .. } = &model.sensors[0];
        let likelihood = |range_m: &f32| {
            let costs = sensor.costs(sensor.bin(f64::from(*range_m)));
            costs.map(|cost| (-tempering * f64::from(cost) / 32.0).exp() as f32)
        };
        let likelihoods: Vec<[f32; 256]> = scan.iter().map(likelihood).collect();
        let bearings: Vec<usize> =
            (0..BEAMS as usize).map(|sonar| model.sensors[0].bearings.direction(0, sonar)).collect();
        let mut uniform = vec![0f32; STATES];
        for state in states().filter(|state| model.is_admissible(state.column, state.row)) {
            let cell = state.row * model.grid.columns + state.column;
            uniform[cell * model.grid.headings + state.heading] = model.prior() as f32;
        }
        let papers = std::cell::RefCell::new(self);
        let fill = || papers.borrow_mut().belief.copy_from_slice(&uniform);
        let ms = least_ms(RUNS / 3, true, fill, || papers.borrow_mut().sense(model, &likelihoods, &bearings));
        let mut belief = Belief::uniform(model);
        belief.sense_ranges(model, &[Some(scan)]);
        let mixed = model.parameters.mixing;
        let papers = &papers.borrow().belief;
        let apart = states().map(|state| {
            let cell = state.row * model.grid.columns + state.column;
            let theirs = f64::from(papers[cell * model.grid.headings + state.heading]);
            (theirs - belief.probability(model, state)).abs()
        });
        let apart = apart.sum::<f64>() / 2.0;
        assert!(apart < mixed + 1e-4, "{apart}");
        ms
    }
}
