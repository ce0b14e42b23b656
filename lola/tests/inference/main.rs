//! What is inferred from percepts and words, without a robot.

mod instruction;
mod judgement;
mod state_set;
mod synthetic;
mod topological;
