//! What plans and scenarios can call: native functions, the prelude, and the plans of the robot.
//!
//! The library of plans without a robot is kept compiled (`compiled_library`), so that no process begins with compiling
//! it; a test compares it with the texts. Every other library is compiled where it is needed.

use crate::error::SiteError;
use crate::modules::{self, own_modules};
use rpl_lang::compile::{Names, NamesElsewhere, NoFiles, TextKind, special_forms};
use rpl_robot::office::{self, Composition, Module, PlanText};
use rpl_runtime::robot::RobotTables;
use rpl_runtime::run::library::{Library, Loaded};
use rpl_runtime::step::native::Native;
use std::sync::{Arc, LazyLock};

/// The native functions of the language: those of the runtime and of its library.
pub fn base_natives() -> Vec<Native> {
    [rpl_runtime::step::natives::natives(), rpl_stdlib::natives()].concat()
}

/// All native functions of plans on a robot, with their documentation.
pub fn natives() -> Vec<Native> {
    [base_natives(), modules::natives()].concat()
}

/// What plans without a robot can call, and these native functions. The names of the robot are known
/// as such: a plan that has one is told that it needs a world.
///
/// # Errors
/// One of them has a name that is taken, or the prelude does not compile.
pub fn library_without_robot(own: Vec<Native>) -> Result<Arc<Library>, SiteError> {
    robotless_library(own_modules(), own)
}

/// What plans without a robot can call, as [`Library::compiled`]; a test compares it with what the texts compile to.
const COMPILED: &[u8] = include_bytes!("compiled_library");

/// The same where the robot, if there were one, would have these modules.
pub(crate) fn robotless_library<M: Module>(
    modules: &Arc<Composition<M>>,
    own: Vec<Native>,
) -> Result<Arc<Library>, SiteError> {
    let modules = modules.clone();
    let robot_names: Names = LazyLock::new(Box::new(move || modules.robot_names()));
    let compile = |natives: Vec<Native>| match Library::read_back(COMPILED, &natives, &[PRELUDE]) {
        Some(library) => Ok(library),
        None => compile(natives, RobotTables::EMPTY, &[]),
    };
    plan_library(base_natives(), own, compile, robot_names)
}

/// What plans can call where there are these modules and no robot. The names of our robot that they leave free are known
/// as such.
///
/// # Errors
/// As for [`robot_library`].
pub(crate) fn modules_library<M: Module>(
    modules: &Composition<M>,
    own: Vec<Native>,
) -> Result<Arc<Library>, SiteError> {
    let natives = [base_natives(), modules.functions.clone()].concat();
    let (reserved, theirs) = (modules.reserved_names(), modules.robot_names());
    let robot_names: Names = LazyLock::new(Box::new(move || {
        let of_robot = own_modules().robot_names().into_iter().filter(|name| !theirs.contains(name));
        of_robot.chain(reserved).collect()
    }));
    plan_library(natives, own, |natives| compile(natives, &modules.tables, &modules.plans), robot_names)
}

/// What plans can call on a robot of these modules, and these native functions.
///
/// # Errors
/// One of them has a name that is taken, or the prelude does not compile.
pub fn robot_library<M: Module>(modules: &Composition<M>, own: Vec<Native>) -> Result<Arc<Library>, SiteError> {
    let natives = [base_natives(), modules.functions.clone()].concat();
    let robot_names = modules.reserved_names();
    let compile = |natives| compile(natives, &modules.tables, &modules.plans);
    plan_library(natives, own, compile, LazyLock::new(Box::new(|| robot_names)))
}

/// What the experimenter's plans can call.
///
/// # Errors
/// The prelude does not compile.
pub fn scenario_library() -> Result<Arc<Library>, SiteError> {
    let library = compile([base_natives(), office::oracle_natives()].concat(), office::oracle_tables(), &[])?;
    let of_plans = NamesElsewhere { kind: TextKind::Plan, names: own_modules().robot_names() };
    Ok(Arc::new(library.refusing_names(of_plans)))
}

