"""Missions as Python objects."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import rpl_native
from ._modules import Hearing, opened
from .rpl_native import Robot, World

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa


class TimeUp(Exception):
    """A mission has not ended by the time it was given."""


class PlanFailed(Exception):
    """A plan has failed. The first of its causes is its `__cause__`."""

    def __init__(self, record: dict[str, Any]) -> None:
        super().__init__(f"{record['class']}: {record['message']}")
        #: The class of the failure, by which plans handle it.
        self.failure_class: str = record["class"]
        #: What it says.
        self.message: str = record["message"]
        #: The task that raised it.
        self.path: str = record["path"]
        #: Where that is in the text.
        self.file: str | None = record["file"]
        self.line: int | None = record["line"]
        #: The plans that were running, the innermost first: name, file and line of the call.
        self.calls: list[dict[str, Any]] = record["calls"]
        #: The failures it is composed of.
        self.causes: list[PlanFailed] = [PlanFailed(cause) for cause in record["causes"]]
        if self.causes:
            self.__cause__ = self.causes[0]


@dataclass(frozen=True)
class Finding:
    """What is wrong with a plan, or probably wrong. Lines and columns count from 1."""

    severity: str
    rule: str
    message: str
    file: str
    line: int
    column: int
    help: str | None

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}: {self.severity}: {self.message} [{self.rule}]"


class Plan:
    """A plan: the text of forms, or the name of a file or of a built-in example.

    What has a parenthesis in it is a text.
    """

    def __init__(self, source: str, name: str | None = None) -> None:
        is_text = "(" in source
        #: What the plan is called in messages.
        self.name: str = (name or "plan.rpl") if is_text else source
        #: The text, unless the plan is a file.
        self.text: str | None = source if is_text else None

    def check(self) -> list[Finding]:
        """All errors and warnings, without running anything; empty if there is nothing to say.

        Raises SetUpError if there is no such plan.
        """
        found = json.loads(rpl_native.check(self.name, self.text))
        keys = Finding.__dataclass_fields__
        return [Finding(**{key: finding[key] for key in keys}) for finding in found]


class Mission(rpl_native.Mission):
    """A plan, the robot in its world, what happens there, and a seed.

    World, robot and scenario may be named as the command `rpl` names them: a built-in one, or a file; the scenario may
    be a text. The same arguments give the same mission, byte for byte. Without a world there is no robot. One thread at
    a time can use a mission; others go on meanwhile.

    `modules` are modules of the package `rpl-module` by the files of their manifests. They are called in this process,
    once for each step of the robot, and serve one mission at a time, the newest. A mission with modules cannot be
    forked or saved.

    Raises SetUpError with what was found, where, and what would be right.
    """

    def __new__(
        cls,
        plan: str | Plan,
        world: str | World | None = None,
        robot: str | Robot | None = None,
        seed: int = 1,
        scenario: str | Plan | None = None,
        modules: Mapping[str, Hearing] | None = None,
    ) -> Mission:
        plan = plan if isinstance(plan, Plan) else Plan(plan)
        scenario = scenario if isinstance(scenario, Plan | None) else Plan(scenario, "scenario.rpl")
        robot = Robot(robot) if isinstance(robot, str) else robot
        world = World(world, robot, seed) if isinstance(world, str) else world
        happening = None if scenario is None else (scenario.name, scenario.text)
        beside = [(file, opened(module)) for file, module in (modules or {}).items()]
        return super().__new__(cls, (plan.name, plan.text), world, robot, seed, happening, beside)

    def __init__(self, *_: Any, **__: Any) -> None:
        pass

    def fork(self) -> Mission:
        """A second mission that goes on from here by itself. It shares with this one what neither changes.

        Raises ValueError if there are modules in Python.
        """
        return rpl_native.Mission.__new__(type(self), ("", None), None, None, 0, None, [], self)

    def run(self, until_s: float = math.inf) -> str | None:
        """Goes on to the end, without the interpreter's lock, and gives the value of the plan.

        Raises PlanFailed, with the chain of causes, or TimeUp if the plan has not ended by a time of its own.
        """
        if not self.run_until(until_s):
            raise TimeUp(f"the plan has not ended by {until_s} s")
        failure = self.failure_json()
        if failure is not None:
            raise PlanFailed(json.loads(failure))
        return self.value

    @property
    def trace(self) -> pd.DataFrame:
        """All events so far: time [s], task, kind, and a column for each detail. Needs pandas."""
        import pandas as pd

        return pd.DataFrame(self.trace_columns())

    @property
    def trace_arrow(self) -> pa.Table:
        """The same as an Arrow table. Needs pyarrow."""
        import pyarrow as pa

        return pa.table(self.trace_columns())

    def figure(self) -> Figure:
        """The true path (solid), the estimated one (dashed) and the belief; notebooks show it.

        Raises ValueError without a robot.
        """
        svg = self.figure_svg()
        if svg is None:
            raise ValueError("there is no robot to draw; name a world")
        return Figure(svg)

    def _repr_svg_(self) -> str | None:
        return self.figure_svg()


@dataclass(frozen=True)
class Figure:
    """A drawing."""

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str) -> None:
        """Writes it into a file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.svg)
