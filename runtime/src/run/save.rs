//! Saved runs: a run written down byte for byte, and read back where the same program is compiled.
//!
//! A saved run holds what changes: the machine, the robot's state, and the code made at run time.
//! The program it started from is not in it, only a fingerprint: whoever loads it compiles the same
//! text again. The bytes are a function of the state: equal states give equal bytes, and the bytes
//! of a loaded run are those it was loaded from.
//!
//! The checksum finds accidents; it is no guard against bytes that were forged with care.
//!
//! Layout: `RPLSAVE`, then little-endian u32: version, fingerprint of the program, checksum of the
//! rest; the rest is [`postcard`], and behind it what the robot added.

use crate::robot::{NoRobot, Outside};
use crate::run::base::Base;
use crate::run::difference::{Difference, difference};
use crate::run::library::{Library, Loaded};
use crate::run::macro_host::Macros;
use crate::run::system::{SLICE_STEPS, System};
use crate::run::units::Units;
use crate::run::validate::{Bounds, validate_program};
use crate::state::machine::Machine;
use postcard::ser_flavors::Flavor;
use rpl_lang::code::{Code, Constant, FailureClass, Global, Program};
use rpl_lang::source::{Source, SourceId};
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

const MAGIC: &[u8; 7] = b"RPLSAVE";

/// Of the layout and of everything in it; any change to a saved type needs a new one.
pub(super) const VERSION: u32 = 35;

const HEADER: usize = MAGIC.len() + 3 * size_of::<u32>();

/// A robot whose state can be written down. What never changes – maps, models – is not part of it:
/// `load` fills a robot that was built anew.
pub trait SaveOutside: Outside {
    /// Adds what changes to the bytes; [`append`] is what most need.
    fn save(&self, bytes: Vec<u8>) -> Vec<u8>;

    /// Takes over what [`SaveOutside::save`] added.
    ///
    /// # Errors
    /// One sentence on why the bytes do not fit this robot.
    fn load(&mut self, bytes: &[u8]) -> Result<(), String>;
}

impl SaveOutside for NoRobot {
    fn save(&self, bytes: Vec<u8>) -> Vec<u8> {
        bytes
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        if bytes.is_empty() { Ok(()) } else { Err("the run was saved with a robot, and there is none".into()) }
    }
}

/// Why bytes cannot be read as a saved run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SaveError {
    /// They do not begin as a saved run does.
    Foreign,
    /// They were written by another version of this program.
    Version(u32),
    /// They belong to another program.
    Program,
    /// They were changed or cut off.
    Damaged,
    /// They were written, but not by a run: something in them names what is not there.
    Inconsistent(String),
    /// The robot cannot take its part.
    Outside(String),
}

impl fmt::Display for SaveError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SaveError::Foreign => write!(out, "this is not a saved run: it does not begin with `RPLSAVE`"),
            SaveError::Version(found) => {
                write!(out, "the run was saved in format {found}, and this program reads format {VERSION}")
            }
            SaveError::Program => {
                write!(out, "the run was saved from another program: its text, library or robot is not the same")
            }
            SaveError::Damaged => write!(out, "the saved run is damaged: its bytes were changed or cut off"),
            SaveError::Inconsistent(why) => write!(out, "the saved run is damaged: {why}"),
            SaveError::Outside(why) => write!(out, "the robot cannot be restored: {why}"),
        }
    }
}

impl std::error::Error for SaveError {}

impl Base {
    /// Tells programs apart.
    fn fingerprint(&self, library: &Library) -> u32 {
        *self.fingerprint.get_or_init(|| {
            let mut hasher = crc32fast::Hasher::new();
            hasher.update(&append(Vec::new(), &*self.program));
            for native in library.natives.iter() {
                hasher.update(native.name.as_bytes());
                hasher.update(b"\n");
            }
            hasher.finalize()
        })
    }
}

/// What was added to a program since its start.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
struct Addition {
    codes: Vec<Arc<Code>>,
    constants: Vec<Constant>,
    globals: Vec<Global>,
    sources: Vec<Source>,
    free: (Vec<u32>, Vec<u32>, Vec<u32>, u32),
    /// Whole, if it is not what it was.
    names: Option<BTreeMap<Symbol, u32>>,
    macros: Option<BTreeMap<Symbol, u32>>,
    failure_classes: Option<BTreeMap<Symbol, FailureClass>>,
    resumptions: Option<Vec<Symbol>>,
    units: Units,
}

fn changed<T: Clone + PartialEq>(base: &T, now: &T) -> Option<T> {
    (base != now).then(|| now.clone())
}

impl Addition {
    fn between(base: &Arc<Program>, now: &Arc<Program>, units: &Units) -> Self {
        if Arc::ptr_eq(base, now) {
            return Self::default();
        }
        let sources = base.sources.len()..now.sources.len();
        Self {
            codes: now.codes[base.codes.len()..].to_vec(),
            constants: now.constants[base.constants.len()..].to_vec(),
            globals: now.globals[base.globals.len()..].to_vec(),
            sources: sources.map(|number| now.sources.get(SourceId(number as u32)).clone()).collect(),
            free: (
                now.free_codes.clone(),
                now.free_constants.clone(),
                now.sources.free_places().to_vec(),
                now.sources.made(),
            ),
            names: changed(&base.names, &now.names),
            macros: changed(&base.macros, &now.macros),
            failure_classes: changed(&base.failure_classes, &now.failure_classes),
            resumptions: changed(&base.resumptions, &now.resumptions),
            units: units.clone(),
        }
    }

