//! Hallways whose features are known.
