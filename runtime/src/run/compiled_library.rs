//! A library as bytes: what its texts were compiled to, so that a process begins without compiling them.
//!
//! The bytes are a function of the texts, the native functions and the compiler. They begin with a fingerprint of the
//! first two and of the format; bytes that were made of others are not read. That they are what the compiler makes is for
//! whoever keeps them to see to, by a test that compiles the texts and compares.

use crate::robot::{RobotGlobals, RobotTables};
use crate::run::library::Library;
use crate::run::save::{VERSION, append};
use crate::step::native::Native;
use rpl_lang::code::Program;
use rpl_lang::compile::{Resolved, no_names};
use rpl_lang::source::{SourceId, Sources};
use rpl_lang::symbol::Symbols;
use std::sync::{Arc, OnceLock};

/// Tells apart what libraries without a robot are made of.
fn fingerprint(natives: &[Native], preludes: &[(&str, &str)]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&VERSION.to_le_bytes());
    for native in natives {
        for part in [native.name, "\n", native.parameters, "\n"] {
            hasher.update(part.as_bytes());
        }
        hasher.update(&[native.effect as u8]);
    }
    for (name, text) in preludes {
        for part in [name, "\n", text, "\0"] {
            hasher.update(part.as_bytes());
        }
    }
    hasher.finalize()
}

impl Library {
    /// A library without a robot as bytes, from which [`Library::read_back`] makes it again.
    pub fn compiled(&self) -> Vec<u8> {
        let texts = self.texts();
        // They are at hand where the bytes are read.
        let program = Program { sources: Sources::default(), ..self.program.clone() };
        append(fingerprint(&self.natives, &texts).to_le_bytes().to_vec(), &(program, &self.symbols))
    }

    /// The library without a robot that compiling these texts over these native functions gives, if the bytes are
    /// [`Library::compiled`] of one that was made of the same.
    pub fn read_back(compiled: &[u8], natives: &[Native], preludes: &[(&str, &str)]) -> Option<Self> {
        let (made_of, rest) = compiled.split_first_chunk()?;
        if u32::from_le_bytes(*made_of) != fingerprint(natives, preludes) {
            return None;
        }
        let (mut program, symbols): (Program, Symbols) = postcard::from_bytes(rest).ok()?;
        for (name, text) in preludes {
            program.sources.add(name, text);
        }
        Some(Self {
            natives: natives.into(),
            signatures: natives.iter().map(Native::signature).collect(),
            program,
            symbols,
            robot_names: Arc::new(no_names()),
            names_elsewhere: Arc::default(),
            robot: Arc::new(RobotGlobals::default()),
            behaviours: Arc::default(),
            resolved: Arc::default(),
        })
    }

    fn texts(&self) -> Vec<(&str, &str)> {
        let sources = (0..self.program.sources.len()).map(|number| self.program.sources.get(SourceId(number as u32)));
        sources.map(|source| (&*source.name, &*source.text)).collect()
    }

    /// What the texts were resolved to.
    pub(super) fn resolved(&self) -> &[Resolved] {
        self.resolved.get_or_init(|| {
            // Only one that was read back does not have it, and that has no robot.
            match Self::new(self.natives.to_vec(), &self.texts(), RobotTables::EMPTY) {
                Ok(library) => Arc::into_inner(library.resolved).and_then(OnceLock::into_inner).unwrap_or_default(),
                Err(rejected) => unreachable!("the texts were compiled before: {}", rejected.render(false)),
            }
        })
    }
}
