//! Names of files in what is said to a person.

use rpl_lang::visible::visible;
use std::path::Path;

/// How a path is named in messages: `display` of the standard library gives a terminal whatever is in a name, and a
/// line feed in it begins a line that looks like one of ours.
pub trait Shown {
    /// The path on one line, with what is not seen written out.
    fn shown(&self) -> String;
}

impl Shown for Path {
    fn shown(&self) -> String {
        visible(&self.to_string_lossy()).into_owned()
    }
}
