"""The loop of a module: it hears of starts, stops and ticks, and tells what came of them."""

from __future__ import annotations

import json
import socket
import sys
import threading
import traceback
from typing import Any, BinaryIO, Callable, Dict, List, Optional, Type, TypeVar

from ._action import Action, Stopped
from ._values import Failure, Tick, Value, heard, python_name, said, tick_of

encode = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode

VERSION = 2
"""The version of the protocol."""

B = TypeVar("B", bound="Type[Behaviour]")
F = TypeVar("F", bound=Callable[[Tick], None])
Q = TypeVar("Q", bound=Callable[..., Value])

PARTING_S = 0.5
"""How long a behaviour of a live module has to clean up when the run is over."""


class Behaviour:
    """A behaviour at work: one object for each activation.

    A class has either ``run``, which may wait, or ``start`` and ``step``, which may not. An exception in any of them is
    shown on standard error and ends the behaviour with a failure.
    """

    def run(self, **arguments: Value) -> Value:
        """A plan activates it; the arguments are those that the plan gives. The behaviour ends when this returns, with
        the value that it returns. It waits by ``sleep`` and ``wait_until``; both raise ``Stopped`` once the plan does
        not need it any more."""
        raise NotImplementedError

    def sleep(self, duration_s: float) -> None:
        """Waits for so many seconds of the run, in ``run``; at the earliest for the next tick."""
        if self._action is None:
            raise RuntimeError("only a behaviour with `run` can sleep")
        self._action.sleep_us(round(duration_s * 1e6))

    def wait_until(self, condition: Callable[[], Any]) -> None:
        """Waits in ``run`` until a condition holds, which is looked at in each tick."""
        while not condition():
            self.sleep(0)

    def start(self, **arguments: Value) -> None:
        """A plan activates it; the arguments are those that the plan gives."""

    def step(self, tick: Tick) -> None:
        """The robot has made a step: also right after ``start``."""

    def stop(self, reason: str) -> None:
        """It is to end: ``"deactivated"``, or ``"interrupted"`` if its valve is lent to somebody else."""

    def succeed(self, value: Value = None) -> None:
        """It has done what it was asked to; nothing of it is called any more. The value is that of the call in the
        plan; without one it is ``t``."""
        self._ending = success(value)

    def fail(self, failure_class: str, message: str, /, **slots: Value) -> None:
        """It cannot do what it was asked to; ``raise Failure(...)`` does the same."""
        self._ending = failure(Failure(failure_class, message, **slots))

    def drive(self, translation_mps: float, rotation_radps: float) -> None:
        """What it wants of the wheels until its next step; its manifest names the valve ``wheels``."""
        self._drive = {"translation_mps": said(translation_mps), "rotation_radps": said(rotation_radps)}

    _ending: Optional[Dict[str, Any]] = None
    _drive: Optional[Dict[str, Any]] = None
    _action: Optional[Action] = None


def success(value: Value) -> Dict[str, Any]:
    return {"type": "success"} if value is None else {"type": "success", "value": said(value)}


def failure(raised: Failure) -> Dict[str, Any]:
    slots = {name: said(value) for name, value in raised.slots.items()}
    return {"type": "failure", "class": raised.failure_class, "message": raised.message, "slots": slots}


