//! What the behaviours share, and how each of them works. Every field has one writer: the belief
//! only position tracking, the drive request only the behaviour that holds the wheels.

use super::OfficeModel;
use super::behaviours::{
    ACTIVE_LOCALIZATION, BATTERY, BUMPED, GRIPPER, HOLDING, LOOK_AROUND, MESSAGES, NAVIGATION, NAVIGATION_ACTIVE,
    NR_OF_NAV_GOALS, O, POS_CERTAINTY, POSITION_TRACKING, REGION, SPEED, TRAVEL_MODE, X, Y,
};
use crate::active::{ActiveLocalization, Exploration, Intent};
use crate::geometry::{Point, Pose};
use crate::localization::{Estimate, Localization, Spread};
use crate::navigation::{
    Drive, DriveStatus, DriveTask, Grain, LookAround, MaplessNavigation, Navigation, NavigationEvent, NavigationInput,
    Obstruction, Speeds, Target,
};
use crate::simulator::{Commands, GripperCommand, GripperMotion, Percept};
use crate::world::{Door, TravelMode, World};
use rpl_lang::symbol::Symbol;
use rpl_random::Stream;
use rpl_runtime::behaviour::{Ending, Outbox, Phase, Reading, Stop};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use serde::{Deserialize, Serialize};

/// Speed limit while the robot does not know where it is: its sonars see everything it can hit.
const LOST_SPEED_MPS: f64 = 0.45;

/// In doorways the sonars fire in one step of so many.
///
/// # Deviation
/// Beetz et al. (§3.1) switch the sonars off in doorways, because in a narrow opening they hear one
/// another. Then a robot that is turned by hand inside a door drives into its frame unseen. Fired
/// seldom, they do not disturb one another either, and 0.2 s at doorway speed are 6 cm.
const DOORWAY_SONAR_STEPS: u32 = 4;

/// What the gripper is doing for a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum GripperTask {
    Grasp(String),
    Release,
}

/// Everything the behaviours share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Board {
    /// The filter; none without a map.
    pub localization: Option<Localization>,
    /// The navigation on a map; idle without one.
    pub navigation: Navigation,
    /// The navigation without a map; idle with one.
    pub mapless: MaplessNavigation,
    /// Active localization, while it is activated.
    pub active: Option<ActiveLocalization>,
    /// The percept of the last step.
    pub percept: Option<Percept>,
    /// How the robot is to drive.
    pub mode: TravelMode,
    navigation_phase: Phase,
    active_phase: Phase,
    drive: Drive,
    wander: Stream,
    drive_status: DriveStatus,
    drive_request: Speeds,
    needs_sonars: bool,
    look: Option<LookAround>,
    gripper_task: Option<GripperTask>,
    gripper_command: GripperCommand,
    was_certain: bool,
    /// What people have sent and no plan has read, the oldest first.
    pub(super) inbox: Vec<Vec<String>>,
    /// A plan has reason to think the estimate is wrong; position tracking answers in the next step.
    pub(super) position_doubted: bool,
    steps: u32,
}

impl Board {
    /// The board at the start.
    pub fn new(model: &OfficeModel, seed: u64) -> Self {
        let start_in_map = model.world.start_in_map;
        let localization = model.map.as_ref().map(|map| {
            if model.settings.start_known {
                Localization::start_at(&map.localization, start_in_map, Spread::default())
            } else {
                Localization::start_uniform(&map.localization)
            }
        });
        let wander = Stream::new(seed, "wander");
        Self {
            localization,
            navigation: Navigation::default(),
            mapless: MaplessNavigation::new(if model.settings.simulator.laser { Grain::Laser } else { Grain::Sonar }),
            active: None,
            percept: None,
            mode: TravelMode::Hallway,
            navigation_phase: Phase::Inactive,
            active_phase: Phase::Inactive,
            drive: Drive::wander(wander.clone()),
            wander,
            drive_status: DriveStatus::Driving,
            drive_request: Speeds::default(),
            needs_sonars: true,
            look: None,
            gripper_task: None,
            gripper_command: GripperCommand::None,
            was_certain: model.settings.start_known || model.map.is_none(),
            inbox: Vec::new(),
            position_doubted: false,
            steps: 0,
        }
    }

    /// Whether active localization is at work.
    pub fn is_localizing(&self) -> bool {
        self.active_phase == Phase::Active
    }

