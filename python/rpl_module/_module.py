"""The loop of a module: it hears of starts, stops and ticks, and tells what came of them."""

from __future__ import annotations

import json
import sys
import traceback
from typing import Any, BinaryIO, Callable, Dict, List, Optional, Type, TypeVar

from ._values import Failure, Tick, Value, heard, python_name, said, tick_of

encode = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode

VERSION = 1
"""The version of the protocol."""

B = TypeVar("B", bound="Type[Behaviour]")
F = TypeVar("F", bound=Callable[[Tick], None])


class Behaviour:
    """A behaviour at work: one object for each activation.

    An exception in any of its methods is shown on standard error and ends it with a failure.
    """

    def start(self, **arguments: Value) -> None:
        """A plan activates it; the arguments are those that the plan gives."""

    def step(self, tick: Tick) -> None:
        """The robot has made a step: also right after ``start``."""

    def stop(self, reason: str) -> None:
        """It is to end: ``"deactivated"``, or ``"interrupted"`` if its valve is lent to somebody else."""

    def succeed(self) -> None:
        """It has done what it was asked to; nothing of it is called any more."""
        self._ending = {"type": "success"}

    def fail(self, failure_class: str, message: str, **slots: Value) -> None:
        """It cannot do what it was asked to; ``raise Failure(...)`` does the same."""
        self._ending = failure(Failure(failure_class, message, **slots))

    def drive(self, translation_mps: float, rotation_radps: float) -> None:
        """What it wants of the wheels until its next step; its manifest names the valve ``wheels``."""
        self._drive = {"translation_mps": said(translation_mps), "rotation_radps": said(rotation_radps)}

    _ending: Optional[Dict[str, Any]] = None
    _drive: Optional[Dict[str, Any]] = None


def failure(raised: Failure) -> Dict[str, Any]:
    slots = {name: said(value) for name, value in raised.slots.items()}
    return {"type": "failure", "class": raised.failure_class, "message": raised.message, "slots": slots}


class Module:
    """A module: its behaviours by their names, and its fluents."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.seed = 0
        """Of the run, for whatever is left to chance; known once the first tick comes."""
        self._classes: Dict[str, Type[Behaviour]] = {}
        self._each_tick: Optional[Callable[[Tick], None]] = None
        self._active: Dict[int, Behaviour] = {}
        self._fluents: Dict[str, Any] = {}
        self._said: Optional[List[Dict[str, Any]]] = None

    def behaviour(self, name: str) -> Callable[[B], B]:
        """Makes a class the behaviour of this name."""

        def named(behaviour: B) -> B:
            self._classes[name] = behaviour
            return behaviour

        return named

    def each_tick(self, function: F) -> F:
        """Makes a function be called in each step of the robot, before the behaviours."""
        self._each_tick = function
        return function

    def set(self, fluent: str, value: Value) -> None:
        """Gives a fluent of the manifest a value; plans see it after the step."""
        self._fluents[fluent] = said(value)

    def event(self, what: str, **details: Value) -> None:
        """Tells of something worth a line in the trace."""
        self._say({"type": "event", "what": what, "details": {name: said(value) for name, value in details.items()}})

    def run(self, input: Optional[BinaryIO] = None, output: Optional[BinaryIO] = None) -> None:
        """Works until the run is over. What is printed meanwhile goes to standard error."""
        lines = input if input is not None else sys.stdin.buffer
        answers = output if output is not None else sys.stdout.buffer
        printed, sys.stdout = sys.stdout, sys.stderr
        try:
            for line in lines:
                message = json.loads(line)
                said_now = self.hear(message)
                answers.write(b"".join(encode(answer).encode() + b"\n" for answer in said_now))
                # What belongs to one turn goes out at once: each part of it would wake rpl.
                if message["type"] in ("hello", "tick"):
                    answers.flush()
                if message["type"] == "bye":
                    return
            self.hear({"type": "bye"})
        except BrokenPipeError:
            # Nobody listens any more.
            pass
        finally:
            sys.stdout = printed

    def hear(self, message: Dict[str, Any]) -> List[Dict[str, Any]]:
        """Takes in one message of the protocol, and gives the answers: for a program that has the module in it."""
        kind = message["type"]
        if kind == "hello":
            self.seed = message["seed"]
            self._active, self._fluents = {}, {}
            self._said = [{"type": "hello", "protocol": VERSION, "module": self.name}]
        elif kind == "start":
            self._start(message)
        elif kind == "stop":
            self._stop(message["id"], message["reason"])
        elif kind == "tick":
            self._tick(message)
        elif kind == "bye":
            for activation in list(self._active):
                self._stop(activation, "deactivated")
        said_now, self._said = self._said or [], []
        return said_now

    def _start(self, message: Dict[str, Any]) -> None:
        activation, name = message["id"], message["behaviour"]
        behaviour = self._classes.get(name, Missing)()
        if isinstance(behaviour, Missing):
            behaviour.name = name
        self._active[activation] = behaviour
        arguments = {python_name(key): heard(value) for key, value in message["arguments"].items()}
        self._call(activation, lambda: behaviour.start(**arguments))

    def _stop(self, activation: int, reason: str) -> None:
        behaviour = self._active.pop(activation, None)
        if behaviour is None:
            return
        try:
            behaviour.stop(reason)
        except Exception:
            # The plan does not wait for it any more: nobody is there to fail.
            traceback.print_exc()

    def _tick(self, message: Dict[str, Any]) -> None:
        tick = tick_of(message)
        if self._each_tick is not None:
            self._each_tick(tick)
        drive = None
        for activation, behaviour in list(self._active.items()):
            behaviour._drive = None
            self._call(activation, lambda: behaviour.step(tick))
            drive = behaviour._drive or drive
        if self._fluents:
            self._say({"type": "fluents", "values": self._fluents})
            self._fluents = {}
        done: Dict[str, Any] = {"type": "done", "time_us": message["time_us"]}
        if drive is not None:
            done["drive"] = drive
        self._say(done)

    def _call(self, activation: int, method: Callable[[], None]) -> None:
        """Calls something of a behaviour, and tells of its end if it has ended."""
        behaviour = self._active.get(activation)
        if behaviour is None:
            return
        try:
            method()
        except Failure as raised:
            behaviour._ending = failure(raised)
        except Exception as mistake:
            traceback.print_exc()
            why = f"{type(mistake).__name__}: {mistake}"
            message = f"the behaviour has a mistake: {why}; its traceback is on standard error"
            behaviour._ending = failure(Failure("module-failure", message, module=self.name, reason=why))
        if behaviour._ending is not None:
            del self._active[activation]
            self._say({**behaviour._ending, "id": activation})

    def _say(self, message: Dict[str, Any]) -> None:
        if self._said is None:
            raise RuntimeError("the module does not run yet; call `run()` first")
        self._said.append(message)


class Missing(Behaviour):
    """Stands for a behaviour that the manifest has and the module has not."""

    name = ""

    def start(self, **arguments: Value) -> None:
        raise LookupError(f"no class is the behaviour {self.name!r}; put @module.behaviour({self.name!r}) above one")
