//! What a command has found out, for people to read: lines and tables in their order.

use crate::terminal::table::Table;

/// A stretch of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Block {
    /// Lines; one that is too long goes on below.
    Lines(String),
    /// A table.
    Table(Table),
}
