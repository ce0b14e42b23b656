//! Recorded maps, as the ROS map_server keeps them.

use super::inputs::{MAX_BYTES, read_bytes, short_text};
use crate::files::shown::Shown;
use anyhow::{Result, anyhow};
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::world::{GreyImage, Greys, RosMap};
use std::path::Path;

/// A map that was read, and what may not be meant as it is written.
#[derive(Clone, Debug)]
pub struct MapFile {
    /// The map.
    pub grid: OccupancyGrid,
    /// To be shown to the user.
    pub warnings: Vec<String>,
}

/// The map in a folder that is named instead of its file.
pub const MAP_FILE: &str = "map.yaml";

/// A map of the ROS map_server, by its YAML file or the folder it is in.
///
/// # Errors
/// A file that is missing or has faults.
pub fn ros_map(name: &Path) -> Result<MapFile> {
    let path = if name.is_dir() { name.join(MAP_FILE) } else { name.to_path_buf() };
    let shown = path.shown();
    let text = short_text(&path).map_err(|reason| anyhow!("cannot read the map `{shown}`: {reason}"))?;
    let map = RosMap::parse(&text, &shown).map_err(|error| anyhow!("the map `{shown}` has faults\n{error}"))?;
    let image_path = path.parent().unwrap_or(Path::new(".")).join(&map.image);
    let image_name = image_path.shown();
    let bytes = read_bytes(&image_path, MAX_BYTES)
        .map_err(|reason| anyhow!("cannot read `{image_name}`, the image of the map `{shown}`: {reason}"))?;
    let image = GreyImage::decode(&bytes).map_err(|error| anyhow!("cannot use `{image_name}`: {error}"))?;
    map.check_size(&image).map_err(|error| anyhow!("the map `{shown}` cannot be used: {error}"))?;
    let warnings = Greys::of(&map, &image).warnings();
    let warnings = warnings.into_iter().map(|warning| format!("warning: {shown}: {warning}")).collect();
    let grid = map.grid(&image);
    drop(image);
    grid.check_walls().map_err(|noise| anyhow!("the map `{shown}` cannot be used: {noise}"))?;
    Ok(MapFile { grid, warnings })
}
