//! Programs disturbed at every step, written by hand and generated.

mod evaporation;
mod generated;
