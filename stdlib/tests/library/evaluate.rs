//! Plan text in, printed value out.

use rpl_runtime::robot::RobotTables;
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Progress, System};
use std::sync::{Arc, LazyLock};

static LIBRARY: LazyLock<Arc<Library>> = LazyLock::new(|| {
    let mut natives = rpl_stdlib::natives();
    natives.extend(rpl_runtime::step::natives::natives());
    let preludes = [("prelude.rpl", rpl_stdlib::PRELUDE)];
    match Library::new(natives, &preludes, RobotTables::EMPTY, &[]) {
        Ok(library) => Arc::new(library),
        Err(rejected) => panic!("{}", rejected.render(false)),
    }
});

/// The library under test.
pub fn library() -> &'static Arc<Library> {
    &LIBRARY
}

/// The value of a text as it could be read, or its failure as `class: message`.
///
/// # Errors
/// The failure, or the drawn errors of the text.
pub fn evaluate(text: &str) -> Result<String, String> {
    let mut system = System::without_robot(library(), "test", text, 0).map_err(|rejected| rejected.render(false))?;
    while system.advance() == Progress::Running {}
    system.with_machine(|machine, around| match machine.tasks[machine.main].state() {
        rpl_runtime::state::task::State::Succeeded => {
            Ok(machine.write(around.program, machine.tasks[machine.main].value))
        }
        _ => Err(machine.show(around.program, machine.tasks[machine.main].value)),
    })
}

/// Checks a table of expressions and the values they print, and names every line that differs.
#[track_caller]
pub fn check(table: &[(&str, &str)]) {
    let wrong: Vec<String> = table
        .iter()
        .filter_map(|&(text, expected)| match evaluate(text) {
            Ok(value) if value == expected => None,
            Ok(value) => Some(format!("{text}\n  gives {value}\n  not   {expected}")),
            Err(failure) => Some(format!("{text}\n  fails: {failure}")),
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Checks a table of expressions and what their failures say.
#[track_caller]
pub fn check_failures(table: &[(&str, &str)]) {
    let wrong: Vec<String> = table
        .iter()
        .filter_map(|&(text, expected)| match evaluate(text) {
            Err(failure) if failure.contains(expected) => None,
            Err(failure) => Some(format!("{text}\n  fails: {failure}\n  not:   {expected}")),
            Ok(value) => Some(format!("{text}\n  gives {value}\n  and should fail: {expected}")),
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
