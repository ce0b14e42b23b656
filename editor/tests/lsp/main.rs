//! The language server against the published specification: an editor as a script, and what it is told.

mod client;
mod conversation;
mod features;
mod open_texts;
mod projects;
mod streams;
mod synchrony;
