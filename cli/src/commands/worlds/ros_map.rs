//! A map as ROS has it: a text about it, and a picture in three greys.

use rpl_robot::occupancy::{Cell, OccupancyGrid};

/// The text. What is unknown is 205 in the picture, a probability of 0.196: just not free.
pub fn yaml(map: &OccupancyGrid) -> String {
    let (resolution_m, origin) = (map.resolution_m, map.origin_in_frame);
    format!(
        "image: map.pgm\nmode: trinary\nresolution: {resolution_m}\norigin: [{}, {}, 0]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n",
        origin.x, origin.y
    )
}

/// The picture, as a portable grey map: the topmost row first.
pub fn pgm(map: &OccupancyGrid) -> Vec<u8> {
    let mut bytes = format!("P5\n{} {}\n255\n", map.columns, map.rows).into_bytes();
    for row in (0..map.rows).rev() {
        bytes.extend((0..map.columns).map(|column| match map.get(column, row) {
            Cell::Occupied => 0,
            Cell::Free => 254,
            Cell::Unknown => 205,
        }));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::world::{GreyImage, RosMap, World};

    #[test]
    fn what_is_written_is_read_as_the_same_map() {
        let map = World::builtin("dept").expect("the world is built in").map(0.05);
        let text = RosMap::parse(&yaml(&map), "map.yaml").expect("no faults");
        let image = GreyImage::decode(&pgm(&map)).expect("an image");
        assert!(text.grid(&image) == map);
    }
}