class Module:
    """A module: its behaviours and queries by their names, and its fluents."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.seed = 0
        """Of the run, for whatever is left to chance; known once the first tick comes."""
        self._classes: Dict[str, Type[Behaviour]] = {}
        self._queries: Dict[str, Callable[..., Value]] = {}
        self._in_lock_step = True
        # A behaviour of a live module with `run` says something beside the loop.
        self._speaking = threading.RLock()
        self._each_tick: Optional[Callable[[Tick], None]] = None
        self._has_failed_tick = False
        self._active: Dict[int, Behaviour] = {}
        self._fluents: Dict[str, Any] = {}
        self._said: Optional[List[Dict[str, Any]]] = None

    def behaviour(self, name: str) -> Callable[[B], B]:
        """Makes a class the behaviour of this name."""

        def named(behaviour: B) -> B:
            self._classes[name] = behaviour
            return behaviour

        return named

    def query(self, name: str) -> Callable[[Q], Q]:
        """Makes a function answer the query of this name: what it returns is the value of the call in the plan."""

        def named(function: Q) -> Q:
            self._queries[name] = function
            return function

        return named

    def each_tick(self, function: F) -> F:
        """Makes a function be called in each step of the robot, before the behaviours."""
        self._each_tick = function
        return function

    def set(self, fluent: str, value: Value) -> None:
        """Gives a fluent of the manifest a value; plans see it after the step."""
        with self._speaking:
            self._fluents[fluent] = said(value)

    def event(self, what: str, /, **details: Value) -> None:
        """Tells of something worth a line in the trace."""
        self._say({"type": "event", "what": what, "details": {name: said(value) for name, value in details.items()}})

    def run(self, input: Optional[BinaryIO] = None, output: Optional[BinaryIO] = None) -> None:
        """Works until the run is over. What is printed meanwhile goes to standard error."""
        lines = input if input is not None else sys.stdin.buffer
        answers = output if output is not None else sys.stdout.buffer
        printed, sys.stdout = sys.stdout, sys.stderr
        try:
            self._converse(lines, answers)
        finally:
            sys.stdout = printed

    def serve(self, address: str) -> None:
        """Waits at an address, such as ``"127.0.0.1:7400"``, for runs whose manifest connects to it, one after the other.

        What the program remembers stays from one run to the next.
        """
        host, _, port = address.rpartition(":")
        with socket.create_server((host.strip("[]"), int(port))) as server:
            while True:
                connection, _ = server.accept()
                # What belongs to one turn goes out at once, and is waited for.
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                with connection, connection.makefile("rb") as lines, connection.makefile("wb") as answers:
                    self._converse(lines, answers)

    def _converse(self, lines: BinaryIO, answers: BinaryIO) -> None:
        try:
            for line in lines:
                message = json.loads(line)
                said_now = self.hear(message)
                answers.write(b"".join(encode(answer).encode() + b"\n" for answer in said_now))
                # What belongs to one turn goes out at once: each part of it would wake rpl.
                if message["type"] in ("hello", "tick", "query"):
                    answers.flush()
                if message["type"] == "bye":
                    return
        except ConnectionError:
            # Nobody listens any more.
            pass
        self.hear({"type": "bye"})

    def hear(self, message: Dict[str, Any]) -> List[Dict[str, Any]]:
        """Takes in one message of the protocol, and gives the answers: for a program that has the module in it."""
        kind = message["type"]
        if kind == "hello":
            self.seed = message["seed"]
            self._in_lock_step = message["pace"] == "lock-step"
            self._active, self._fluents = {}, {}
            self._said = [{"type": "hello", "protocol": VERSION, "module": self.name}]
        elif kind == "start":
            self._start(message)
        elif kind == "stop":
            self._stop(message["id"], message["reason"])
        elif kind == "query":
            self._answer(message)
        elif kind == "tick":
            self._tick(message)
        elif kind == "bye":
            for activation in list(self._active):
                self._stop(activation, "deactivated", PARTING_S)
        with self._speaking:
            said_now, self._said = self._said or [], []
        return said_now

    def _start(self, message: Dict[str, Any]) -> None:
        activation, name = message["id"], message["behaviour"]
        behaviour = self._classes.get(name, Missing)()
        if isinstance(behaviour, Missing):
            behaviour.name = name
        self._active[activation] = behaviour
        arguments = {python_name(key): heard(value) for key, value in message["arguments"].items()}
        if type(behaviour).run is Behaviour.run:
            self._call(activation, lambda: behaviour.start(**arguments))
            return
        def work() -> None:
            value = behaviour.run(**arguments)
            if behaviour._ending is None:
                behaviour.succeed(value)

        behaviour._action = Action(
            lambda: self._end_with(behaviour, work), message["time_us"], self._in_lock_step
        )
        behaviour._action.begin()
        self._tell_end(activation)

    def _stop(self, activation: int, reason: str, patience_s: Optional[float] = None) -> None:
        behaviour = self._active.pop(activation, None)
        if behaviour is None:
            return
        try:
            if behaviour._action is not None:
                behaviour._action.stop(patience_s)
            behaviour.stop(reason)
        except Exception:
            # The plan does not wait for it any more: nobody is there to fail.
            traceback.print_exc()

    def _tick(self, message: Dict[str, Any]) -> None:
        tick = tick_of(message)
        if self._each_tick is not None:
            try:
                self._each_tick(tick)
            except Exception:
                # The behaviours go on: what the function would have set stays as it was. It is told once, for it may
                # be so in every step.
                if not self._has_failed_tick:
                    traceback.print_exc()
                self._has_failed_tick = True
        drive = None
        for activation, behaviour in list(self._active.items()):
            behaviour._drive = None
            if behaviour._action is not None:
                behaviour._action.tick(message["time_us"])
                self._tell_end(activation)
            else:
                self._call(activation, lambda: behaviour.step(tick))
            drive = behaviour._drive or drive
        with self._speaking:
            fluents, self._fluents = self._fluents, {}
        if fluents:
            self._say({"type": "fluents", "values": fluents})
        done: Dict[str, Any] = {"type": "done", "time_us": message["time_us"]}
        if drive is not None:
            done["drive"] = drive
        self._say(done)

    def _call(self, activation: int, method: Callable[[], None]) -> None:
        """Calls something of a behaviour, and tells of its end if it has ended."""
        behaviour = self._active.get(activation)
        if behaviour is not None:
            self._end_with(behaviour, method)
            self._tell_end(activation)

    def _end_with(self, behaviour: Behaviour, method: Callable[[], None]) -> None:
        """Calls something of a behaviour; if it raises something, that is how the behaviour ends."""
        try:
            method()
        except Failure as raised:
            behaviour._ending = failure(raised)
        except Stopped:
            # The plan does not wait for it any more.
            pass
        except Exception as mistake:
            behaviour._ending = self._mistake("the behaviour", mistake)

    def _tell_end(self, activation: int) -> None:
        behaviour = self._active[activation]
        if behaviour._action is not None and not behaviour._action.is_over:
            # What is said at the end of `run` comes before its end.
            return
        if behaviour._ending is not None:
            del self._active[activation]
            self._say({**behaviour._ending, "id": activation})

    def _answer(self, message: Dict[str, Any]) -> None:
        name = message["query"]
        try:
            if name not in self._queries:
                raise LookupError(f"no function answers the query {name!r}; put @module.query({name!r}) above one")
            value = self._queries[name](*(heard(value) for value in message["arguments"]))
            answer = {"type": "success", "value": said(value)}
        except Failure as raised:
            answer = failure(raised)
        except Exception as mistake:
            answer = self._mistake(f"the query {name!r}", mistake)
        self._say({**answer, "id": message["id"]})

    def _mistake(self, of: str, mistake: Exception) -> Dict[str, Any]:
        """The failure for an exception that nobody meant."""
        traceback.print_exc()
        why = f"{type(mistake).__name__}: {mistake}"
        message = f"{of} has a mistake: {why}; its traceback is on standard error"
        return failure(Failure("module-failure", message, module=self.name, reason=why))

    def _say(self, message: Dict[str, Any]) -> None:
        with self._speaking:
            if self._said is None:
                raise RuntimeError("the module does not run yet; call `run()` first")
            self._said.append(message)


class Missing(Behaviour):
    """Stands for a behaviour that the manifest has and the module has not."""

    name = ""

    def start(self, **arguments: Value) -> None:
        raise LookupError(f"no class is the behaviour {self.name!r}; put @module.behaviour({self.name!r}) above one")
