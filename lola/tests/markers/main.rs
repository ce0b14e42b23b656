//! Markers on the floor, from the simulator's images to places in `odom`.

mod colours;
mod drives;
