"""What a robot perceives: as its user gives it, and as missions are told."""

from __future__ import annotations

import base64
import math
from dataclasses import dataclass, field
from typing import Any, Dict, Iterable, List, Mapping, Optional, SupportsFloat, Tuple, Union

Signal = Union[bool, float, str, List["Signal"]]
"""The value of a sensor or an actuator that rpl knows nothing else of."""

Speeds = Tuple[float, float]

POSE = ("x_m", "y_m", "heading_rad")

SPEEDS = ("translation_mps", "rotation_radps")

MOST = 1e6
"""Metres, metres a second or radians that no robot comes to."""

LONGEST_GAP_S = 10.0
"""From one reading to the next the robot's own clock goes on by no more."""

STANDS = (0.01, 0.02)
"""A robot that is slower than this, in metres and in radians a second, stands: wheels are measured with noise."""


class ReadingError(ValueError):
    """No robot can have perceived this."""


@dataclass(frozen=True)
class CameraReading:
    """What a camera that is on tells."""

    pan_rad: SupportsFloat
    """Where it points, counter-clockwise from straight ahead."""
    rgb: Optional[bytes] = None
    """A new image, if there is one: red, green and blue of each pixel, a byte each, the top row first."""


@dataclass(frozen=True)
class Reading:
    """What the robot perceives now. It leaves out what it has not."""

    x_m: Optional[SupportsFloat] = None
    """Where dead reckoning says that the robot is; the origin does not matter, the host moves it to the start. Without
    a pose the host adds up the speeds."""
    y_m: Optional[SupportsFloat] = None
    heading_rad: Optional[SupportsFloat] = None
    """Counter-clockwise; whole turns do not matter."""
    translation_mps: Optional[SupportsFloat] = None
    """Speed ahead, by the wheels; without it that of the pose."""
    rotation_radps: Optional[SupportsFloat] = None
    """Turning speed, counter-clockwise, by the wheels; without it that of the pose."""
    laser_m: Optional[Iterable[SupportsFloat]] = None
    """Distances from right to left; without an echo the ``range`` of the robot's file."""
    sonar_m: Optional[Iterable[SupportsFloat]] = None
    """Distances in the order of the robot's file; without an echo the ``range`` there."""
    bumped: bool = False
    """Whether something presses against the body."""
    battery: SupportsFloat = 1.0
    """From 0 to 1."""
    gripper: str = "open"
    """``"open"``, ``"moving"`` or ``"closed"``."""
    holding: Optional[str] = None
    """The thing in the gripper."""
    camera: Optional[CameraReading] = None
    failed: Iterable[str] = ()
    """Which of ``"sonars"``, ``"laser"`` and ``"camera"`` have failed; nothing is expected of these."""
    messages: Iterable[str] = ()
    """What people have sent since the last reading."""
    others: Mapping[str, Signal] = field(default_factory=dict)
    """What sensors of other kinds perceive, by their names."""
    time_s: Optional[float] = None
    """When that was, by a clock of the robot's own; by that of the host if it is left out."""


@dataclass(frozen=True)
class Pose:
    """Position and heading in the plane."""

    x_m: float
    y_m: float
    heading_rad: float

    def relative_to(self, origin: Pose) -> Pose:
        """The same, as seen from another one."""
        x_m, y_m = self.x_m - origin.x_m, self.y_m - origin.y_m
        cos, sin = math.cos(origin.heading_rad), math.sin(origin.heading_rad)
        turned_rad = wrapped_rad(self.heading_rad - origin.heading_rad)
        return Pose(cos * x_m + sin * y_m, cos * y_m - sin * x_m, turned_rad)

    def moved(self, ahead_m: float, turned_rad: float) -> Pose:
        """After an arc that begins here."""
        along_rad = self.heading_rad + turned_rad / 2
        x_m, y_m = self.x_m + ahead_m * math.cos(along_rad), self.y_m + ahead_m * math.sin(along_rad)
        return Pose(x_m, y_m, self.heading_rad + turned_rad)


def wrapped_rad(angle_rad: float) -> float:
    return math.remainder(angle_rad, math.tau)


@dataclass(frozen=True)
class Perceived:
    """A reading that can be."""

    time_s: float
    pose_in_odom: Pose
    speeds: Speeds
    """In metres and in radians a second."""
    is_bumped: bool
    rest: Dict[str, Any]
    """What is the same for all missions, as they are told."""

    def stands(self) -> bool:
        return all(abs(speed) < least for speed, least in zip(self.speeds, STANDS))

    def percept(self, began: Perceived, sonars_on: bool) -> Dict[str, Any]:
        """What a mission is told that began there and then."""
        pose = self.pose_in_odom.relative_to(began.pose_in_odom)
        translation_mps, rotation_radps = self.speeds
        percept: Dict[str, Any] = {
            "time_us": round((self.time_s - began.time_s) * 1e6),
            "odometry_in_odom": {"x_m": pose.x_m, "y_m": pose.y_m, "heading_rad": pose.heading_rad},
            "translation_mps": translation_mps,
            "rotation_radps": rotation_radps,
            **self.rest,
        }
        if not sonars_on:
            percept.pop("sonar_m", None)
        return percept


