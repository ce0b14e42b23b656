//! What a robot file says, and what is wrong with it.
