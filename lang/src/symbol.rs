//! Interned names.

use foldhash::fast::FixedState;
use hashbrown::HashTable;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::hash::BuildHasher;
use std::sync::Arc;

/// A name, by its number in [`Symbols`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Symbol(pub u32);

/// Where a name is looked up that says so: `library:car`, `global:car`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Qualifier {
    /// In the library, whatever the text defines or binds.
    Library,
    /// At the top level of the program, whatever is bound around it.
    Global,
}

impl Qualifier {
    /// What stands in front of the name.
    pub const fn prefix(self) -> &'static str {
        match self {
            Qualifier::Library => "library:",
            Qualifier::Global => "global:",
        }
    }

    /// The qualifier of a name, and the name behind it; none if it has none.
    pub fn split(name: &str) -> Option<(Qualifier, &str)> {
        let split = |qualifier: Qualifier| Some((qualifier, name.strip_prefix(qualifier.prefix())?));
        split(Qualifier::Library).or_else(|| split(Qualifier::Global)).filter(|(_, base)| !base.is_empty())
    }
}

/// A name without its qualifier, if it has one.
pub fn base_name(name: &str) -> &str {
    Qualifier::split(name).map_or(name, |(_, base)| base)
}

/// The table of names of one program; append-only. Copies share it until one of them gets another name.
#[derive(Clone, Debug, Default)]
pub struct Symbols(Arc<Names>);

#[derive(Clone, Debug, Default)]
struct Names {
    names: Vec<Arc<str>>,
    /// Interned names only, by the hash of the name: an uninterned symbol is in `names` and not here.
    by_name: HashTable<Symbol>,
    /// Bytes of all names.
    bytes: usize,
}

/// What a name takes beside its text: its place in both tables, and the counters in front of it.
const BYTES_A_NAME: usize = 96;

impl Names {
    fn find(&self, of_name: u64, name: &str) -> Option<Symbol> {
        self.by_name.find(of_name, |symbol| *self.names[symbol.0 as usize] == *name).copied()
    }

    fn enter(&mut self, of_name: u64, symbol: Symbol) {
        let names = &self.names;
        self.by_name.insert_unique(of_name, symbol, |symbol| hash(&names[symbol.0 as usize]));
    }

    fn add(&mut self, name: Arc<str>) -> Symbol {
        self.bytes += BYTES_A_NAME + name.len();
        self.names.push(name);
        Symbol(self.names.len() as u32 - 1)
    }
}

impl Symbols {
    /// The symbol of this name, made if need be. The name is taken as it is: folding to lower
    /// case is the reader's work.
    pub fn intern(&mut self, name: &str) -> Symbol {
        let hash = hash(name);
        if let Some(symbol) = self.0.find(hash, name) {
            return symbol;
        }
        let names = Arc::make_mut(&mut self.0);
        let symbol = names.add(name.into());
        names.enter(hash, symbol);
        symbol
    }

    /// Bytes of all names.
    pub fn bytes(&self) -> usize {
        self.0.bytes
    }

    /// The symbol of this name, if there is one.
    pub fn find(&self, name: &str) -> Option<Symbol> {
        self.0.find(hash(name), name)
    }

    /// The symbol `library:NAME` or `global:NAME`.
    pub fn qualified(&mut self, qualifier: Qualifier, name: Symbol) -> Symbol {
        let written = format!("{}{}", qualifier.prefix(), self.name(name));
        self.intern(&written)
    }

    /// A new symbol that no text can name, printed as `#:stem12`.
    pub fn uninterned(&mut self, stem: &str) -> Symbol {
        let name = format!("{UNINTERNED}{stem}{}", self.len());
        Arc::make_mut(&mut self.0).add(name.into())
    }

    /// The name of a symbol of this table.
    pub fn name(&self, symbol: Symbol) -> &str {
        &self.0.names[symbol.0 as usize]
    }

    /// Whether a symbol is in this table.
    pub fn contains(&self, symbol: Symbol) -> bool {
        (symbol.0 as usize) < self.len()
    }

    /// How many symbols there are.
    pub fn len(&self) -> usize {
        self.0.names.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.names.is_empty()
    }
}

impl Serialize for Symbols {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.names.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Symbols {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let names = Vec::<Arc<str>>::deserialize(deserializer)?;
        let bytes = names.iter().map(|name| BYTES_A_NAME + name.len()).sum();
        let interned = names.iter().enumerate().filter(|(_, name)| !is_uninterned(name));
        let interned: Vec<(u64, Symbol)> = interned.map(|(index, name)| (hash(name), Symbol(index as u32))).collect();
        let mut names = Names { names, by_name: HashTable::with_capacity(interned.len()), bytes };
        interned.into_iter().for_each(|(hash, symbol)| names.enter(hash, symbol));
        Ok(Self(Arc::new(names)))
    }
}

/// The same names under the same numbers.
impl PartialEq for Symbols {
    fn eq(&self, other: &Self) -> bool {
        self.0.names == other.0.names
    }
}

impl Eq for Symbols {}

fn hash(name: &str) -> u64 {
    FixedState::default().hash_one(name.as_bytes())
}

/// What the names of uninterned symbols begin with, and no others.
const UNINTERNED: &str = "#:";

/// Whether a name is that of an uninterned symbol, which no text can name.
pub fn is_uninterned(name: &str) -> bool {
    name.starts_with(UNINTERNED)
}

/// The name a bare symbol's text stands for: lower case, and `≤ ≥ ≠` written out.
pub fn fold_name(text: &str) -> Cow<'_, str> {
    if text.bytes().all(|b| b.is_ascii() && !b.is_ascii_uppercase()) {
        return Cow::Borrowed(text);
    }
    let mut name = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '≤' => name.push_str("<="),
            '≥' => name.push_str(">="),
            '≠' => name.push_str("/="),
            _ => name.extend(character.to_lowercase()),
        }
    }
    Cow::Owned(name)
}
