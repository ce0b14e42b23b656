//! A case: files, and what is typed where they are.

/// What stands under a name in the folder of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    /// These bytes.
    Bytes(Vec<u8>),
    /// A link to this path.
    Link(&'static str),
    /// A folder.
    Folder,
    /// A pipe that never ends.
    EndlessPipe,
}

/// What the command may say to a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// It may be right after all.
    Anything,
    /// It is refused: exit status 2.
    Refused,
}

/// Files, and what is typed where they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// Which forger wrote it.
    pub kind: &'static str,
    /// Names and what is there.
    pub files: Vec<(String, Content)>,
    /// The arguments of the command.
    pub arguments: Vec<String>,
    /// What it may say.
    pub expected: Expected,
}

/// Arguments from words.
pub(super) fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_string).collect()
}

/// A file of this text.
pub(super) fn text(name: &str, text: impl Into<Vec<u8>>) -> (String, Content) {
    (name.to_string(), Content::Bytes(text.into()))
}

/// A plan that ends at once.
pub(super) fn plan() -> (String, Content) {
    text("plan.rpl", "(wait-time 0.2)\n")
}