    /// What the robot is to do in the next step.
    pub(super) fn take_commands(&mut self) -> Commands {
        self.steps = self.steps.wrapping_add(1);
        let sonars_on = self.mode != TravelMode::Doorway
            || self.steps.is_multiple_of(DOORWAY_SONAR_STEPS)
            || self.needs_sonars
            || self.active_phase == Phase::Active
            || self.navigation_phase != Phase::Active;
        Commands {
            translation_mps: self.drive_request.translation_mps,
            rotation_radps: self.drive_request.rotation_radps,
            sonars_on,
            gripper: std::mem::take(&mut self.gripper_command),
        }
    }

    /// One step of all behaviours.
    pub(super) fn step(&mut self, model: &OfficeModel, percept: Percept, outbox: &mut Outbox) {
        self.track_position(model, &percept, outbox);
        self.drive_request = Speeds::default();
        self.localize_actively(model, &percept, outbox);
        self.navigate(model, &percept, outbox);
        self.look_around(model, &percept, outbox);
        self.grip(&percept, outbox);
        self.inbox.extend(percept.messages.iter().cloned());
        self.publish(model, &percept, outbox);
        self.percept = Some(percept);
    }

    /// A doubt comes after the percept: otherwise one scan that fits could make the robot certain
    /// again before anybody has seen it uncertain.
    fn track_position(&mut self, model: &OfficeModel, percept: &Percept, outbox: &mut Outbox) {
        let (Some(map), Some(localization)) = (&model.map, &mut self.localization) else { return };
        let ranges_m = percept.sonar_m.as_ref().map(|ranges_m| ranges_m.as_slice());
        localization.observe(&map.localization, percept.odometry_in_odom, ranges_m);
        if std::mem::take(&mut self.position_doubted) {
            localization.refute(&map.localization);
            outbox.events.push(("position doubted".into(), Vec::new()));
        }
    }

    /// Without a map the robot is where its odometry says, in `odom`: there is nothing to be lost in.
    pub(super) fn estimate(&self, model: &OfficeModel) -> Estimate {
        match (&model.map, &self.localization) {
            (Some(map), Some(localization)) => localization.estimate(&map.localization),
            _ => Estimate { pose_in_map: self.odometry_in_odom(), certainty: 1.0 },
        }
    }

    /// Dead reckoning.
    pub(super) fn odometry_in_odom(&self) -> Pose {
        self.percept.as_ref().map_or(Pose::default(), |percept| percept.odometry_in_odom)
    }

