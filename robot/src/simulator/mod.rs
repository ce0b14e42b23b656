//! The simulated robot in its world.
