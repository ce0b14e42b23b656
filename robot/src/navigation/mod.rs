//! Path planning, collision avoidance, topological plans.
