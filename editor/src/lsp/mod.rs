//! The language server: the protocol's requests, each answered in a file of its own.
//!
//! [`session`] is the server as a value: it hears messages ([`messages`]) and answers them (`dispatch`), and it can be
//! asked to look at one of the texts that have changed (`open_texts`), or to read some files (`folder_files`).
//! [`serve`] is the loop around it, and alone knows a clock and a thread. It decides when: a short text is looked at as
//! soon as nothing more waits to be read, a long one when typing pauses.

#![allow(
    clippy::mutable_key_type,
    reason = "a URI of lsp-types remembers how it was read; its order and its hash follow from its text"
)]

mod actions;
mod capabilities;
mod completion;
mod diagnostics;
mod dispatch;
mod editor;
mod folder_files;
mod folding;
mod formatting;
mod hints;
mod hover;
mod lenses;
mod library;
mod loads;
pub mod messages;
mod navigation;
mod open_texts;
mod rename;
mod serve;
pub mod session;
mod signatures;
mod symbols;
mod tokens;
mod waiting;
mod workspace_symbols;

pub use serve::serve;
pub use session::Ending;
