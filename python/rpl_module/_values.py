"""What is said and heard: values of plans, ticks, failures."""

from __future__ import annotations

import math
import numbers
from dataclasses import dataclass, field, fields
from typing import Any, Dict, List, Optional, Union


class Symbol(str):
    """A symbol of a plan, such as ``'kitchen``; it is the same as the text of its name in Python."""

    def __repr__(self) -> str:
        return f"Symbol({str(self)!r})"


Value = Union[None, bool, int, float, str, Symbol, List["Value"]]
"""What a fluent can hold and an argument can be; ``None`` is ``nil``, as ``False`` is."""


class Failure(Exception):
    """Raised in a behaviour or a query it becomes a failure of the plan.

    The class is one that the plan has defined (``def-failure``); the slots are those of the class.
    """

    def __init__(self, failure_class: str, message: str, /, **slots: Value) -> None:
        super().__init__(message)
        self.failure_class = failure_class
        self.message = message
        self.slots = {plan_name(name): value for name, value in slots.items()}


@dataclass(frozen=True)
class Pose:
    """Where something is, and where it looks."""

    x_m: float
    y_m: float
    heading_rad: float


@dataclass(frozen=True)
class Position:
    """Where the robot believes itself to be, and how certain that is, from 0 to 1."""

    x_m: float
    y_m: float
    heading_rad: float
    certainty: float


@dataclass(frozen=True)
class CameraReading:
    """What a camera that is on tells."""

    pan_rad: float
    image: Optional[str] = None
    """Red, green and blue of each pixel, a byte each, the top row first, in Base64."""


@dataclass(frozen=True)
class Percept:
    """What the robot perceives at the end of a step."""

    odometry_in_odom: Pose
    translation_mps: float
    rotation_radps: float
    bumped: bool
    gripper: str
    """``"open"``, ``"moving"`` or ``"closed"``."""
    battery: float
    sonar_m: Optional[List[float]] = None
    laser_m: Optional[List[float]] = None
    camera: Optional[CameraReading] = None
    holding: Optional[str] = None
    messages: List[List[str]] = field(default_factory=list)
    others: Dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Tick:
    """One step of the robot: when it is, and what the manifest wants to be told."""

    time_s: float
    position: Optional[Position] = None
    percept: Optional[Percept] = None


def plan_name(name: str) -> str:
    """The name in a plan of what Python calls ``max_speed``."""
    return name.replace("_", "-")


def python_name(name: str) -> str:
    """The name in Python of what a plan calls ``max-speed``."""
    return name.replace("-", "_")


def tick_of(message: Dict[str, Any]) -> Tick:
    position = message.get("position")
    percept = message.get("percept")
    if percept is not None:
        known = {known.name for known in fields(Percept)}
        percept = {name: value for name, value in percept.items() if name in known}
        percept["odometry_in_odom"] = Pose(**percept["odometry_in_odom"])
        if percept.get("camera") is not None:
            percept["camera"] = CameraReading(**percept["camera"])
    return Tick(
        time_s=message["time_us"] / 1e6,
        position=None if position is None else Position(**position),
        percept=None if percept is None else Percept(**percept),
    )


def heard(value: Any) -> Value:
    """A value as it comes from rpl."""
    if isinstance(value, dict):
        return Symbol(value["symbol"])
    if isinstance(value, list):
        return [heard(item) for item in value]
    return value  # type: ignore[no-any-return]


def said(value: Any) -> Any:
    """A value as it goes to rpl; numbers of other packages are taken for what they are."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, Symbol):
        return {"symbol": str(value)}
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple)):
        return [said(item) for item in value]
    if type(value).__name__ == "bool_":
        return bool(value)
    if isinstance(value, numbers.Integral):
        return int(value)
    if isinstance(value, numbers.Real):
        number = float(value)
        if not math.isfinite(number):
            raise ValueError(f"{number} cannot be told to a plan: it is not finite")
        return number
    raise TypeError(
        f"a {type(value).__name__} cannot be told to a plan; "
        "None, bool, int, float, str, Symbol and lists of these can"
    )
