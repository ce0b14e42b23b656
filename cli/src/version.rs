//! Which build of the command this is.

/// The version, and in a release build the commit it was built from, if that is known.
pub const VERSION: &str = env!("RPL_VERSION");

/// The build: two of the same name give the same runs. The version alone does not tell them apart, because a program is
/// also built between two commits; nor does the commit, because most of them change no run.
pub const BUILD: &str = concat!(env!("CARGO_PKG_VERSION"), ", sources ", env!("RPL_SOURCES"));
