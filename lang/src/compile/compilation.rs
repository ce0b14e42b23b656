//! What a compilation works with: the program it adds to, the names, and what stands above this crate.

use crate::code::Program;
use crate::diagnostic::Diagnostic;
use crate::kind::Kind;
use crate::symbol::Symbols;
use crate::syntax::{NodeId, Tree};
use std::sync::LazyLock;

/// What the compiler knows of a native function.
#[derive(Clone, Debug, PartialEq)]
pub struct NativeSignature {
    /// Its name.
    pub name: String,
    /// Its parameters, as its documentation writes them.
    pub parameters: String,
    /// Fewest arguments.
    pub min: u8,
    /// Most arguments; none for any number.
    pub max: Option<u8>,
    /// Whether it waits, assigns or acts on tasks, which a network may not.
    pub effect: bool,
    /// Whether it may block its task.
    pub waits: bool,
    /// The kinds of its parameters, optional ones included, but for the last of any number.
    pub kinds: Vec<Kind>,
    /// The kind of the arguments behind these.
    pub rest: Option<Kind>,
    /// Whether it goes on in code of the plan, so that its value is found where a call's is.
    pub calls: bool,
}

impl NativeSignature {
    /// The kind of argument it takes at a position.
    pub fn kind(&self, at: usize) -> Kind {
        self.kinds.get(at).copied().or(self.rest).unwrap_or(Kind::Any)
    }
}

/// "2 arguments", "1 to 2 arguments", as errors say it.
pub(super) fn describe_arity(min: u8, max: Option<u8>) -> String {
    let plural = |count: u8| if count == 1 { "1 argument".to_string() } else { format!("{count} arguments") };
    match max {
        Some(max) if max == min => plural(min),
        Some(max) => format!("{min} to {}", plural(max)),
        None => format!("at least {}", plural(min)),
    }
}

/// How a call of a native function is written.
pub(super) fn call_of_native(native: &NativeSignature) -> String {
    let parameters = native.parameters.split_whitespace().map(|word| match word.starts_with('&') {
        true => word.to_string(),
        false => word.to_uppercase(),
    });
    format!("`({})`", std::iter::once(native.name.clone()).chain(parameters).collect::<Vec<_>>().join(" "))
}

/// Why a call of a macro has no expansion.
#[derive(Debug)]
pub enum Unexpanded {
    /// What went wrong in the macro's own code, at its place.
    Failed(Box<Diagnostic>),
    /// It would have more parts than it may.
    TooLarge,
    /// All expansions so far have taken as many steps as those of one text may.
    TooLong {
        /// How many.
        steps: u64,
    },
}

/// Runs macros: the evaluator lives above this crate.
pub trait MacroHost {
    /// The expansion of `form`, a call of the macro with this code. It adds at most `most` parts to the tree.
    ///
    /// # Errors
    /// There is none.
    fn expand(
        &mut self,
        program: &Program,
        symbols: &mut Symbols,
        tree: &mut Tree,
        code: u32,
        form: NodeId,
        most: usize,
    ) -> Result<NodeId, Unexpanded>;

    /// A global was defined, or its definition is compiled now.
    fn defined(&mut self, global: u32);
}

/// Finds the text of a `(load "file")`.
pub trait Loader {
    /// The name to print and the text.
    ///
    /// # Errors
    /// One sentence saying why it cannot be read.
    fn load(&mut self, from: &str, path: &str) -> Result<(String, String), String>;
}

/// A [`Loader`] for texts that may not load files.
pub struct NoFiles;

impl Loader for NoFiles {
    fn load(&mut self, _from: &str, _path: &str) -> Result<(String, String), String> {
        Err("this text has no folder to load files from".into())
    }
}

/// What a text is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The library: its names can be defined again by a file.
    Library,
    /// A user's file or form.
    User,
}

/// Names that are found out when the first of them is asked for.
pub type Names = LazyLock<Vec<String>, Box<dyn FnOnce() -> Vec<String> + Send>>;

/// None.
pub fn no_names() -> Names {
    LazyLock::new(Box::new(Vec::new))
}

/// What names of another kind of text belong to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextKind {
    /// Plans of a robot.
    Plan,
    /// What an experimenter does.
    #[default]
    Scenario,
}

/// Names that a text does not have, and that another kind of text has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NamesElsewhere {
    /// The other kind.
    pub kind: TextKind,
    /// Its names.
    pub names: Vec<String>,
}

/// The surroundings of a compilation.
pub struct Compilation<'a> {
    /// Where code is added.
    pub program: &'a mut Program,
    /// The library that the program began with, whose numbers it shares: what names of the library mean
    /// that the program has defined again. None for a text of the library itself.
    pub library: Option<&'a Program>,
    /// The names.
    pub symbols: &'a mut Symbols,
    /// The native functions, by number.
    pub natives: &'a [NativeSignature],
    /// Runs macros.
    pub macros: &'a mut dyn MacroHost,
    /// Finds loaded files.
    pub loader: &'a mut dyn Loader,
    /// Names that exist only with a robot, so that an error can say so.
    pub robot_names: &'a Names,
    /// Names that only another kind of text has, so that an error can say so.
    pub names_elsewhere: &'a NamesElsewhere,
}
