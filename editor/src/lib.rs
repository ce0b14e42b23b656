//! What editors ask about plans, as a language server, and what debuggers say, as types.
//!
//! A text is looked at by the front of the compiler and by nothing else: [`analysis`] is what `rpl check` finds in it,
//! with the place and meaning of every name; [`lsp`] answers from that, from the tokens, and from the reference that
//! `rpl doc` prints. A text that cannot be read is answered for as far as it goes.
//!
//! It opens no file and starts no run: texts come from the editor. The program around it knows what lies beside them
//! (loaded files, the project's world and robot), and tells it through [`surroundings`]. The debug adapter is another
//! front of the prompt's session, in the crate `prompt`.
//!
//! Read in this order: [`lines`], [`surroundings`], [`outline`], [`definitions`], [`analysis`], [`document`], then
//! [`frames`], [`lsp`] from its root, and [`dap`].

pub mod analysis;
pub mod dap;
pub mod definitions;
pub mod document;
pub mod frames;
pub mod lines;
pub mod lsp;
pub mod outline;
pub mod surroundings;
