//! The command as a user types it: output, exit status, files, terminal. One program for all of it,
//! since linking takes longer than compiling; `cargo test -p rpl prompt` runs what has the word in its
//! path.

#![allow(clippy::disallowed_methods, reason = "names of files are given to the command here, and not told")]

mod case_memory;
mod cases;
mod check;
mod completion;
mod debug_adapter;
mod deftest;
mod editors;
mod errands;
mod eval;
mod experiment;
mod explore;
mod figures;
mod fmt;
mod folder;
mod foreign;
mod forged_text;
mod help;
mod hosts;
mod journal;
mod journal_copies;
mod journal_outside;
mod journal_session;
mod json;
mod keys;
mod language_server;
mod layout;
mod live;
mod localize;
mod modules;
mod modules_alone;
mod new;
mod outputs;
mod pages;
mod parts;
mod pipes;
mod plan_files;
mod prompt;
mod recordings;
mod robots;
mod rpl;
mod run;
mod scenarios;
mod signals;
mod terminal;
mod trace;
mod view;
mod wire;
mod worlds;