fn plan_library(
    natives: Vec<Native>,
    own: Vec<Native>,
    compile: impl FnOnce(Vec<Native>) -> Result<Library, SiteError>,
    robot_names: Names,
) -> Result<Arc<Library>, SiteError> {
    let names: Vec<&'static str> = own.iter().map(|native| native.name).collect();
    let is_native = |(at, name): (usize, &&'static str)| {
        names[..at].contains(name) || natives.iter().any(|native| native.name == *name)
    };
    if let Some((_, name)) = names.iter().enumerate().find(|&named| is_native(named)) {
        return Err(SiteError::NativeTaken(name));
    }
    let library = compile([natives, own].concat())?;
    if let Some(name) = names.into_iter().find(|name| is_defined(&library, name)) {
        return Err(SiteError::NativeTaken(name));
    }
    let library = library.knowing_robot_names(robot_names);
    let of_scenarios = NamesElsewhere { kind: TextKind::Scenario, names: office::scenario_names() };
    Ok(Arc::new(library.refusing_names(of_scenarios)))
}

/// Whether a name has a meaning in a library.
pub(crate) fn is_taken(library: &Library, name: &str) -> bool {
    library.natives.iter().any(|native| native.name == name) || is_defined(library, name)
}

/// Whether a name has a meaning that comes before that of a native function: it would never be called.
fn is_defined(library: &Library, name: &str) -> bool {
    // A text without forms compiles to nothing but the library.
    let Ok(Loaded { program, symbols, .. }) = library.load("", "", &mut NoFiles) else { return false };
    let is_global = |name| program.names.contains_key(&name) || program.macros.contains_key(&name);
    symbols.find(name).is_some_and(is_global) || special_forms().any(|form| form.names.contains(&name))
}

fn compile(natives: Vec<Native>, tables: &RobotTables, plans: &[PlanText]) -> Result<Library, SiteError> {
    let preludes: Vec<(&str, &str)> =
        [PRELUDE].into_iter().chain(plans.iter().map(|plan| (&*plan.name, &*plan.text))).collect();
    Library::new(natives, &preludes, tables).map_err(SiteError::Prelude)
}

const PRELUDE: (&str, &str) = ("prelude", rpl_stdlib::PRELUDE);

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_runtime::state::value::Value;
    use rpl_runtime::step::native::{Effect, NativeCode, Reply};

    fn native(name: &'static str) -> Native {
        let code = NativeCode::Plain(|_| Ok(Reply::Value(Value::Nil)));
        Native { name, parameters: "", doc: "It does nothing.", effect: Effect::None, code }
    }

    #[test]
    #[expect(clippy::disallowed_methods, reason = "the file of the repository is what is tested")]
    fn the_library_that_is_read_back_is_the_one_that_is_compiled() {
        let Ok(library) = compile(base_natives(), RobotTables::EMPTY, &[]) else { panic!("the prelude compiles") };
        if std::env::var_os("WRITE_LIBRARY").is_some() {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/compiled_library");
            std::fs::write(path, library.compiled()).expect("the file can be written");
            return;
        }
        assert!(
            library.compiled() == COMPILED,
            "the library compiles to something else; `WRITE_LIBRARY=1 cargo test -p rpl-mission library` writes it anew"
        );
        let read_back = Library::read_back(COMPILED, &base_natives(), &[PRELUDE]).expect("it is of the same texts");
        assert_eq!(read_back.names(), library.names());
        // Of another text, or with another function beside, it is not.
        assert!(Library::read_back(COMPILED, &base_natives(), &[("prelude", "")]).is_none());
        let more = [base_natives(), vec![native("of-mine")]].concat();
        assert!(Library::read_back(COMPILED, &more, &[PRELUDE]).is_none());
    }

    #[test]
    fn a_function_of_the_program_takes_no_name_that_has_a_meaning() {
        assert!(robot_library(own_modules(), vec![native("of-mine"), native("of-mine-too")]).is_ok());
        let taken = |natives: Vec<Native>| match robot_library(own_modules(), natives) {
            Err(SiteError::NativeTaken(name)) => name,
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("there are two of a name"),
        };
        for name in ["car", "place", "map", "go-to", "x*", "when", "if"] {
            assert_eq!(taken(vec![native("of-mine"), native(name)]), name);
        }
        assert_eq!(taken(vec![native("of-mine"), native("of-mine")]), "of-mine");
    }
}