class Perception:
    """Takes readings, one after the other, and refuses what cannot be."""

    def __init__(self) -> None:
        self.last: Optional[Perceived] = None
        self._counts: Dict[str, int] = {}

    def take(self, reading: Reading, host_time_s: float) -> Perceived:
        """The reading as missions are told; the time is that of the host."""
        if not isinstance(reading, Reading):
            raise ReadingError(f"`read` gives a {type(reading).__name__}, and a `Reading` is expected")
        time_s = host_time_s if reading.time_s is None else self._time_s(reading.time_s)
        pose, speeds = self._motion(reading, time_s)
        self.last = Perceived(time_s, pose, speeds, bool(reading.bumped), self._rest(reading))
        return self.last

    def _time_s(self, told_s: float) -> float:
        time_s = number("time_s", told_s, math.inf)
        if self.last is not None and not 0.0 < time_s - self.last.time_s <= LONGEST_GAP_S:
            raise ReadingError(
                f"`time_s` is {time_s}, and that of the last reading was {self.last.time_s}: it has to grow with each "
                f"reading, by {LONGEST_GAP_S:.0f} s at most"
            )
        return time_s

    def _motion(self, reading: Reading, time_s: float) -> Tuple[Pose, Speeds]:
        """Where the robot is, and how fast: what it leaves out follows from the other."""
        told = {name: getattr(reading, name) for name in (*POSE, *SPEEDS)}
        found = {name: number(name, value, MOST) for name, value in told.items() if value is not None}
        has_pose, has_speeds = (all(name in found for name in names) for names in (POSE, SPEEDS))
        if not has_pose and (not has_speeds or any(name in found for name in POSE)):
            raise ReadingError("a reading has a pose, `x_m`, `y_m` and `heading_rad`, or both speeds, or all of these")
        last = self.last
        passed_s = 0.0 if last is None else time_s - last.time_s
        if has_pose:
            pose = Pose(*(found[name] for name in POSE))
        else:
            here = Pose(0.0, 0.0, 0.0) if last is None else last.pose_in_odom
            pose = here.moved(found["translation_mps"] * passed_s, found["rotation_radps"] * passed_s)
        ahead_mps = turning_radps = 0.0
        if last is not None and passed_s > 0.0:
            way = pose.relative_to(last.pose_in_odom)
            ahead_mps, turning_radps = way.x_m / passed_s, way.heading_rad / passed_s
        return pose, (found.get("translation_mps", ahead_mps), found.get("rotation_radps", turning_radps))

    def _rest(self, reading: Reading) -> Dict[str, Any]:
        battery = number("battery", reading.battery, MOST)
        if not 0.0 <= battery <= 1.0:
            raise ReadingError(f"`battery` is {battery}, and 0 to 1 is expected")
        rest: Dict[str, Any] = {
            "bumped": bool(reading.bumped),
            "gripper": one_of("gripper", reading.gripper, ("open", "moving", "closed")),
            "battery": battery,
        }
        for name, distances in (("laser_m", reading.laser_m), ("sonar_m", reading.sonar_m)):
            if distances is not None:
                rest[name] = self._distances(name, distances)
        failed = [one_of("failed", sensor, ("sonars", "laser", "camera")) for sensor in reading.failed]
        if isinstance(reading.messages, str):
            raise ReadingError("`messages` is a text, and a list of texts is expected")
        messages = [words for words in (message.split() for message in reading.messages) if words]
        others = {name: signal(f"others.{name}", value) for name, value in reading.others.items()}
        rest.update({
            name: value
            for name, value in (("failed", failed), ("messages", messages), ("others", others))
            if value
        })
        if reading.holding is not None:
            rest["holding"] = reading.holding
        if reading.camera is not None:
            rest["camera"] = camera(reading.camera)
        return rest

    def _distances(self, name: str, told: Iterable[SupportsFloat]) -> List[float]:
        distances = [distance(f"{name}[{at}]", value) for at, value in enumerate(told)]
        expected = self._counts.setdefault(name, len(distances))
        if len(distances) != expected:
            raise ReadingError(f"`{name}` has {len(distances)} readings, and the first time it had {expected}")
        if name == "laser_m" and 0.0 in distances:
            # The laser is inside of the body: nothing comes so near. Several lasers say 0 where they see nothing.
            raise ReadingError(f"`laser_m[{distances.index(0.0)}]` is 0, and nothing is in the laser; {NO_ECHO}")
        return distances


NO_ECHO = "without an echo it is the `range` of the robot's file"


def distance(name: str, told: SupportsFloat) -> float:
    value = as_float(name, told)
    if not 0.0 <= value <= MOST:
        raise ReadingError(f"`{name}` is {value}, and no distance; {NO_ECHO}")
    # A tenth of a millimetre is enough, and takes half the room.
    return round(value, 4)


def number(name: str, told: SupportsFloat, most: float) -> float:
    value = as_float(name, told)
    if not math.isfinite(value) or abs(value) > most:
        raise ReadingError(f"`{name}` is {value}, and no robot has that")
    return value


def as_float(name: str, told: SupportsFloat) -> float:
    try:
        return float(told)
    except (TypeError, ValueError):
        raise ReadingError(f"`{name}` is a {type(told).__name__}, and a number is expected") from None


def one_of(name: str, told: str, words: Tuple[str, ...]) -> str:
    if told not in words:
        raise ReadingError(f"`{name}` has {told!r} in it, and one of {', '.join(words)} is expected")
    return told


def camera(told: CameraReading) -> Dict[str, Any]:
    pan_rad = number("camera.pan_rad", told.pan_rad, math.pi)
    if told.rgb is None:
        return {"pan_rad": pan_rad}
    return {"pan_rad": pan_rad, "image": base64.b64encode(told.rgb).decode("ascii")}


def signal(name: str, told: Signal) -> Signal:
    if isinstance(told, (bool, str)):
        return told
    if isinstance(told, (list, tuple)):
        return [signal(f"{name}[{at}]", value) for at, value in enumerate(told)]
    return number(name, told, math.inf)
