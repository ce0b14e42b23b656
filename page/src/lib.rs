//! What is seen of a run, and the page that shows it.
//!
//! A run becomes a [`series`]: a head that says what does not change (map, robot, texts of the plan), and lines that
//! say what has changed since. One page shows it, whether the lines come from a run that goes on ([`server`]) or lie in
//! the page itself ([`report`]): it keeps a state now and then, so that any instant is near one. So one encoding serves
//! a run that goes on, a report and a trace.
//!
//! It knows no task, no robot and no simulator: the driver of a run says in the words of the series what is to be seen.
//! Nothing here can change a run. A wish of a person at the page comes out as [`server::news::Asked`], and the driver
//! of the run decides what becomes of it. Run and server are two threads that share nothing: lines go one way and
//! wishes the other, through channels.
//!
//! Read in this order: [`place`], [`belief`], [`series`], [`html`], [`report`], [`server`]; then `assets`, the page
//! itself.

pub mod belief;
pub mod html;
pub mod place;
pub mod report;
pub mod series;
pub mod server;
