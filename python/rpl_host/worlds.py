"""The worlds of rpl for other simulators: what stands in them, as shapes.

``rpl worlds flat --toml flat.toml`` writes the file of a world::

    world = World.read("flat.toml")
    for shape in world.shapes:
        ...  # a Box, a Disc or a Polygon

It needs Python 3.11, which can read TOML.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Tuple, Union

Point = Tuple[float, float]

WALL_M = 0.15
"""The thickness of a wall that does not say how thick it is."""

LEAF_M = 0.04
"""The thickness of a closed door."""


@dataclass(frozen=True)
class Box:
    """A rectangle about its middle, its length along the heading."""

    x_m: float
    y_m: float
    heading_rad: float
    length_m: float
    width_m: float

    @property
    def corners(self) -> Tuple[Point, ...]:
        """Its corners, counter-clockwise."""
        cos, sin = math.cos(self.heading_rad), math.sin(self.heading_rad)
        halves = [(along * self.length_m / 2, across * self.width_m / 2) for along, across in CORNERS]
        return tuple((self.x_m + cos * x - sin * y, self.y_m + sin * x + cos * y) for x, y in halves)


CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


@dataclass(frozen=True)
class Disc:
    """What is round."""

    x_m: float
    y_m: float
    radius_m: float


@dataclass(frozen=True)
class Polygon:
    """What has other corners than a box, one after the other."""

    corners: Tuple[Point, ...]


Shape = Union[Box, Disc, Polygon]


@dataclass(frozen=True)
class World:
    """A world as it is at the start of a run, also where the robot's map shows it otherwise."""

    name: str
    size: Point
    start: Tuple[float, float, float]
    """Where the robot stands: x and y in metres, heading in radians."""
    shapes: Tuple[Shape, ...]
    """Walls without the openings of their doors, closed doors, and things."""
    places: Dict[str, Point]
    """Where the places of plans are, by their names."""

    @staticmethod
    def read(path: Union[str, Path]) -> World:
        """The world of a file. People, and what a ROS map in it shows, are left out."""
        import tomllib

        with open(path, "rb") as file:
            return World.of(tomllib.load(file))

    @staticmethod
    def of(tables: Dict[str, Any]) -> World:
        """The world of the tables of a file."""
        if "map" in tables:
            raise ValueError("the walls of this world are in a ROS map, and not in its file")
        doors = tables.get("door", [])
        shapes: List[Shape] = []
        for wall in tables.get("wall", []):
            for start, end in zip(wall["line"], wall["line"][1:]):
                shapes += straight_wall(start, end, wall.get("thickness", WALL_M), doors)
        for door in doors:
            if not door.get("open", True):
                turned_rad = 0.0 if door["axis"] == "x" else math.pi / 2
                x_m, y_m = door["at"]
                shapes.append(Box(x_m, y_m, turned_rad, door["width"], LEAF_M))
        shapes += [thing(table) for table in tables.get("object", [])]
        width_m, height_m = tables["size"]
        x_m, y_m, heading = tables["start"]
        places = {place["name"]: (place["pose"][0], place["pose"][1]) for place in tables.get("place", [])}
        start = (x_m, y_m, angle_rad(heading))
        return World(tables["name"], (width_m, height_m), start, tuple(shapes), places)


def straight_wall(start: Point, end: Point, thickness_m: float, doors: List[Dict[str, Any]]) -> List[Box]:
    """A wall between two points, in pieces between its doors; it fills the corners at its ends."""
    length_m = math.dist(start, end)
    if length_m == 0.0:
        return []
    along = ((end[0] - start[0]) / length_m, (end[1] - start[1]) / length_m)
    openings = []
    for door in doors:
        offset = (door["at"][0] - start[0], door["at"][1] - start[1])
        at_m = along[0] * offset[0] + along[1] * offset[1]
        aside_m = abs(along[0] * offset[1] - along[1] * offset[0])
        is_along = abs(along[1] if door["axis"] == "x" else along[0]) < 1e-6
        half_m = door["width"] / 2
        if is_along and aside_m <= max(thickness_m / 2, 0.02) and half_m - 1e-6 <= at_m <= length_m - half_m + 1e-6:
            openings.append((at_m - half_m, at_m + half_m))
    pieces, begins_m = [], -thickness_m / 2
    for opens_m, closes_m in [*sorted(openings), (length_m + thickness_m / 2, math.inf)]:
        if opens_m > begins_m + 1e-9:
            middle_m = (begins_m + opens_m) / 2
            x_m, y_m = start[0] + along[0] * middle_m, start[1] + along[1] * middle_m
            pieces.append(Box(x_m, y_m, math.atan2(along[1], along[0]), opens_m - begins_m, thickness_m))
        begins_m = max(begins_m, closes_m)
    return pieces


def thing(table: Dict[str, Any]) -> Shape:
    if "circle" in table:
        return Disc(*table["circle"])
    if "polygon" in table:
        return Polygon(tuple((x_m, y_m) for x_m, y_m in table["polygon"]))
    x0_m, y0_m, x1_m, y1_m = table["rect"]
    return Box((x0_m + x1_m) / 2, (y0_m + y1_m) / 2, 0.0, x1_m - x0_m, y1_m - y0_m)


def angle_rad(told: Union[str, float]) -> float:
    """An angle as the files have it: radians, or a text such as `90deg`."""
    if isinstance(told, str):
        if not told.endswith("deg"):
            raise ValueError(f"{told!r} is no angle; '90deg' is one")
        return math.radians(float(told[: -len("deg")]))
    return float(told)