    fn input<'p>(percept: &'p Percept) -> NavigationInput<'p> {
        NavigationInput {
            odometry_in_odom: percept.odometry_in_odom,
            speeds: Speeds { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
            sonar_m: percept.sonar_m.as_ref(),
            laser_m: percept.laser_m.as_deref(),
            bumped: percept.bumped,
        }
    }

    fn localize_actively(&mut self, model: &OfficeModel, percept: &Percept, outbox: &mut Outbox) {
        if self.active_phase != Phase::Active {
            return;
        }
        let (Some(active), Some(map), Some(localization)) = (&mut self.active, &model.map, &self.localization) else {
            return;
        };
        let blocked = self.drive_status == DriveStatus::Stuck;
        let chosen_before = active.last_choice().map(|choice| choice.target_in_base);
        let intent = active.step(&map.localization, localization, percept.odometry_in_odom, blocked, percept.time_us);
        if let Some(choice) = active.last_choice()
            && Some(choice.target_in_base) != chosen_before
        {
            self.drive.forget_being_held_up();
            let target = choice.target_in_base;
            outbox.events.push((
                "localization action".into(),
                vec![("ahead".into(), format!("{:.1}", target.x)), ("left".into(), format!("{:.1}", target.y))],
            ));
        }
        match intent {
            Intent::Explore(how) => self.explore(how),
            Intent::FollowPath { path_in_odom } => {
                if let DriveTask::Wander { stream, .. } = &self.drive.task {
                    self.wander = stream.clone();
                }
                self.drive.task = DriveTask::Follow { path_in_odom };
            }
            Intent::Done => {
                self.active_phase = Phase::Done;
                outbox.endings.push((ACTIVE_LOCALIZATION, Ending::Success));
                return;
            }
            Intent::Failed => {
                self.active_phase = Phase::Done;
                let ending = Ending::failure("localization-failure", "the position is still not known");
                outbox.endings.push((ACTIVE_LOCALIZATION, ending));
                return;
            }
        }
        let output = self.drive.step(&model.limits, &Self::input(percept), LOST_SPEED_MPS);
        self.drive_status = output.status;
        self.drive_request = output.speeds;
    }

    /// Goes on moving about, or begins to.
    fn explore(&mut self, how: Exploration) {
        let begun = match (how, &self.drive.task) {
            (Exploration::Active | Exploration::Wander, DriveTask::Wander { .. })
            | (Exploration::WallFollow, DriveTask::WallFollow)
            | (Exploration::SpinAndBackUp, DriveTask::SpinAndBackUp { .. }) => return,
            (Exploration::Active | Exploration::Wander, _) => {
                DriveTask::Wander { stream: self.wander.clone(), heading_in_odom_rad: None, left_s: 0.0 }
            }
            (Exploration::WallFollow, _) => DriveTask::WallFollow,
            (Exploration::SpinAndBackUp, _) => DriveTask::SpinAndBackUp { elapsed_s: 0.0 },
        };
        self.drive.task = begun;
    }

    fn navigate(&mut self, model: &OfficeModel, percept: &Percept, outbox: &mut Outbox) {
        let input = Self::input(percept);
        let output = match &model.map {
            Some(map) => {
                let estimated_in_map = self.estimate(model).pose_in_map;
                self.navigation.step(&map.navigation, estimated_in_map, &input, self.mode)
            }
            None => self.mapless.step(&model.limits, &input, model.limits.speed_limit_mps(self.mode)),
        };
        self.needs_sonars = output.needs_sonars;
        if self.navigation_phase != Phase::Active {
            return;
        }
        self.drive_request = output.speeds;
        let ending = match output.event {
            Some(NavigationEvent::Arrived) => Ending::Success,
            Some(NavigationEvent::Unreachable) => {
                let message = match (&model.map, self.navigation.remaining_targets().first()) {
                    (Some(map), Some(target)) => {
                        let here = self.estimate(model).pose_in_map.point();
                        let between = map.topology.what_is_between(&map.navigation.planner, here, target.point_in_map);
                        format!("the map shows no way to the target: {between}")
                    }
                    (Some(_), None) => "the map shows no way to the target".to_string(),
                    (None, _) => "what has been seen leaves no way to the target".to_string(),
                };
                Ending::failure("unreachable", message)
            }
            Some(NavigationEvent::Blocked) => {
                let obstruction = model.map.as_ref().and_then(|map| {
                    let estimated_in_map = self.estimate(model).pose_in_map;
                    self.navigation.obstruction(&map.navigation, estimated_in_map, percept.odometry_in_odom)
                });
                blocked(&model.world, obstruction, self.estimate(model).pose_in_map.point())
            }
            Some(NavigationEvent::TargetReached) | None => return,
        };
        self.drive_request = Speeds::default();
        self.navigation_phase = Phase::Done;
        self.remove_all_targets();
        outbox.endings.push((NAVIGATION, ending));
    }

    fn look_around(&mut self, model: &OfficeModel, percept: &Percept, outbox: &mut Outbox) {
        let Some(look) = &mut self.look else { return };
        match look.step(&model.limits, percept.odometry_in_odom, Self::input(percept).speeds) {
            Some(speeds) => self.drive_request = speeds,
            None => {
                self.look = None;
                outbox.endings.push((LOOK_AROUND, Ending::Success));
            }
        }
    }

    fn grip(&mut self, percept: &Percept, outbox: &mut Outbox) {
        let Some(task) = &self.gripper_task else { return };
        if percept.gripper.motion == GripperMotion::Moving || self.gripper_command != GripperCommand::None {
            return;
        }
        let ending = match (task, percept.gripper.motion, &percept.gripper.holding) {
            (GripperTask::Grasp(wanted), GripperMotion::Closed, Some(held)) if wanted == held => Ending::Success,
            (GripperTask::Release, GripperMotion::Open, _) => Ending::Success,
            (GripperTask::Grasp(wanted), ..) => {
                Ending::failure("grasp-failure", format!("the gripper does not hold `{wanted}`"))
            }
            (GripperTask::Release, ..) => Ending::failure("grasp-failure", "the gripper did not open"),
        };
        self.gripper_task = None;
        outbox.endings.push((GRIPPER, ending));
    }

    fn publish(&mut self, model: &OfficeModel, percept: &Percept, outbox: &mut Outbox) {
        let Estimate { pose_in_map, certainty } = self.estimate(model);
        let active = &model.settings.active;
        let certain = certainty > if self.was_certain { active.certainty } else { active.found_certainty };
        if certain != self.was_certain {
            self.was_certain = certain;
            let what = if certain { "position found" } else { "position lost" };
            outbox.events.push((what.into(), vec![("certainty".into(), format!("{certainty:.2}"))]));
        }
        let mode = |mode: TravelMode| Reading::Symbol(mode_name(mode).to_string());
        let region = model.map.as_ref().and_then(|_| model.world.mode_at(pose_in_map.point()));
        let region = region.map_or(Reading::Truth(false), mode);
        let holding = percept.gripper.holding.clone().map_or(Reading::Truth(false), Reading::Symbol);
        outbox.fluents.extend([
            (X, Reading::Float(pose_in_map.x_m)),
            (Y, Reading::Float(pose_in_map.y_m)),
            (O, Reading::Float(pose_in_map.heading_rad)),
            (POS_CERTAINTY, Reading::Float(certainty)),
            (TRAVEL_MODE, mode(self.mode)),
            (REGION, region),
            (SPEED, Reading::Float(percept.translation_mps)),
            (BUMPED, Reading::Truth(percept.bumped)),
            (HOLDING, holding),
            (BATTERY, Reading::Float(libm::round(percept.battery * 1000.0) / 1000.0)),
            (MESSAGES, Reading::Int(self.inbox.len() as i64)),
        ]);
        self.publish_navigation(outbox);
    }

    fn publish_navigation(&self, outbox: &mut Outbox) {
        let active = matches!(self.navigation_phase, Phase::Active | Phase::Interrupted);
        let goals = if active { self.remaining_targets() } else { 0 };
        outbox.fluents.push((NAVIGATION_ACTIVE, Reading::Truth(active)));
        outbox.fluents.push((NR_OF_NAV_GOALS, Reading::Int(goals as i64)));
    }

    /// Starts a behaviour.
    pub(super) fn start(
        &mut self,
        model: &OfficeModel,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        match behaviour {
            ACTIVE_LOCALIZATION => self.start_active_localization(model, outbox)?,
            NAVIGATION => {
                let (targets, patience_s) = navigation_arguments(machine, arguments)?;
                match model.map {
                    Some(_) => self.navigation.start(targets, patience_s.unwrap_or(Navigation::PATIENCE_S)),
                    None => self.mapless.start(targets, patience_s.unwrap_or(MaplessNavigation::PATIENCE_S)),
                }
                self.navigation_phase = Phase::Active;
                self.publish_navigation(outbox);
            }
            GRIPPER => self.start_gripper(machine, arguments)?,
            LOOK_AROUND => self.look = Some(LookAround::from(self.odometry_in_odom())),
            _ => debug_assert_eq!(behaviour, POSITION_TRACKING, "it is active from the start"),
        }
        Ok(())
    }

    fn remove_all_targets(&mut self) {
        self.navigation.remove_all_targets();
        self.mapless.remove_all_targets();
    }

    /// Targets not yet reached.
    fn remaining_targets(&self) -> usize {
        self.navigation.remaining_targets().len() + self.mapless.remaining_targets().len()
    }

    fn start_active_localization(&mut self, model: &OfficeModel, outbox: &mut Outbox) -> Result<(), Raise> {
        let (Some(map), Some(localization)) = (&model.map, &mut self.localization) else {
            return Err(no_map("there is nothing to localize in"));
        };
        let (odometry_in_odom, time_us) =
            self.percept.as_ref().map_or((Pose::default(), 0), |percept| (percept.odometry_in_odom, percept.time_us));
        self.active = Some(ActiveLocalization::start(
            &map.localization,
            localization,
            odometry_in_odom,
            time_us,
            model.settings.active.clone(),
        ));
        self.active_phase = Phase::Active;
        self.drive_status = DriveStatus::Driving;
        self.drive = Drive::wander(self.wander.clone());
        outbox.fluents.push((POS_CERTAINTY, Reading::Float(self.estimate(model).certainty)));
        Ok(())
    }

    fn start_gripper(&mut self, machine: &Machine, arguments: &[(Symbol, Value)]) -> Result<(), Raise> {
        let argument =
            |name: &str| arguments.iter().find(|(key, _)| machine.symbols.name(*key) == name).map(|&(_, value)| value);
        let (task, command) = match (argument("grasp"), argument("release")) {
            (Some(Value::Symbol(item)), None) => {
                let item = machine.symbols.name(item).to_string();
                (GripperTask::Grasp(item.clone()), GripperCommand::Grasp(item))
            }
            (None, Some(release)) if release.is_true() => (GripperTask::Release, GripperCommand::Release),
            _ => {
                return Err(Raise::type_error("`gripper` takes `:grasp NAME` or `:release t`"));
            }
        };
        self.gripper_task = Some(task);
        self.gripper_command = command;
        Ok(())
    }

    /// Stops a behaviour.
    pub(super) fn stop(&mut self, behaviour: u16, how: Stop, outbox: &mut Outbox) {
        let phase = match how {
            Stop::Deactivated => Phase::Inactive,
            Stop::Interrupted => Phase::Interrupted,
        };
        match behaviour {
            ACTIVE_LOCALIZATION => {
                self.active_phase = phase;
                self.drive_request = Speeds::default();
                if how == Stop::Deactivated {
                    self.active = None;
                }
            }
            NAVIGATION => {
                self.navigation_phase = phase;
                self.remove_all_targets();
                self.drive_request = Speeds::default();
                self.publish_navigation(outbox);
            }
            GRIPPER => self.gripper_task = None,
            LOOK_AROUND => {
                self.look = None;
                self.drive_request = Speeds::default();
            }
            _ => {}
        }
    }
}