    fn add_to(self, base: &Arc<Program>) -> (Arc<Program>, Units) {
        if self == Self::default() {
            return (base.clone(), Units::default());
        }
        let mut program = Program::clone(base);
        program.codes.extend(self.codes);
        program.constants.extend(self.constants);
        program.globals.extend(self.globals);
        for source in &self.sources {
            program.sources.add(&source.name, &source.text);
        }
        let (codes, constants, sources, made) = self.free;
        (program.free_codes, program.free_constants) = (codes, constants);
        program.sources.restore(sources, made);
        program.names = self.names.unwrap_or(program.names);
        program.macros = self.macros.unwrap_or(program.macros);
        program.failure_classes = self.failure_classes.unwrap_or(program.failure_classes);
        program.resumptions = self.resumptions.unwrap_or(program.resumptions);
        (Arc::new(program), self.units)
    }
}

/// Where a value is written behind what is there. A robot's state is tens of megabytes while it is lost, and is written
/// to its place at once.
struct Behind(Vec<u8>);

impl Flavor for Behind {
    type Output = Vec<u8>;

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.0.push(byte);
        Ok(())
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.0.extend_from_slice(bytes);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<Vec<u8>> {
        Ok(self.0)
    }
}

/// The bytes, and a value behind them.
///
/// # Panics
/// The value cannot be written: nothing that is saved may be like that, and all lengths are known.
pub fn append(bytes: Vec<u8>, value: &(impl Serialize + ?Sized)) -> Vec<u8> {
    match postcard::serialize_with_flavor(value, Behind(bytes)) {
        Ok(bytes) => bytes,
        Err(error) => unreachable!("a saved type cannot be written: {error}"),
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[at..at + 4]);
    u32::from_le_bytes(word)
}

/// What is behind the header begins with this, whatever the robot.
type Payload = (Addition, Machine, u64);

/// What was read of a run beside its robot.
struct RunRead {
    base: Base,
    program: Arc<Program>,
    units: Units,
    machine: Machine,
    stepped_us: u64,
}

impl RunRead {
    /// The run that [`System::save`] has written, its robot's part taken over by `outside`. Compiled once, as it knows
    /// no type of robots.
    fn read(
        bytes: &[u8],
        library: &Library,
        base: Arc<Program>,
        outside: &mut dyn SaveOutside,
    ) -> Result<Self, SaveError> {
        if !bytes.starts_with(MAGIC) {
            return Err(SaveError::Foreign);
        }
        if bytes.len() < HEADER {
            return Err(SaveError::Damaged);
        }
        let version = word(bytes, MAGIC.len());
        if version != VERSION {
            return Err(SaveError::Version(version));
        }
        let payload = &bytes[HEADER..];
        if word(bytes, HEADER - 4) != crc32fast::hash(payload) {
            return Err(SaveError::Damaged);
        }
        let base = Base::new(base);
        if word(bytes, HEADER - 8) != base.fingerprint(library) {
            return Err(SaveError::Program);
        }
        let ((addition, machine, stepped_us), robot) =
            postcard::take_from_bytes::<Payload>(payload).map_err(|_| SaveError::Damaged)?;
        outside.load(robot).map_err(SaveError::Outside)?;
        let (program, units) = addition.add_to(&base.program);
        let bounds =
            Bounds { program: &program, natives: library.natives.len(), behaviours: outside.tables().behaviours.len() };
        validate_program(&program, base.program.codes.len())
            .and_then(|()| machine.validate(&bounds))
            .and_then(|()| machine.check_invariants())
            .map_err(SaveError::Inconsistent)?;
        Ok(Self { base, program, units, machine, stepped_us })
    }
}

/// What is saved of a run before its robot, with room for the checksum. Compiled once, as it knows no type of robots.
fn before_robot(addition: Addition, machine: &Machine, stepped_us: u64, fingerprint: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + machine.used_bytes());
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&fingerprint.to_le_bytes());
    bytes.extend_from_slice(&[0; 4]);
    append(bytes, &(addition, machine, stepped_us))
}

impl<O: SaveOutside> System<O> {
    fn addition(&self) -> Addition {
        Addition::between(&self.base.program, &self.program, &self.units)
    }

    /// The run as bytes. Cost: proportional to the state.
    pub fn save(&self) -> Vec<u8> {
        let fingerprint = self.base.fingerprint(&self.library);
        let mut bytes = self.outside.save(before_robot(self.addition(), &self.machine, self.stepped_us, fingerprint));
        let checksum = crc32fast::hash(&bytes[HEADER..]);
        bytes[HEADER - 4..HEADER].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// The first part in which two runs of one program differ, by its path, such as
    /// `machine.tasks[17].registers[3]`; none if they are saved alike.
    pub fn difference(&self, other: &Self) -> Option<Difference> {
        difference("machine", &self.machine, &other.machine)
            .or_else(|| difference("program", &self.addition(), &other.addition()))
            .or_else(|| difference("stepped_us", &self.stepped_us, &other.stepped_us))
            .or_else(|| difference("robot", &self.outside.save(Vec::new()), &other.outside.save(Vec::new())))
    }

    /// A run read from bytes. `loaded` is the same program, compiled again with the same library;
    /// `outside` is the same robot, built anew.
    ///
    /// # Errors
    /// Says what is wrong with the bytes.
    pub fn load(bytes: &[u8], library: Arc<Library>, loaded: Loaded, mut outside: O) -> Result<Self, SaveError> {
        let RunRead { base, program, units, machine, stepped_us } =
            RunRead::read(bytes, &library, loaded.program, &mut outside)?;
        Ok(Self {
            program,
            units: Arc::new(units),
            machine,
            outside,
            library,
            base: Arc::new(base),
            stepped_us,
            slice_steps: SLICE_STEPS,
            slice_left: SLICE_STEPS,
            macros: Macros::default(),
        })
    }
}
