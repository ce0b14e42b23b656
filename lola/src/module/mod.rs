//! What plans see of it: the only part of this crate that knows the runtime.
//!
//! Read in this order: `hallway` (what the robot knows of the hallway it is in), `drive` and `hallway_drive`
//! (what it does with the wheels), `counting` (how far it has got with an instruction), `state`; `behaviours`,
//! `driving`, `fluents` and `functions` (what plans have of all that).

mod behaviour_places;
mod behaviours;
mod counting;
mod data;
mod drive;
mod driving;
mod fluents;
mod functions;
mod hallway;
mod hallway_drive;
mod seeing;
mod settings;
mod state;

pub use hallway::Hallway;
pub use settings::LolaSettings;
pub use state::Lola;

use rpl_robot::office::{Commands, Phase, TravelMode, Velocity};
use rpl_robot::office::{
    Module, ModuleSpec, Moment, OfficeModel, PlanText, Position, Raise, Start, StopReason, Telling,
};
use seeing::Seeing;

/// The plans that belong to it.
pub const PLANS: &str = include_str!("../../plans/instructions.rpl");

impl Module for Lola {
    type Settings = LolaSettings;

    fn specs(_: &LolaSettings) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: "lola".into(),
            behaviours: behaviours::behaviours(),
            fluents: fluents::FLUENTS.to_vec(),
            functions: functions::functions(),
            plans: vec![PlanText { name: "instructions".into(), text: PLANS.into() }],
            ..ModuleSpec::default()
        }]
    }

    fn new(settings: &LolaSettings, _: &OfficeModel, _: u64) -> Self {
        Self { settings: settings.clone(), ..Self::default() }
    }

    fn resume(&mut self, at_start: &Self) -> Result<(), String> {
        self.settings = at_start.settings.clone();
        self.markers.iter_mut().for_each(Seeing::resume);
        Ok(())
    }

    fn start(
        &mut self,
        behaviour: usize,
        start: &Start<'_>,
        position: &mut Position,
        _: &mut Telling<'_>,
    ) -> Result<(), Raise> {
        self.begin(behaviour, start, position.odometry_in_odom())
    }

    fn stop(&mut self, behaviour: usize, why: StopReason, _: &mut Telling<'_>) {
        self.end(behaviour, why);
    }

    /// Who goes by what is beside the robot needs to hear it, in doorways too.
    fn command(&mut self, _: TravelMode, phases: &[Phase], commands: &mut Commands) {
        commands.sonars_on |= phases.contains(&Phase::Active);
        if let Some(seeing) =
            self.markers.as_ref().filter(|_| phases[behaviour_places::MARKER_DETECTION] == Phase::Active)
        {
            commands.camera = Some(seeing.command());
        }
    }

    fn step(&mut self, now: &Moment<'_>, _: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        if !now.phases.contains(&Phase::Active) {
            return None;
        }
        let axis_rad = self.hallway.as_ref().and_then(Hallway::axis).map(|axis| axis.heading_in_odom_rad);
        if let Some(seeing) =
            self.markers.as_mut().filter(|_| now.phases[behaviour_places::MARKER_DETECTION] == Phase::Active)
        {
            seeing.take_in(now, axis_rad);
        }
        self.drive_on(now, tell)
    }

    fn publish(&mut self, now: &Moment<'_>, _: &Position, tell: &mut Telling<'_>) {
        self.tell(now, tell);
    }
}
