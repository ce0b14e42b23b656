//! A module of the tests: a manifest, a script that plays it, and a robot that stands still.

use rpl_lang::code::Program;
use rpl_lang::symbol::Symbols;
use rpl_link::process_module::{ModuleProcess, StartError};
use rpl_link::transcript::{Kept, Transcript};
use rpl_protocol::line::Conversation;
use rpl_protocol::module::manifest::Manifest;
use rpl_protocol::module::message::Greeting;
use rpl_protocol::module::process_module::{News, ProcessModule};
use rpl_random::Stream;
use rpl_robot::geometry::Pose;
use rpl_robot::localization::Estimate;
use rpl_robot::sensors::FailedSensors;
use rpl_robot::simulator::{GripperMotion, GripperStatus, Percept};
use rpl_runtime::robot::Ending;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// What the plan sees of the module; a pace and a time limit stand before it.
const OFFERS: &str = r#"
name = "faulty"
doc = "A module that makes one mistake."
valves = ["lens"]

[[behaviour]]
name = "sweep"
doc = "Looks for cups."
parameters = [":area", ":times"]
valve = "lens"

[[behaviour]]
name = "rest"
doc = "Does nothing."

[[fluent]]
name = "light*"
doc = "How bright it is."
type = "number"

[[fluent]]
name = "cups*"
doc = "Cups in sight."
type = "integer"

[[fluent]]
name = "seen*"
doc = "What is in sight."
type = "list"

[[fluent]]
name = "near*"
doc = "The place it is near to."
type = "symbol"
"#;

const GREETING: Greeting = Greeting { period_us: 50_000, seed: 1 };

/// The module in a run of its own.
pub struct Played {
    /// The module as the run sees it.
    pub module: ProcessModule,
    machine: Machine,
    time_us: u64,
}

/// The manifest of the faulty module with a mode, and more keys.
pub fn manifest(mode: &str, keys: &str) -> Arc<Manifest> {
    let text = format!("command = [\"sh\", \"faulty.sh\", \"{mode}\"]\n{keys}\n{OFFERS}");
    Arc::new(Manifest::parse(&text, "faulty.toml").unwrap_or_else(|faults| panic!("{faults}")))
}

/// The process of a manifest, greeted.
pub fn process(manifest: &Arc<Manifest>) -> Result<ModuleProcess, StartError> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/process");
    ModuleProcess::start(manifest.clone(), &folder, GREETING)
}

/// Starts the module of a mode.
pub fn play(mode: &str, keys: &str) -> Result<Played, StartError> {
    let manifest = manifest(mode, keys);
    let line = Transcript::live("faulty", Box::new(process(&manifest)?), Kept::Newest(100), None);
    let module = ProcessModule::new(manifest, GREETING, Conversation::new(Arc::new(line)));
    let mut symbols = Symbols::default();
    for name in ["area", "times", "colour", "kitchen"] {
        symbols.intern(name);
    }
    let machine = Machine::new(&Program::default(), symbols, Stream::new(1, "plan"), Stream::new(1, "foresight"));
    Ok(Played { module, machine, time_us: 0 })
}

impl Played {
    /// A step of the robot.
    pub fn step(&mut self) -> News {
        self.time_us += 50_000;
        let percept = Percept {
            time_us: self.time_us,
            odometry_in_odom: Pose::default(),
            translation_mps: 0.0,
            rotation_radps: 0.0,
            sonar_m: None,
            laser_m: None,
            camera: None,
            failed: FailedSensors::default(),
            bumped: false,
            gripper: GripperStatus { motion: GripperMotion::Open, holding: None },
            battery: 1.0,
            messages: Vec::new(),
            others: BTreeMap::new(),
        };
        let estimate = Estimate { pose_in_map: Pose::default(), certainty: 1.0 };
        self.module.step(self.time_us, Some((estimate, &percept)))
    }

    /// The same run once more.
    pub fn copy(&self) -> Self {
        Self { module: self.module.clone(), machine: self.machine.clone(), time_us: self.time_us }
    }

    /// Starts `sweep` with the area `kitchen` and another argument.
    pub fn start_with(&mut self, key: &str, value: Value) -> Result<Option<Ending>, Raise> {
        let symbol = |name| self.machine.symbols.find(name).expect("it is known");
        let arguments = [(symbol("area"), Value::Symbol(symbol("kitchen"))), (symbol(key), value)];
        self.module.start(&self.machine, 0, &arguments, self.time_us)
    }

    /// Starts `sweep`.
    pub fn start(&mut self) -> Option<Ending> {
        self.start_with("times", Value::Int(2)).expect("its arguments are right")
    }
}

/// What is wrong with a module by a failure: its reason.
pub fn reason(ending: &Ending) -> &str {
    let Ending::Failure { class, message, slots } = ending else { panic!("it succeeded") };
    assert_eq!(class, "module-failure");
    let [(module, Reading::Text(name)), (reason, Reading::Text(why))] = slots.as_slice() else { panic!("{slots:?}") };
    assert_eq!((&**module, &**name, &**reason), ("module", "faulty", "reason"));
    assert_eq!(*message, format!("the module `faulty` {why}"));
    why
}