/// The failure that tells what blocks the way, and where; `here` is the robot's own place.
fn blocked(world: &World, obstruction: Option<Obstruction>, here: Point) -> Ending {
    let (what, obstacle, room, at) = match obstruction {
        Some(Obstruction::Door(door)) => {
            let Door { room, at, .. } = &world.doors[door];
            let what = format!("the door of `{room}` at {:.1} {:.1} is closed, or something stands in it", at.x, at.y);
            (what, Some("door"), Some(room.as_str()), *at)
        }
        Some(Obstruction::Thing(at)) => {
            let room = world.room_at(at).map(|room| &*room.name);
            let inside = room.map_or(String::new(), |room| format!(" in `{room}`"));
            let what = format!("a thing or a person that is not in the map stands at {:.1} {:.1}{inside}", at.x, at.y);
            (what, Some("thing"), room, at)
        }
        None => {
            (format!("nothing is seen in it; the robot came as far as {:.1} {:.1}", here.x, here.y), None, None, here)
        }
    };
    let symbol = |name: Option<&str>| name.map_or(Reading::Truth(false), |name| Reading::Symbol(name.to_string()));
    Ending::Failure {
        class: "blocked".to_string(),
        message: format!("the way to the target stays blocked: {what}"),
        slots: vec![
            ("obstacle".to_string(), symbol(obstacle)),
            ("room".to_string(), symbol(room)),
            ("x".to_string(), Reading::Float(at.x)),
            ("y".to_string(), Reading::Float(at.y)),
        ],
    }
}

