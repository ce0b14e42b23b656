//! Plans on the simulated office robot, from text to trace.

mod at_place;
mod behaviours;
mod bring;
mod cases;
mod delivery;
mod determinism;
mod doubt;
mod examples;
mod foresight;
mod host;
mod immobile;
mod installed_rules;
mod instructions;
mod interruption;
mod landmarks;
mod mapless;
mod moves;
mod office;
mod patience;
mod policies;
mod save;
mod stall;
mod states;
mod stop;
mod thinking;
mod world;
