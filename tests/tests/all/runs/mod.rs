//! A run as a value: traced, stepped, sliced, saved, forked, taken back, extended form by form, gone on with elsewhere.

mod charging;
mod event_time;
mod resumption;
mod robot_tables;
mod save;
mod session;
mod slices;
mod stepping;
mod timeline;
mod trace;
