//! The robot's part of a saved run: everything that changes, and beside it what it belongs to.

use super::board::Board;
use super::controller::Controller;
use super::host::{HostLost, SaveHost, SimulatedHost};
use super::model::PositionBy;
use super::module::Module;
use super::report::Report;
use super::robot::OfficeRobot;
use super::saved_bytes::{read, taken};
use super::scenario::Oracle;
use crate::active::ActiveParameters;
use crate::description::RobotDescription;
use crate::localization::LocalizationParameters;
use crate::simulator::SimulatorState;
use crate::world::World;
use rpl_runtime::run::library::Loaded;
use rpl_runtime::run::save::{SaveOutside, append};
use rpl_runtime::run::system::System;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

/// What the state belongs to: grids, doors and objects are counted by it, so a state is taken over
/// only where it is the same.
#[derive(Serialize, Deserialize, PartialEq)]
struct Setting {
    world: World,
    robot: RobotDescription,
    position_by: PositionBy,
    localization: LocalizationParameters,
    active: ActiveParameters,
    map_known: bool,
    /// The names of what the robot's modules offer, in order.
    names: Vec<String>,
}

impl Setting {
    fn of<H, M: Module>(robot: &OfficeRobot<H, M>) -> Self {
        let settings = &robot.model().settings;
        Self {
            world: World::clone(&robot.model().world),
            robot: RobotDescription::clone(&settings.robot),
            position_by: settings.position_by,
            localization: settings.localization.clone(),
            active: settings.active.clone(),
            map_known: settings.map_known,
            names: robot.controller.composition.reserved_names(),
        }
    }
}

fn written(value: &impl Serialize) -> Vec<u8> {
    append(Vec::new(), value)
}

/// What is saved before the modules. Compiled once, as it knows no type of hosts and modules.
impl Setting {
    /// The bytes, and behind them the setting and the board.
    fn save(&self, bytes: Vec<u8>, board: &Board) -> Vec<u8> {
        append(bytes, &(ByteBuf::from(written(self)), board))
    }

    /// The board that was saved in this setting, and the bytes behind it.
    fn load(self, bytes: &[u8]) -> Result<(Board, &[u8]), String> {
        let (setting, rest): (ByteBuf, &[u8]) = taken(bytes)?;
        let (setting, here): (Setting, Setting) = (read(&setting)?, self);
        if setting.world != here.world {
            let (there, here) = (setting.world.name, here.world.name);
            return Err(format!(
                "the run was saved in the world `{there}`, which is not the world `{here}` as it is now"
            ));
        }
        if setting.robot != here.robot {
            let (there, here) = (setting.robot.name, here.robot.name);
            return Err(format!(
                "the run was saved with the robot `{there}`, which is not the robot `{here}` as it is now"
            ));
        }
        if setting.map_known != here.map_known {
            let with = |map_known: bool| if map_known { "with a map" } else { "without a map" };
            let (there, here) = (with(setting.map_known), with(here.map_known));
            return Err(format!("the run was saved {there}, and this one is {here}"));
        }
        if setting.names != here.names {
            return Err("the run was saved with other modules".into());
        }
        if setting != here {
            return Err("the run was saved with other settings of localization".into());
        }
        taken(rest)
    }
}

impl<H: SaveHost + 'static, M: Module> SaveOutside for OfficeRobot<H, M> {
    fn save(&self, bytes: Vec<u8>) -> Vec<u8> {
        let Controller { board, modules, .. } = &self.controller;
        let bytes = modules.save(Setting::of(self).save(bytes, board));
        append(bytes, &(ByteBuf::from(self.host.save()), &self.lost))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (board, rest) = Setting::of(self).load(bytes)?;
        let (mut modules, rest) = M::load(rest)?;
        let (host, lost): (ByteBuf, Option<HostLost>) = read(rest)?;
        modules.resume(&self.controller.modules)?;
        if board.position.localization().is_some() != self.model().settings.has_belief() {
            return Err("its state is damaged: it has a belief only where the robot localizes on a map".into());
        }
        self.host.load(&host)?;
        (self.controller.board, self.controller.modules, self.lost) = (board, modules, lost);
        Ok(())
    }
}

impl SaveHost for SimulatedHost {
    fn save(&self) -> Vec<u8> {
        let scenario = self.scenario.as_ref().map(|scenario| ByteBuf::from(scenario.save()));
        written(&(&self.state, scenario))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (state, scenario): (SimulatorState, Option<ByteBuf>) = read(bytes)?;
        if !self.model.fits(&state) {
            return Err("its state does not fit the world".into());
        }
        self.scenario = match (scenario, self.scenario.take()) {
            (None, None) => None,
            (Some(bytes), Some(fresh)) => Some(Box::new(restored(&bytes, *fresh)?)),
            (Some(_), None) => return Err("the run was saved with a scenario, and there is none".into()),
            (None, Some(_)) => return Err("the run was saved without a scenario, and there is one".into()),
        };
        self.state = state;
        Ok(())
    }
}

/// A scenario carried on where it was; `fresh` is the same one at its start.
fn restored(bytes: &[u8], fresh: System<Oracle>) -> Result<System<Oracle>, String> {
    let symbols = fresh.machine.symbols.clone();
    let loaded = Loaded { program: fresh.program, symbols, main: 0, tests: Vec::new(), warnings: Vec::new() };
    System::load(bytes, fresh.library, loaded, fresh.outside).map_err(|error| format!("in the scenario, {error}"))
}

impl SaveOutside for Oracle {
    fn save(&self, bytes: Vec<u8>) -> Vec<u8> {
        append(bytes, &(&self.state, &self.deeds))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (state, deeds): (SimulatorState, Vec<Report>) = read(bytes)?;
        if !self.model.fits(&state) {
            return Err("its state does not fit the world".into());
        }
        self.state = state;
        self.deeds = deeds;
        Ok(())
    }
}
