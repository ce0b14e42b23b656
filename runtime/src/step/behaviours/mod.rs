//! Behaviours, as the plans that activate them see them.

mod activation;
mod reading;
mod signal;
