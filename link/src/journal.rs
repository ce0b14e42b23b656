//! Journals: a run written down while it goes on, so that it can be gone on with after a crash. What of a run
//! stands in one is for whoever drives it; here is how it stands there.
//!
//! A journal is a folder that one process writes ([`folder`]). Its files are of two kinds. Those that are there
//! whole or not at all are written beside and renamed: what the run is, and [`checkpoint`]s. Those that grow are
//! read up to where they are whole: [`frames`] are checked one by one, and a [`ledger`] is compared with what the
//! run writes again. What came from outside, between two checkpoints, are [`inputs`].
//! All of them are opened by [`own_file`].

pub mod checkpoint;
pub mod folder;
pub mod frames;
pub mod inputs;
pub mod ledger;
pub mod own_file;
