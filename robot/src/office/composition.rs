//! How a robot is composed of modules: the list, and what follows from it, the order of their steps and
//! the tables that plans see.

use super::module::{Module, PlanText};
use crate::foresight::act_model::ActModel;
use rpl_runtime::robot::{BehaviourSpec, RobotTables};
use rpl_runtime::step::native::Native;
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// Makes of a list of modules one module. They start, step and tell in the order of the list.
///
/// The crate that uses it depends on `serde`, with `derive`.
///
/// ```
/// # use rpl_robot::office::{Composition, OfficeModules};
/// rpl_robot::modules! {
///     /// The office robot, twice as long.
///     pub struct MyModules {
///         /// All that the office robot has.
///         pub office: OfficeModules,
///         // Your own modules follow.
///     }
/// }
/// let modules = Composition::<MyModules>::new(Default::default())?;
/// assert!(modules.tables.names().any(|name| name == "navigation"));
/// # Ok::<(), rpl_robot::office::NameTaken>(())
/// ```
#[macro_export]
macro_rules! modules {
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $name:ident {
            $($(#[$field_attribute:meta])* $field_visibility:vis $field:ident: $module:ty),+ $(,)?
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, ::serde::Serialize, ::serde::Deserialize)]
        $visibility struct $name {
            $($(#[$field_attribute])* $field_visibility $field: $module,)+
            #[serde(skip)]
            layout: $crate::office::Layout,
        }

        impl $name {
            /// Where the modules' behaviours and fluents stand.
            fn layout(
                ($($field,)+): &<Self as $crate::office::Module>::Settings,
            ) -> $crate::office::Layout {
                let mut layout = $crate::office::Layout::default();
                $(layout.push(&<$module as $crate::office::Module>::specs($field));)+
                layout
            }
        }

        impl $crate::office::Module for $name {
            type Settings = ($(<$module as $crate::office::Module>::Settings,)+);

            fn specs(($($field,)+): &Self::Settings) -> ::std::vec::Vec<$crate::office::ModuleSpec> {
                let mut specs = ::std::vec::Vec::new();
                $(specs.extend(<$module as $crate::office::Module>::specs($field));)+
                specs
            }

            fn new(settings: &Self::Settings, model: &$crate::office::OfficeModel, seed: u64) -> Self {
                let layout = Self::layout(settings);
                let ($($field,)+) = settings;
                Self { $($field: $crate::office::Module::new($field, model, seed),)+ layout }
            }

            // One after the other, as all of them at once would be; so each is compiled once, by whoever lists it.
            fn save(&self, bytes: ::std::vec::Vec<u8>) -> ::std::vec::Vec<u8> {
                $(let bytes = $crate::office::Module::save(&self.$field, bytes);)+
                bytes
            }

            fn load(bytes: &[u8]) -> ::std::result::Result<(Self, &[u8]), ::std::string::String> {
                $(let ($field, bytes) = <$module as $crate::office::Module>::load(bytes)?;)+
                let layout = ::std::default::Default::default();
                ::std::result::Result::Ok((Self { $($field,)+ layout }, bytes))
            }

            fn resume(&mut self, at_start: &Self) -> ::std::result::Result<(), ::std::string::String> {
                self.layout = at_start.layout.clone();
                $($crate::office::Module::resume(&mut self.$field, &at_start.$field)?;)+
                Ok(())
            }

            fn renew(&mut self, tell: &mut $crate::office::Telling<'_>) -> bool {
                let mut parts = self.layout.parts();
                let mut is_outside = false;
                $(if let Some(part) = parts.next() {
                    is_outside |= $crate::office::Module::renew(&mut self.$field, &mut tell.of(part));
                })+
                is_outside
            }

            fn foresee(&mut self) {
                $($crate::office::Module::foresee(&mut self.$field);)+
            }

            fn start(
                &mut self,
                behaviour: usize,
                start: &$crate::office::Start<'_>,
                position: &mut $crate::office::Position,
                tell: &mut $crate::office::Telling<'_>,
            ) -> ::std::result::Result<(), $crate::office::Raise> {
                let mut parts = self.layout.parts();
                $(if let Some(part) = parts.next() && part.behaviours.contains(&behaviour) {
                    let behaviour = behaviour - part.behaviours.start;
                    return $crate::office::Module::start(
                        &mut self.$field, behaviour, start, position, &mut tell.of(part),
                    );
                })+
                unreachable!("no module has a behaviour {behaviour}")
            }

            fn stop(
                &mut self,
                behaviour: usize,
                why: $crate::office::StopReason,
                tell: &mut $crate::office::Telling<'_>,
            ) {
                let mut parts = self.layout.parts();
                $(if let Some(part) = parts.next() && part.behaviours.contains(&behaviour) {
                    let behaviour = behaviour - part.behaviours.start;
                    return $crate::office::Module::stop(&mut self.$field, behaviour, why, &mut tell.of(part));
                })+
            }

            fn command(
                &mut self,
                mode: $crate::office::TravelMode,
                phases: &[$crate::office::Phase],
                commands: &mut $crate::office::Commands,
            ) {
                let mut parts = self.layout.parts();
                $(if let Some(part) = parts.next() {
                    let phases = &phases[part.behaviours.clone()];
                    $crate::office::Module::command(&mut self.$field, mode, phases, commands);
                })+
            }

            fn step(
                &mut self,
                now: &$crate::office::Moment<'_>,
                position: &mut $crate::office::Position,
                tell: &mut $crate::office::Telling<'_>,
            ) -> ::std::option::Option<$crate::office::Velocity> {
                let (mut parts, mut wanted) = (self.layout.parts(), None);
                $(if let Some(part) = parts.next() {
                    let now = now.of(part);
                    let work = $crate::office::Module::step(&mut self.$field, &now, position, &mut tell.of(part));
                    wanted = work.or(wanted);
                })+
                wanted
            }

            fn publish(
                &mut self,
                now: &$crate::office::Moment<'_>,
                position: &$crate::office::Position,
                tell: &mut $crate::office::Telling<'_>,
            ) {
                let mut parts = self.layout.parts();
                $(if let Some(part) = parts.next() {
                    $crate::office::Module::publish(&mut self.$field, &now.of(part), position, &mut tell.of(part));
                })+
            }

            fn publish_position(
                &mut self,
                model: &$crate::office::OfficeModel,
                position: &$crate::office::Position,
                tell: &mut $crate::office::Telling<'_>,
            ) {
                let mut parts = self.layout.parts();
                $(if let Some(part) = parts.next() {
                    $crate::office::Module::publish_position(&mut self.$field, model, position, &mut tell.of(part));
                })+
            }

            fn bytes_apart(&self, earlier: &Self) -> usize {
                0 $(+ $crate::office::Module::bytes_apart(&self.$field, &earlier.$field))+
            }

            fn part(&mut self, of: ::std::any::TypeId) -> ::std::option::Option<&mut dyn ::std::any::Any> {
                $(if let Some(part) = $crate::office::Module::part(&mut self.$field, of) {
                    return Some(part);
                })+
                None
            }
        }
    };
}

/// A list of modules and what they offer together; made once, shared by all runs.
pub struct Composition<M: Module> {
    /// What was set about them.
    pub settings: M::Settings,
    /// What plans see of the robot.
    pub tables: RobotTables,
    /// Functions that plans can call.
    pub functions: Vec<Native>,
    /// Plans, in the order in which they are read.
    pub plans: Vec<PlanText>,
    /// How behaviours go in projections, by their numbers, as far as modules declare it.
    pub models: BTreeMap<u16, Arc<ActModel>>,
}

/// Two modules offer something of the same name, or a behaviour needs a valve that none has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum NameTaken {
    /// The same name twice.
    #[error("`{name}` of the module `{second}` has a meaning already: the module `{first}` has one of that name")]
    Twice {
        /// The name.
        name: String,
        /// The module that has it first.
        first: String,
        /// The module that wants it as well.
        second: String,
    },
    /// A valve that is not there.
    #[error("the behaviour `{behaviour}` of the module `{module}` needs the valve `{valve}`, and no module has it")]
    NoValve {
        /// The behaviour.
        behaviour: String,
        /// Its module.
        module: String,
        /// The valve.
        valve: String,
    },
}

impl<M: Module> Composition<M> {
    /// What the modules offer together.
    ///
    /// # Errors
    /// They do not fit together.
    pub fn new(settings: M::Settings) -> Result<Arc<Self>, NameTaken> {
        let specs = M::specs(&settings);
        let mut owners: BTreeMap<&str, &str> = BTreeMap::new();
        for spec in &specs {
            let behaviours = spec.behaviours.iter().map(|behaviour| &*behaviour.name);
            let fluents = spec.fluents.iter().map(|fluent| &*fluent.name);
            let functions = spec.functions.iter().map(|function| function.name);
            let valves = spec.valves.iter().map(|valve| &**valve);
            for name in behaviours.chain(fluents).chain(functions).chain(valves) {
                if let Some(first) = owners.insert(name, &spec.name) {
                    let [name, first, second] = [name, first, &*spec.name].map(str::to_string);
                    return Err(NameTaken::Twice { name, first, second });
                }
            }
        }
        let mut tables = RobotTables::default();
        tables.valves.extend(specs.iter().flat_map(|spec| &spec.valves).cloned());
        for spec in &specs {
            for BehaviourSpec { name, valve, .. } in &spec.behaviours {
                if let Some(valve) = valve.as_ref().filter(|valve| !tables.valves.contains(valve)) {
                    let [behaviour, module, valve] = [name, &spec.name, valve].map(|name| name.to_string());
                    return Err(NameTaken::NoValve { behaviour, module, valve });
                }
            }
        }
        let (mut functions, mut plans, mut models) = (Vec::new(), Vec::new(), BTreeMap::new());
        for spec in specs {
            let first = tables.behaviours.len();
            models.extend(spec.models.into_iter().map(|(place, model)| ((first + place) as u16, Arc::new(model))));
            tables.behaviours.extend(spec.behaviours);
            tables.fluents.extend(spec.fluents);
            functions.extend(spec.functions);
            plans.extend(spec.plans);
        }
        Ok(Arc::new(Self { settings, tables, functions, plans, models }))
    }
}
