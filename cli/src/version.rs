//! Which build of the command this is.

/// The version, and in a release build the commit it was built from, if that is known.
pub const VERSION: &str = env!("RPL_VERSION");
