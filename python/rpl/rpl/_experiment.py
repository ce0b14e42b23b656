"""Experiments: a plan over many seeds, here or on a cluster of Ray.

A shard is `rpl experiment --shard` in a process of its own, on Ray a task that is done again if its worker dies. What
comes back is put together by `rpl experiment merge`; so the table is that of one machine, byte for byte.
"""

from __future__ import annotations

import json
import os
import platform
import tempfile
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._command import CommandError, output_of
from .rpl_native import BUILD

if TYPE_CHECKING:
    import pandas as pd

#: A shard of so many runs takes long enough for what a task costs beside it.
RUNS_IN_A_SHARD = 200

#: Tasks that Ray knows of at a time, and parts that are put together at a time: looking through more than that, once
#: for each that is done, would cost more than they do.
AT_A_TIME = 1_000


class Experiment:
    """What came of an experiment. Its runs are in a folder for temporary files as long as it lives."""

    def __init__(self, parts: _Parts) -> None:
        self._parts = parts
        #: The table, as `rpl experiment` prints it.
        self.table: str = parts.merged()

    def __str__(self) -> str:
        return self.table

    def __repr__(self) -> str:
        return self.table

    @cached_property
    def figures(self) -> dict[str, Any]:
        """Every figure of the table (docs/json.md)."""
        figures: dict[str, Any] = json.loads(self._parts.merged("--json"))
        return figures

    @cached_property
    def runs(self) -> pd.DataFrame:
        """A row for each run. Needs pandas."""
        import pandas as pd

        self._parts.merged("--results", "results")
        return pd.read_csv(self._parts.path("results") / "runs.csv")


class Progress:
    """How far an experiment has come."""

    def __init__(self, done: int, of: int, parts: _Parts) -> None:
        #: Shards that are done.
        self.done = done
        #: Shards that there are.
        self.of = of
        self._parts = parts

    def table(self) -> str:
        """The table of the runs that are done."""
        return self._parts.merged()


def experiment(
    name: str,
    row: str | None = None,
    seeds: range | int = 20,
    *,
    world: str | None = None,
    robot: str | None = None,
    scenario: str | None = None,
    cases: str | None = None,
    until: str | None = None,
    files: Sequence[str] = (),
    on: Any = None,
    shard: int = RUNS_IN_A_SHARD,
    progress: Callable[[Progress], None] | None = None,
) -> Experiment:
    """Runs an experiment with a name, or a plan, over seeds; one row of it if that is named.

    `seeds` is how many, from 1 on, or a range without gaps. The files that are named are sent along, and `files` are
    those that the plan loads. Without `on` the runs are done on all cores here; `on=ray` makes a task of every `shard`
    runs. `progress` is called after each shard.

    Raises CommandError with what the command says, and ValueError if the seeds have gaps.
    """
    seeds = range(1, seeds + 1) if isinstance(seeds, int) else seeds
    if seeds.step != 1 or len(seeds) == 0:
        raise ValueError(f"{seeds} has no seeds, or gaps; a range such as range(1, 1001) is expected")
    if shard < 1:
        raise ValueError("a shard has at least one run")
    sent = _Files()
    words = [sent.named(name), "--runs", str(len(seeds)), "--seed", str(seeds.start)]
    for option, value in {"--world": world, "--robot": robot, "--scenario": scenario, "--cases": cases}.items():
        words += [] if value is None else [option, sent.named(value)]
    for option, value in {"--row": row, "--until": until}.items():
        words += [] if value is None else [option, value]
    for file in files:
        sent.named(file)
    # Here the command itself runs on all cores.
    runs_in_a_shard = shard if on is not None else shard * (os.cpu_count() or 1)
    count = -(-len(seeds) // runs_in_a_shard)
    parts = _Parts(sent)
    done = _here(words, sent, count) if on is None else _on_ray(on, words, sent, count)
    for number, part in enumerate(done, 1):
        parts.add(part)
        if progress is not None:
            progress(Progress(number, count, parts))
    return Experiment(parts)


class _Files:
    """The files that shards need, in one folder without folders in it."""

    def __init__(self) -> None:
        self.contents: dict[str, bytes] = {}

    def named(self, name: str) -> str:
        """What the shard calls what is called so here. What is no file has a name of its own."""
        path = Path(name)
        if not path.is_file():
            return name
        content = path.read_bytes()
        if self.contents.setdefault(path.name, content) != content:
            raise ValueError(f"two files are called {path.name}; give one of them another name")
        return path.name

    def put(self, folder: str) -> None:
        for name, content in self.contents.items():
            Path(folder, name).write_bytes(content)


class _Parts:
    """The parts that have come, in a folder of their own."""

    def __init__(self, files: _Files) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="rpl-")
        # Where parts are merged a robot file must be.
        files.put(self._folder.name)
        self._many: list[str] = []
        self._single: list[str] = []
        self._count = 0

    def path(self, name: str) -> Path:
        return Path(self._folder.name, name)

    def add(self, part: bytes) -> None:
        name = self._next_name()
        self.path(name).write_bytes(part)
        self._single.append(name)
        if len(self._single) == AT_A_TIME:
            name = self._next_name()
            output_of(["experiment", "merge", *self._single, "--out", name], self._folder.name)
            self._many.append(name)
            while self._single:
                self.path(self._single.pop()).unlink()

    def merged(self, *words: str) -> str:
        return output_of(["experiment", "merge", *self._many, *self._single, *words], self._folder.name)

    def _next_name(self) -> str:
        self._count += 1
        return f".{self._count}.part"


def _here(words: list[str], files: _Files, count: int) -> Iterator[bytes]:
    for number in range(1, count + 1):
        yield _part(BUILD, words, files, number, count, None)


def _on_ray(ray: Any, words: list[str], files: _Files, count: int) -> Iterator[bytes]:
    """The parts as they come."""
    sent = ray.put(files)
    # A worker that dies has finished nothing; Ray does its task again, however often.
    task = ray.remote(num_cpus=1, max_retries=-1)(_part)
    numbers = iter(range(1, count + 1))
    waiting: list[Any] = []
    try:
        while True:
            room = max(AT_A_TIME, 2 * int(ray.cluster_resources().get("CPU", 0))) - len(waiting)
            waiting += [task.remote(BUILD, words, sent, number, count, 1) for number in islice(numbers, room)]
            if not waiting:
                return
            done, waiting = ray.wait(waiting, num_returns=1)
            for reference in done:
                yield ray.get(reference)
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None
    finally:
        for reference in waiting:
            ray.cancel(reference, force=True)


def _part(build: str, words: list[str], files: _Files, number: int, of: int, cores: int | None) -> bytes:
    """Does a shard in a folder of its own, on so many cores or on all, and gives its part."""
    if build != BUILD:
        raise CommandError(
            f"{platform.node()} has rpl {BUILD}, and the experiment is one of rpl {build}; install the same on both"
        )
    with tempfile.TemporaryDirectory(prefix="rpl-shard-") as folder:
        files.put(folder)
        at_a_time = [] if cores is None else ["--jobs", str(cores)]
        # The threads of a run would have the cores of other workers.
        threads = None if cores is None else 1
        output_of(["experiment", *words, *at_a_time, "--shard", f"{number}/{of}", "--out", ".part"], folder, threads)
        return Path(folder, ".part").read_bytes()
