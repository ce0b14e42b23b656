"""A robot of one's own: what its user writes."""

from __future__ import annotations

import abc
import argparse
import functools
import signal
import socket
import sys
import threading
from pathlib import Path
from types import FrameType
from typing import Any, Dict, List, Mapping, Optional, Union

from ._connection import address_of
from ._guard import SILENCE_S
from ._reading import Reading, Signal
from ._server import Record, Server, Service
from ._words import token_of


class Host(abc.ABC):
    """A robot that missions drive, one at a time.

    All methods are called in the thread that serves, ``drive`` and ``read`` once a period. While one of them works
    nobody else can stop the motors, unless ``halts_any_time``: each has to return well within a period. An exception
    of theirs ends the host, with the motors off, and the mission hears it.
    """

    robot: str
    """The ``name`` in the robot's file."""
    period_s: float = 0.05
    """From one percept to the next, in the robot's time; the ``step`` in the robot's file."""
    start_known: bool = False
    """Whether the robot stands where the world says that it starts. Only the first mission is told."""
    halts_any_time: bool = False
    """Whether ``halt`` may be called from another thread while a method works. Then it is, when that takes too long."""

    @abc.abstractmethod
    def read(self) -> Reading:
        """What the robot perceives now."""

    @abc.abstractmethod
    def drive(self, translation_mps: float, rotation_radps: float) -> None:
        """The speeds that are wanted until the next call: ahead, and counter-clockwise."""

    def step(self) -> None:
        """A simulator lets a period pass, and takes in what ``drive`` has said. Only simulators have it."""

    def halt(self) -> None:
        """The motors are to be off: also called when they are off already. Who has brakes closes them here."""
        self.drive(0.0, 0.0)

    def sonars(self, on: bool) -> None:
        """The sonars are to fire, or not; what ``sonar_m`` says without is told to nobody."""

    def grasp(self, thing: str) -> None:
        """The gripper is to begin to take a thing; ``gripper`` and ``holding`` of the readings say how it goes."""

    def release(self) -> None:
        """The gripper is to begin to let go."""

    def look(self, pan_radps: Optional[float]) -> None:
        """The camera is to be on and to turn so fast, counter-clockwise, or to be off."""

    def actuate(self, others: Mapping[str, Signal]) -> None:
        """What actuators of other kinds are to do, all of them, by their names; none once the motors are off."""

    def tell(self, notice: str) -> None:
        """Something happened that whoever watches the host wants to know."""
        print(notice, file=sys.stderr, flush=True)

    def is_stepped(self) -> bool:
        """Whether this is a simulator that has ``step``."""
        return type(self).step is not Host.step

    def stop(self) -> None:
        """Ends ``serve`` soon, from any thread."""
        self._stopped.set()

    @functools.cached_property
    def _stopped(self) -> threading.Event:
        # Not in a constructor: that of a subclass need not call that of this class.
        return threading.Event()

    def serve(
        self,
        listen: Union[str, socket.socket] = "127.0.0.1:7300",
        *,
        factor: float = 1.0,
        patience_s: float = 60.0,
        token: Optional[str] = None,
        once: bool = False,
    ) -> Record:
        """Serves missions until SIGINT, SIGTERM or ``stop``; then the motors are off.

        ``listen`` is an address, where port 0 is one that is free, or a socket that listens already.
        ``factor`` is how many seconds of the robot pass in one on the wall. A mission that gives no commands for
        ``patience_s`` has lost the robot. ``once`` ends when the first mission has gone and the robot stands.
        """
        if not isinstance(getattr(self, "robot", None), str):
            raise TypeError(f"`robot` of {type(self).__name__} is to be the `name` in the robot's file")
        for name, value, least in (
            ("period_s", self.period_s, 0.0), ("factor", factor, 0.0), ("patience_s", patience_s, SILENCE_S),
        ):
            if not least < value < float("inf"):
                raise ValueError(f"`{name}` is {value}, and a number above {least} is expected")
        service = Service(
            factor=factor,
            patience_s=patience_s,
            start_known=self.start_known,
            token=None if token is None else token_of(token),
            once=once,
        )
        listener = listening_at(listen) if isinstance(listen, str) else listen
        print(f"listening at {address_of(listener.getsockname())}", flush=True)
        with Signals(self):
            record = Server(self, listener, service, self._stopped.is_set).run()
        self.tell(str(record))
        return record

    def main(self, arguments: Optional[List[str]] = None) -> None:
        """Serves as the command line says."""
        options = argparse.ArgumentParser(description=type(self).__doc__)
        options.add_argument("--listen", metavar="ADDRESS", default="127.0.0.1:7300", help="where missions connect")
        options.add_argument("--speed", metavar="FACTOR", type=float, default=1.0, help="of the time of a simulator")
        options.add_argument("--patience", metavar="SECONDS", type=float, default=60.0, help="with a silent mission")
        options.add_argument("--token-file", metavar="FILE", type=Path, help="missions have to know the same token")
        options.add_argument("--once", action="store_true", help="end when the first mission has gone")
        given = options.parse_args(arguments)
        self.serve(
            given.listen,
            factor=given.speed,
            patience_s=given.patience,
            token=None if given.token_file is None else given.token_file.read_text(),
            once=given.once,
        )


def listening_at(address: str) -> socket.socket:
    name, _, port = address.rpartition(":")
    family = socket.AF_INET6 if ":" in name else socket.AF_INET
    return socket.create_server((name.strip("[]"), int(port)), family=family)


class Signals:
    """SIGINT and SIGTERM stop a host, where signals can be handled at all; a second one ends the process."""

    def __init__(self, host: Host) -> None:
        self._host = host
        self._before: Dict[int, Any] = {}

    def __enter__(self) -> None:
        if threading.current_thread() is threading.main_thread():
            self._before = {of: signal.signal(of, self._ask) for of in (signal.SIGINT, signal.SIGTERM)}

    def _ask(self, number: int, frame: Optional[FrameType]) -> None:
        self._host.stop()
        # Whoever waits for a method of the robot that does not return says it again: that is an exception in there.
        signal.signal(number, signal.default_int_handler)

    def __exit__(self, *error: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
