//! What becomes of behaviours: they are activated and deactivated, lose their valves and their goals, and
//! end by themselves.

use crate::robot::{Ending, Outbox, RobotGlobals, StopReason};
use crate::state::activation::{Activation, Phase, Phases};
use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::value::Value;
use crate::step::native::Surroundings;
use rpl_lang::symbol::Symbol;

impl Machine {
    /// Lets the robot's news take effect: all fluents as one assignment, then signals.
    pub fn apply_outbox(&mut self, around: &mut Surroundings<'_>, outbox: Outbox) {
        for event in &outbox.events {
            self.trace_robot(event);
        }
        let mut values = Vec::new();
        for (number, reading) in &outbox.fluents {
            if let Some(fluent) = self.robot_fluent(around.robot, *number) {
                values.push((fluent, self.value_of_reading(reading)));
            }
        }
        self.assign_all(around, &values);
        for (behaviour, ending) in outbox.endings {
            self.behaviour_ended(around, behaviour, ending);
        }
        for behaviour in outbox.interrupted {
            self.take_goals(around, behaviour, "it has lost its goals");
        }
    }

    /// The fluent of a number in the robot's table; none without a robot.
    pub fn robot_fluent(&self, robot: &RobotGlobals, number: usize) -> Option<u32> {
        match self.globals.get(*robot.fluents.get(number)? as usize)? {
            Value::Fluent(fluent) => Some(*fluent),
            _ => None,
        }
    }

    fn behaviour_ended(&mut self, around: &mut Surroundings<'_>, behaviour: u16, ending: Ending) {
        let signal = match ending {
            Ending::Success(reading) => Ok(self.value_of_reading(&reading)),
            Ending::Failure { class, message, slots } => {
                let (class, message) = self.known_class(around, class, message);
                Err(self.behaviour_failure(behaviour, &class, message, slots))
            }
        };
        self.activation(behaviour).phase = Phase::Done;
        self.signal(around, behaviour, signal);
        let owner = self.activation(behaviour).task;
        self.release_activation(around, behaviour, owner);
    }

    /// A class of failures that handlers know: one that the program has not defined is told in the message of
    /// a `behaviour-failure`.
    pub(in crate::step) fn known_class(
        &self,
        around: &Surroundings<'_>,
        class: String,
        message: String,
    ) -> (String, String) {
        let symbol = self.symbols.find(&class);
        if symbol.is_some_and(|symbol| around.program.failure_classes.contains_key(&symbol)) {
            return (class, message);
        }
        ("behaviour-failure".to_string(), format!("{message} (there is no failure class `{class}`)"))
    }

    /// `(activate B :key V...)` by the current task.
    pub(crate) fn activate(
        &mut self,
        around: &mut Surroundings<'_>,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
    ) -> Result<(), Raise> {
        let spec = &around.outside.tables().behaviours[usize::from(behaviour)];
        let task = self.current;
        let me = self.tasks.reference(task);
        let entry = self.activation(behaviour).clone();
        let other = entry.task.and_then(|owner| self.tasks.find_alive(owner)).filter(|&owner| owner != task);
        if let (Phase::Active, Some(owner)) = (entry.phase, other) {
            let path = self.path(owner);
            return Err(Raise::new("behaviour-failure", format!("`{}` is already activated by {path}", spec.name)));
        }
        let valve = self.valve_of(around.robot, behaviour);
        let place = valve.and_then(|valve| self.place_had(task, valve));
        if valve.is_some() && place.is_none() {
            let name = spec.valve.as_deref().unwrap_or_default();
            return Err(Raise::new(
                "valve-error",
                format!(
                    "`{}` drives with the valve `{name}`, and this task does not hold it; wrap it in `(with-valve {name} …)`",
                    spec.name
                ),
            ));
        }
        if entry.phase == Phase::Active {
            self.stop_behaviour(around, behaviour);
        }
        let mut outbox = Outbox::default();
        around.outside.start(self, behaviour, arguments, &mut outbox)?;
        let mut kept = entry.kept;
        kept.retain(|(owner, _)| *owner != me);
        if let (Some(owner), Some(signal)) = (other, entry.signal) {
            kept.push((self.tasks.reference(owner), signal));
        }
        *self.activation(behaviour) = Activation { phase: Phase::Active, task: Some(me), signal: None, kept };
        if let Some(place) = place {
            self.hold_for_activation(task, place, behaviour);
        }
        self.trace_behaviour(around, behaviour, "activated");
        self.apply_outbox(around, outbox);
        Ok(())
    }

