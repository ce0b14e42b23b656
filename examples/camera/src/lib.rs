//! A camera that pans, in a crate of its own: a module that plans see, a host that has the camera, and
//! the robot of both. `docs/modules.md` leads through it.

use rpl_lang::compile::NoFiles;
use rpl_mission::site::{Setup, Site};
use rpl_robot::geometry::Velocity;
use rpl_robot::occupancy::DistanceField;
use rpl_robot::office::{
    Commands, Composition, Host, HostLost, Module, ModuleSpec, Moment, OfficeModel, OfficeModules, OfficeRobot, Phase,
    Position, Raise, Report, SimulatedHost, Start, StopReason, Telling, TravelMode, fluent, signal_reading,
};
use rpl_robot::sensors::Signal;
use rpl_robot::simulator::{ItemPlace, Percept};
use rpl_robot::world::World;
use rpl_runtime::robot::{BehaviourSpec, Ending};
use rpl_runtime::run::system::System;
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::sync::Arc;

/// The camera as plans see it: a behaviour that turns it, guarded by a valve, and what it sees.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Camera {
    /// Where it is to look, left of ahead.
    target_rad: f64,
    is_panning: bool,
}

impl Module for Camera {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        let pan = BehaviourSpec {
            name: "pan".into(),
            doc: "Turns the camera to the angle `:to`, left of ahead; succeeds when it looks there.".into(),
            valve: Some("camera".into()),
            parameters: ":to".into(),
        };
        let seen = fluent("seen*", "What the camera sees: lists (name bearing distance), in radians and metres.");
        let (behaviours, fluents, valves) = (vec![pan], vec![seen], vec!["camera".into()]);
        vec![ModuleSpec { name: "camera".into(), behaviours, fluents, valves, ..ModuleSpec::default() }]
    }

    fn new((): &(), _: &OfficeModel, _: u64) -> Self {
        Self::default()
    }

    fn start(&mut self, _: usize, start: &Start<'_>, _: &mut Position, _: &mut Telling<'_>) -> Result<(), Raise> {
        let angle_rad = start.argument("to").and_then(|value| value.as_f64());
        self.target_rad = angle_rad.ok_or_else(|| Raise::type_error("`pan` takes an angle, such as `:to 30deg`"))?;
        self.is_panning = true;
        Ok(())
    }

    fn stop(&mut self, _: usize, _: StopReason, _: &mut Telling<'_>) {
        self.is_panning = false;
    }

    fn command(&mut self, _: TravelMode, _: &[Phase], commands: &mut Commands) {
        commands.others.insert("pan".into(), Signal::Number(self.target_rad));
    }

    fn step(&mut self, now: &Moment<'_>, _: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        if let Some(seen) = now.percept.others.get("seen").and_then(|seen| signal_reading(seen).ok()) {
            tell.fluent(0, seen);
        }
        let pan_rad = now.percept.others.get("pan").and_then(Signal::number)?;
        if self.is_panning && (pan_rad - self.target_rad).abs() < STEP_RAD / 2.0 {
            self.is_panning = false;
            tell.end(0, Ending::DONE);
        }
        None
    }
}

/// By how much the camera turns in a step, and how far it sees to both sides and ahead.
const STEP_RAD: f64 = 0.05;
const HALF_VIEW_RAD: f64 = 0.4;
const RANGE_M: f64 = 4.0;

/// The simulated robot with a camera on it: what is there, and what hides it, is the world's.
#[derive(Clone)]
pub struct CameraHost {
    simulated: SimulatedHost,
    walls: Arc<DistanceField>,
    pan_rad: f64,
}

impl CameraHost {
    /// The things in view: name, bearing and distance of each.
    fn seen(&self) -> Signal {
        let robot_in_map = self.simulated.state.true_pose();
        let in_view = self.simulated.state.gripper.items.iter().filter_map(|item| {
            let ItemPlace::Point(item_in_map) = item.at else { return None };
            let in_base = robot_in_map.inverse().transform(item_in_map);
            let (bearing_rad, range_m) = (libm::atan2(in_base.y, in_base.x), libm::hypot(in_base.x, in_base.y));
            let (sin, cos) = libm::sincos(robot_in_map.heading_rad + bearing_rad);
            let is_free = || self.walls.cast_m(robot_in_map.point(), (cos, sin), range_m) >= range_m;
            let seen = vec![Signal::Text(item.name.clone()), Signal::Number(bearing_rad), Signal::Number(range_m)];
            let is_ahead = (bearing_rad - self.pan_rad).abs() < HALF_VIEW_RAD && range_m < RANGE_M;
            (is_ahead && is_free()).then_some(Signal::List(seen))
        });
        Signal::List(in_view.collect())
    }
}

impl Host for CameraHost {
    fn step(&mut self, commands: &Commands, reports: &mut Vec<Report>) -> Result<Percept, HostLost> {
        let target_rad = commands.others.get("pan").and_then(Signal::number).unwrap_or_default();
        self.pan_rad += (target_rad - self.pan_rad).clamp(-STEP_RAD, STEP_RAD);
        let mut percept = self.simulated.step(commands, reports)?;
        percept.others = [("pan".into(), Signal::Number(self.pan_rad)), ("seen".into(), self.seen())].into();
        Ok(percept)
    }
}

rpl_robot::modules! {
    /// The office robot's modules, and the camera.
    pub struct CameraModules { office: OfficeModules, camera: Camera }
}

/// A run of a plan on the robot with the camera, in a built-in world.
///
/// # Errors
/// There is no such world, or the plan is wrong.
pub fn mission(
    world: &str,
    plan: &str,
    seed: u64,
) -> Result<System<OfficeRobot<CameraHost, CameraModules>>, Box<dyn Error>> {
    let modules = Composition::<CameraModules>::new(Default::default())?;
    let site = Site::with_modules(Setup { world: World::builtin(world), ..Setup::default() }, modules)?;
    let office = site.office().ok_or("no such world")?;
    let walls = Arc::new(DistanceField::new(&office.world.map(0.05)));
    let host = CameraHost { simulated: SimulatedHost::new(office.simulator.clone(), seed, None), walls, pan_rad: 0.0 };
    let robot = site.robot_on(host, seed).ok_or("no robot")?;
    Ok(System::new(site.library.clone(), site.compile("plan.rpl", plan, &mut NoFiles)?, robot, seed))
}

#[test]
fn the_camera_pans_until_the_mail_is_in_view() {
    let mut run = mission("dept", include_str!("../camera.rpl"), 1).unwrap_or_else(|error| panic!("{error}"));
    rpl_mission::run::run_to(&mut run, 300_000_000, |_| std::ops::ControlFlow::Continue(()));
    assert!(run.machine.output.iter().any(|line| line.text.starts_with("seen: (mail ")), "{:?}", run.outcome());
}
