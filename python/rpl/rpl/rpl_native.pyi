"""What is written in Rust."""

from collections.abc import Callable
from typing import Any, final

import numpy as np
import numpy.typing as npt
from typing_extensions import Self, disjoint_base

__all__ = ["BUILD", "Mission", "Robot", "SetUpError", "World", "check", "command"]

BUILD: str
"""Which build this is: parts of experiments fit together if they were made by the same."""

class SetUpError(ValueError):
    """Plan, world, robot and scenario do not go together, or one of them has faults."""

@final
class Robot:
    """A robot: what it looks like and can do. The name of a built-in one, or a file; the papers' robot without."""

    def __new__(cls, name: str | None = None) -> Self: ...
    @staticmethod
    def names() -> list[str]:
        """The robots that need no file."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def purpose(self) -> str:
        """What it is, in a sentence."""
    @property
    def radius_m(self) -> float:
        """Radius of its circle, in metres."""

@final
class World:
    """A world: the name of a built-in one, or a file. An arena is drawn from the seed. Notebooks draw it."""

    def __new__(cls, name: str, robot: Robot | None = None, seed: int = 1) -> Self: ...
    @staticmethod
    def names() -> list[str]:
        """The worlds that need no file."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top in metres of the map, as matplotlib's `imshow` takes them."""
    @property
    def start(self) -> tuple[float, float, float]:
        """Where the robot stands at the start: x [m], y [m], heading [rad]."""
    @property
    def places(self) -> dict[str, tuple[float, float, float]]:
        """The places by name: x [m], y [m], heading [rad]."""
    def _repr_svg_(self) -> str: ...

@disjoint_base
class Mission:
    def __new__(
        cls,
        plan: tuple[str, str | None],
        world: World | None,
        robot: Robot | None,
        seed: int,
        scenario: tuple[str, str | None] | None,
        modules: list[tuple[str, Callable[[], Callable[[str], str]]]],
        fork_of: Mission | None = None,
    ) -> Self: ...
    def step(self) -> bool:
        """Goes on to the end of the next instant. Answers whether there is a further one."""
    def run_until(self, until_s: float) -> bool:
        """Goes on until a time of the plan, or to the end of the run. Answers whether it has ended."""
    def save(self) -> bytes:
        """The run as bytes, from which `load` goes on."""
    def load(self, saved: bytes) -> None:
        """Goes on from what was saved of a mission with the same plan in the same place."""
    @property
    def time_s(self) -> float:
        """Virtual time in seconds."""
    @property
    def outcome(self) -> str | None:
        """`succeeded`, `failed` or `ended itself`; None while the mission goes on."""
    @property
    def value(self) -> str | None:
        """The value of a plan that has succeeded, as it could be read again."""
    @property
    def printed(self) -> list[str]:
        """What the plan has printed."""
    def fluent(self, name: str) -> str | None:
        """The value of a fluent of the robot, or of a global one of the plan, as it could be read again."""
    @property
    def true_pose(self) -> tuple[float, float, float] | None:
        """Where the robot really is: x [m], y [m], heading [rad]. None without a robot."""
    @property
    def estimate(self) -> tuple[float, float, float] | None:
        """Where it believes it is: x [m], y [m], heading [rad]."""
    @property
    def certainty(self) -> float | None:
        """How sure it is of that, from 0 to 1."""
    @property
    def belief(self) -> npt.NDArray[np.float64] | None:
        """The probability of each cell over all headings, `belief[row, column]`; the sum is 1.

        The array takes over the memory of Rust, cannot be written, and stays what it is when the mission goes on. None
        without a map.
        """
    @property
    def belief_extent(self) -> tuple[float, float, float, float] | None:
        """Left, right, bottom and top of the belief, in metres of the map, as matplotlib's `imshow` takes them."""
    def failure_json(self) -> str | None: ...
    def trace_columns(self) -> dict[str, Any]: ...
    def figure_svg(self) -> str | None: ...

def command(words: list[str]) -> int:
    """Does what the command `rpl` does with these words, of which the first is its own name: its exit status."""

def check(name: str, text: str | None) -> str: ...