    fn valve_of(&self, robot: &RobotGlobals, behaviour: u16) -> Option<u32> {
        let global = (*robot.valves.get(usize::from(behaviour))?)?;
        match self.globals.get(global as usize)? {
            Value::Valve(valve) => Some(*valve),
            _ => None,
        }
    }

    /// `(deactivate B)` by the current task: touches only what it or a descendant activated.
    pub(crate) fn deactivate(&mut self, around: &mut Surroundings<'_>, behaviour: u16) {
        let mut kept = std::mem::take(&mut self.activation(behaviour).kept);
        kept.retain(|(owner, _)| !self.tasks.find(*owner).is_some_and(|owner| self.is_within(owner, self.current)));
        self.activation(behaviour).kept = kept;
        let entry = self.activation(behaviour);
        let (phase, owner) = (entry.phase, entry.task);
        let owner = owner.and_then(|owner| self.tasks.find(owner));
        if phase == Phase::Inactive || !owner.is_some_and(|owner| self.is_within(owner, self.current)) {
            return;
        }
        self.stop_behaviour(around, behaviour);
    }

    fn stop_behaviour(&mut self, around: &mut Surroundings<'_>, behaviour: u16) {
        let mut outbox = Outbox::default();
        around.outside.stop(behaviour, StopReason::Deactivated, &mut outbox);
        self.trace_behaviour(around, behaviour, "deactivated");
        let before = std::mem::take(self.activation(behaviour));
        self.activation(behaviour).kept = before.kept;
        self.release_activation(around, behaviour, before.task);
        self.apply_outbox(around, outbox);
    }

    /// A behaviour that is at work stops for a reason that does not lie in the task that started it.
    fn interrupt(&mut self, around: &mut Surroundings<'_>, behaviour: u16, why: &str) {
        let mut outbox = Outbox::default();
        around.outside.stop(behaviour, StopReason::Interrupted, &mut outbox);
        self.trace_behaviour(around, behaviour, "interrupted");
        self.activation(behaviour).phase = Phase::Interrupted;
        self.apply_outbox(around, outbox);
        let name = &around.outside.tables().behaviours[usize::from(behaviour)].name;
        let message = format!("`{name}` was interrupted: {why}");
        let failure = self.behaviour_failure(behaviour, "interrupted", message, Vec::new());
        self.signal(around, behaviour, Err(failure));
    }

    /// A behaviour loses its valve to a task.
    pub(crate) fn interrupt_behaviour(
        &mut self,
        around: &mut Surroundings<'_>,
        behaviour: u16,
        valve: u32,
        taker: u32,
    ) {
        if self.activation(behaviour).phase == Phase::Active {
            let why = format!("{} has taken the valve `{}`", self.path(taker), self.valve_name(valve));
            self.interrupt(around, behaviour, &why);
        }
    }

    /// A behaviour loses its goals, if the current task or a descendant activated it.
    pub fn remove_goals(&mut self, around: &mut Surroundings<'_>, behaviour: u16) {
        let owner = self.activation(behaviour).task.and_then(|owner| self.tasks.find(owner));
        if owner.is_some_and(|owner| self.is_within(owner, self.current)) {
            self.take_goals(around, behaviour, "it has lost its goals");
        }
    }

    /// A behaviour that is at work loses its goals, whoever activated it.
    pub(crate) fn take_goals(&mut self, around: &mut Surroundings<'_>, behaviour: u16, why: &str) {
        let entry = self.activation(behaviour);
        let (phase, task) = (entry.phase, entry.task);
        if phase == Phase::Active {
            self.interrupt(around, behaviour, why);
            self.release_activation(around, behaviour, task);
        }
    }

    /// What a dead task had activated stops.
    pub(crate) fn end_activations_of(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let me = self.tasks.reference(task);
        for behaviour in 0..self.activations.len() as u16 {
            let entry = &mut self.activations[usize::from(behaviour)];
            entry.kept.retain(|(owner, _)| *owner != me);
            if entry.task == Some(me) && entry.phase != Phase::Inactive {
                self.stop_behaviour(around, behaviour);
            }
        }
    }

    /// Where the behaviours stand.
    pub fn phases(&self) -> Phases<'_> {
        Phases(&self.activations)
    }

    pub(crate) fn activation(&mut self, behaviour: u16) -> &mut Activation {
        let at = usize::from(behaviour);
        if self.activations.len() <= at {
            self.activations.resize(at + 1, Activation::default());
        }
        &mut self.activations[at]
    }
}