/// What needs a map fails, and says what to do instead.
pub(super) fn no_map(what: &str) -> Raise {
    Raise::new("localization-failure", format!("the robot has no map: {what}; run the plan without `--map none`"))
}

/// The name plans use for a travel mode.
pub(super) fn mode_name(mode: TravelMode) -> &'static str {
    match mode {
        TravelMode::Hallway => "hallway",
        TravelMode::Office => "office",
        TravelMode::Doorway => "doorway",
    }
}

/// `:targets`, a list of (x y) or (x y heading), and `:patience` in seconds.
fn navigation_arguments(machine: &Machine, arguments: &[(Symbol, Value)]) -> Result<(Vec<Target>, Option<f64>), Raise> {
    let (mut targets, mut patience_s) = (Vec::new(), None);
    for &(key, value) in arguments {
        match machine.symbols.name(key) {
            "targets" => targets = targets_argument(machine, value)?,
            "patience" => patience_s = patience_argument(value)?,
            _ => return Err(no_targets()),
        }
    }
    if targets.is_empty() { Err(no_targets()) } else { Ok((targets, patience_s)) }
}

fn no_targets() -> Raise {
    Raise::type_error("`navigation` takes `:targets`, a list of points `(x y)` or `(x y heading)`, and `:patience`")
}

fn targets_argument(machine: &Machine, points: Value) -> Result<Vec<Target>, Raise> {
    let target = |point: Value| {
        let numbers: Option<Vec<f64>> =
            machine.heap.elements(point).map_err(|_| no_targets())?.into_iter().map(Value::as_f64).collect();
        match numbers.as_deref() {
            Some(&[x_m, y_m]) => Ok(Target::through(Point::new(x_m, y_m))),
            Some(&[x_m, y_m, heading_rad]) => Ok(Target::at(Pose::new(x_m, y_m, heading_rad))),
            _ => Err(no_targets()),
        }
    };
    machine.heap.elements(points).map_err(|_| no_targets())?.into_iter().map(target).collect()
}

/// How long the robot is to wait where it gets no nearer: seconds, at least 0; nil is the usual.
pub(super) fn patience_argument(value: Value) -> Result<Option<f64>, Raise> {
    let wrong = || Raise::type_error("a patience is a time in seconds, at least 0, such as `:patience 2min`, or nil");
    match value {
        Value::Nil => Ok(None),
        value => value.as_f64().filter(|patience_s| *patience_s >= 0.0).map(Some).ok_or_else(wrong),
    }
}
