//! Hallways whose direction is known.
