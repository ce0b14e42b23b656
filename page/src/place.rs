//! Where something is: millimetres and milliradians, as whole numbers.

/// A point: x and y.
pub type Spot = [i32; 2];

/// A pose: x, y and heading.
pub type Pose = [i32; 3];
