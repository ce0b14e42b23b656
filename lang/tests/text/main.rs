//! Plan texts: read, their faults told, printed, laid out anew.

mod errors;
mod formatting;
mod printing;
mod reading;
