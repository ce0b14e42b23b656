"""Worlds of rpl as shapes."""

import math
import sys
import unittest
from pathlib import Path
from typing import Any, Dict

from rpl_host.worlds import Box, Disc, Polygon, World, angle_rad

WORLDS = Path(__file__).parents[2] / "robot" / "worlds"


def world(**tables: Any) -> World:
    room: Dict[str, Any] = {"name": "w", "size": [8.0, 6.0], "start": [1.0, 2.0, "90deg"]}
    return World.of({**room, **tables})


def covers(shape: Any, x_m: float, y_m: float) -> bool:
    """Whether a point is in a convex shape."""
    if isinstance(shape, Disc):
        return math.hypot(x_m - shape.x_m, y_m - shape.y_m) < shape.radius_m
    corners = shape.corners
    sides = zip(corners, corners[1:] + corners[:1])
    return all((bx - ax) * (y_m - ay) > (by - ay) * (x_m - ax) for (ax, ay), (bx, by) in sides)


class Worlds(unittest.TestCase):
    def test_a_wall_fills_its_corners_and_opens_at_its_doors(self) -> None:
        wall = {"line": [[1.0, 1.0], [5.0, 1.0], [5.0, 4.0]], "thickness": 0.2}
        door = {"room": "r", "at": [3.0, 1.0], "width": 0.9, "axis": "x"}
        # One that stands in another wall.
        other = {"room": "r", "at": [3.0, 1.0], "width": 0.9, "axis": "y"}
        shapes = world(wall=[wall], door=[door, other]).shapes
        self.assertEqual([type(shape) for shape in shapes], [Box] * 3)
        for x_m, y_m, is_wall in (
            (2.5, 1.05, True), (2.6, 1.0, False), (3.4, 1.0, False), (3.5, 1.0, True), (0.95, 1.0, True),
            (5.05, 0.95, True), (5.05, 4.05, True), (5.05, 4.15, False), (4.0, 1.15, False),
        ):
            self.assertEqual(any(covers(shape, x_m, y_m) for shape in shapes), is_wall, (x_m, y_m))

    def test_a_closed_door_is_a_thin_wall(self) -> None:
        door = {"room": "r", "at": [5.0, 3.0], "width": 0.9, "axis": "y", "open": False}
        (leaf,) = world(wall=[], door=[door]).shapes
        self.assertTrue(covers(leaf, 5.01, 3.4) and covers(leaf, 4.99, 2.6))
        self.assertFalse(covers(leaf, 5.05, 3.0) or covers(leaf, 5.0, 3.5))

    def test_things_are_boxes_discs_and_polygons(self) -> None:
        things = [{"rect": [1.0, 2.0, 3.0, 2.5]}, {"circle": [4.0, 1.0, 0.3]}, {"polygon": [[0, 0], [1, 0], [0, 1]]}]
        self.assertEqual(world(object=things).shapes, (
            Box(2.0, 2.25, 0.0, 2.0, 0.5), Disc(4.0, 1.0, 0.3), Polygon(((0, 0), (1, 0), (0, 1))),
        ))

    def test_angles_are_texts_in_degrees_or_radians(self) -> None:
        self.assertEqual(world().start, (1.0, 2.0, math.pi / 2))
        self.assertEqual((angle_rad("-90deg"), angle_rad(0.5)), (-math.pi / 2, 0.5))
        for wrong in ("90", "deg", "90degrees", "ninetydeg"):
            with self.assertRaises(ValueError):
                angle_rad(wrong)

    def test_a_world_with_a_recorded_map_is_refused(self) -> None:
        with self.assertRaisesRegex(ValueError, "in a ROS map"):
            world(map="map.yaml")

    @unittest.skipIf(sys.version_info < (3, 11), "Python 3.11 reads TOML")
    def test_the_worlds_of_rpl_are_read(self) -> None:
        flat = World.read(WORLDS / "flat.toml")
        self.assertEqual((flat.name, flat.size, flat.start), ("flat", (12.4, 9.4), (6.2, 4.6, 0.0)))
        self.assertEqual(flat.places["sofa-side"], (1.8, 7.6))
        # Nineteen things; four walls around, three without a door, one with two doors and one with three.
        self.assertEqual(len(flat.shapes), 19 + 4 + 3 + 3 + 4)
        x_m, y_m, _ = flat.start
        self.assertFalse(any(covers(shape, x_m, y_m) for shape in flat.shapes))


if __name__ == "__main__":
    unittest.main()
