//! The robot and the native functions generated programs use.

use rpl_lang::symbol::Symbol;
use rpl_mission::libraries::base_natives;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, Ending, FluentSpec, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::run::library::Library;
use rpl_runtime::run::save::SaveOutside;
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::output::Channel;
use rpl_runtime::state::task::ScopeKind;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::NativeCode::Plain;
use rpl_runtime::step::native::{Call, Effect, Native, Reply};
use std::sync::{Arc, LazyLock, OnceLock};

/// A robot that does nothing for a reason: each step is a function of how many there were.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Whim {
    /// Microseconds between two steps; none if it stands still.
    pub period_us: Option<u64>,
    /// Steps and commands so far.
    pub turns: u64,
    /// Behaviours at work.
    pub active: [bool; 2],
}

impl Whim {
    fn draw(&mut self) -> u64 {
        self.turns += 1;
        let mut bits = self.turns.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits ^ (bits >> 31)
    }
}

static TABLES: LazyLock<RobotTables> = LazyLock::new(|| {
    let behaviour = |name: &'static str, doc: &'static str, valve: Option<&'static str>| BehaviourSpec {
        name: name.into(),
        doc: doc.into(),
        valve: valve.map(Into::into),
        parameters: "".into(),
    };
    let fluent = |name: &'static str, doc: &'static str| FluentSpec {
        name: name.into(),
        doc: doc.into(),
        continuous: false,
        first: None,
    };
    RobotTables {
        behaviours: vec![behaviour("drive", "Drives.", Some("wheels")), behaviour("look", "Looks.", None)],
        fluents: vec![
            fluent("level*", "A number from 0 to 3."),
            fluent("bump*", "Sometimes true."),
            fluent("active*", "Whether something is at work."),
        ],
        valves: vec!["wheels".into()],
    }
});

impl Outside for Whim {
    fn tables(&self) -> &RobotTables {
        &TABLES
    }

    fn start(
        &mut self,
        _machine: &Machine,
        behaviour: u16,
        _arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        if self.draw().is_multiple_of(8) {
            return Err(Raise::new("behaviour-failure", "it does not start"));
        }
        self.active[usize::from(behaviour)] = true;
        outbox.fluents.push((2, Reading::Truth(true)));
        Ok(())
    }

    fn stop(&mut self, behaviour: u16, _how: StopReason, outbox: &mut Outbox) {
        self.active[usize::from(behaviour)] = false;
        outbox.fluents.push((2, Reading::Truth(self.active[0] || self.active[1])));
    }

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        self.period_us.map(|period_us| stepped_us + period_us)
    }

    fn step(&mut self, _: u64, _: Phases<'_>, outbox: &mut Outbox) {
        let drawn = self.draw();
        outbox.fluents.push((0, Reading::Int((drawn & 3) as i64)));
        outbox.fluents.push((1, Reading::Truth(drawn & 0x30 == 0)));
        for behaviour in 0..2 {
            if self.active[usize::from(behaviour)] && (drawn >> (8 + 4 * behaviour)) & 3 == 0 {
                self.active[usize::from(behaviour)] = false;
                let ending =
                    if drawn & 0x1_0000 == 0 { Ending::DONE } else { Ending::failure("behaviour-failure", "a whim") };
                outbox.endings.push((behaviour, ending));
            }
        }
        outbox.fluents.push((2, Reading::Truth(self.active[0] || self.active[1])));
    }
}

impl SaveOutside for Whim {
    fn save(&self, bytes: Vec<u8>) -> Vec<u8> {
        let period = self.period_us.unwrap_or(0).to_le_bytes();
        let flags = [u8::from(self.active[0]), u8::from(self.active[1])];
        [&bytes, &period[..], &self.turns.to_le_bytes(), &flags].concat()
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (Ok(period), Ok(turns), [first, second]) = (
            bytes.get(..8).unwrap_or_default().try_into().map(u64::from_le_bytes),
            bytes.get(8..16).unwrap_or_default().try_into().map(u64::from_le_bytes),
            bytes.get(16..).unwrap_or_default(),
        ) else {
            return Err("a whim has 18 bytes".into());
        };
        *self = Self { period_us: (period > 0).then_some(period), turns, active: [*first != 0, *second != 0] };
        Ok(())
    }
}

fn say(call: &mut Call<'_, '_>, what: &str, entry: i64) -> Result<Reply, Raise> {
    let task = call.task();
    call.machine.put_out(Channel::Print, format!("{what} {entry} {} {}", task.index, task.generation));
    Ok(Reply::Value(Value::Int(entry)))
}

/// A clean-up begins when nothing of its part is left: its scope is the innermost, and no child of
/// the part lives.
fn is_alone(call: &Call<'_, '_>) -> bool {
    let task = call.task().index;
    let scopes = &call.machine.tasks[task].scopes;
    let is_innermost = scopes.last().is_some_and(|scope| matches!(scope.kind, ScopeKind::InCleanup(_)));
    let is_hook = |child: u32| call.machine.tasks[child].rare.as_ref().is_some_and(|rare| rare.hooks_for.is_some());
    let children = call.machine.children(task);
    is_innermost
        && children
            .iter()
            .all(|&child| is_hook(child) || (call.machine.tasks[child].parent_scope as usize) < scopes.len() - 1)
}

const NATIVES: &[Native] = &[
    Native {
        name: "%note-enter",
        parameters: "entry",
        doc: "A part with a clean-up is entered.",
        effect: Effect::Acts,
        code: Plain(|call| {
            let entry = call.integer(0)?;
            say(call, "enter", entry)
        }),
    },
    Native {
        name: "note-clean",
        parameters: "entry",
        doc: "The clean-up of a part runs.",
        effect: Effect::Acts,
        code: Plain(|call| {
            let entry = call.integer(0)?;
            let what = if is_alone(call) { "clean" } else { "early" };
            say(call, what, entry)
        }),
    },
    Native {
        name: "note-pass",
        parameters: "entry",
        doc: "A part has succeeded and needs no clean-up.",
        effect: Effect::Acts,
        code: Plain(|call| {
            let entry = call.integer(0)?;
            say(call, "pass", entry)
        }),
    },
    Native {
        name: "note",
        parameters: "value",
        doc: "Writes a value into the output.",
        effect: Effect::Acts,
        code: Plain(|call| {
            let text = call.machine.show(call.around.program, call.argument(0));
            call.machine.put_out(Channel::Print, format!("note {text}"));
            Ok(Reply::Value(Value::Nil))
        }),
    },
];

/// The library of generated programs, compiled once.
pub fn library() -> &'static Arc<Library> {
    static LIBRARY: OnceLock<Arc<Library>> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let natives = [base_natives(), NATIVES.to_vec()].concat();
        match Library::new(natives, &[("prelude", rpl_stdlib::PRELUDE)], &TABLES) {
            Ok(library) => Arc::new(library),
            Err(rejected) => panic!("the library does not compile:\n{}", rejected.render(false)),
        }
    })
}
