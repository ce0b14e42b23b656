//! Plan text in, printed value out.

use rpl_runtime::robot::RobotTables;
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Progress, System};
use std::sync::{Arc, LazyLock};

static LIBRARY: LazyLock<Arc<Library>> =
    LazyLock::new(|| library_with(&[]).unwrap_or_else(|faults| panic!("{faults}")));

/// The library under test.
pub fn library() -> &'static Arc<Library> {
    &LIBRARY
}

/// The same with further texts behind it.
///
/// # Errors
/// The drawn errors of the texts.
pub fn library_with(texts: &[(&str, &str)]) -> Result<Arc<Library>, String> {
    let mut natives = rpl_stdlib::natives();
    natives.extend(rpl_runtime::step::natives::natives());
    let preludes = [&[("prelude.rpl", rpl_stdlib::PRELUDE)], texts].concat();
    let library = Library::new(natives, &preludes, RobotTables::EMPTY);
    library.map(Arc::new).map_err(|rejected| rejected.render(false))
}

/// The value of a text as it could be read, or its failure as `class: message`.
///
/// # Errors
/// The failure, or the drawn errors of the text.
pub fn evaluate(text: &str) -> Result<String, String> {
    evaluate_in(library(), text)
}

/// The same in another library.
///
/// # Errors
/// As [`evaluate`].
pub fn evaluate_in(library: &Arc<Library>, text: &str) -> Result<String, String> {
    let mut system = System::without_robot(library, "test", text, 0).map_err(|rejected| rejected.render(false))?;
    while system.advance() == Progress::Running {}
    system.with_machine(|machine, around| match machine.tasks[machine.main].state() {
        rpl_runtime::state::task::State::Succeeded => {
            Ok(machine.write(around.program, *machine.tasks[machine.main].value()))
        }
        _ => Err(machine.show(around.program, *machine.tasks[machine.main].value())),
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
