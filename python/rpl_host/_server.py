"""A host served over TCP at the pace of the clock on the wall.

Everything is done in one thread, that of the caller, so that ``read`` and ``drive`` of a robot are never called from
another one. No socket is waited for: nobody who is connected can hold the robot up.

Whoever connects stands at the door until a greeting has come; only a greeting takes the robot. The world stands still
until the first mission gives its first commands, and goes on from then, whether a mission is there or not. Time and
odometry begin anew for each mission.
"""

from __future__ import annotations

import selectors
import socket
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Callable, Dict, List, Optional

from ._connection import LINE_S, Connection, LineFault, address_of
from ._guard import Guard, Halt
from ._reading import Perceived, Perception
from ._watchdog import Watchdog
from ._words import PROTOCOL, Bye, Commands, Hello, WordsError, bye, heard, line_of, shortened

if TYPE_CHECKING:
    from ._host import Host

GREETING_S = 5.0
"""Whoever connects says who it is within this time."""

BLIND_S = 2.0
"""A mission that has not taken in the percepts of this time drives blindly: its commands count for nothing."""

MOST_UNSENT = 600
"""Percepts that wait to be sent, at most."""

MOST_AT_DOOR = 64
"""More cannot wait without a greeting: whoever has waited longest has to go. As many may be on their way out."""

LOOK_EVERY_S = 0.05
"""How often it is looked whether the host is to end."""

MOST_BEHIND_S = 0.5
"""A host that is so far behind the clock goes on from there and does not hurry."""

TELL_REFUSALS_EVERY_S = 1.0

TELL_DELAYS_EVERY_S = 10.0

FAREWELL_S = 0.5
"""At its end the host waits so long for the others to hear why."""

clock: Callable[[], float] = time.monotonic


@dataclass(frozen=True)
class Service:
    """How a host is served."""

    factor: float = 1.0
    patience_s: float = 60.0
    start_known: bool = False
    token: Optional[str] = None
    once: bool = False


@dataclass
class Record:
    """How it went."""

    missions: int = 0
    """Those that gave commands."""
    percepts: int = 0
    delays: int = 0
    """How often the host was too far behind the clock."""
    halts: Dict[Halt, int] = field(default_factory=dict)
    """How often the motors were cut, and why."""

    def __str__(self) -> str:
        halts = "".join(f"; motors cut {count} time(s): {halt.value}" for halt, count in self.halts.items() if count)
        return f"{self.missions} mission(s), {self.percepts} percepts, {self.delays} delay(s) of the host itself{halts}"


class Seldom:
    """Tells what may happen many times a second: once, and then how often it has happened since."""

    def __init__(self, tell: Callable[[str], None], every_s: float) -> None:
        self._tell = tell
        self._every_s = every_s
        self._told_s: Optional[float] = None
        self._untold = 0

    def tell(self, notice: str) -> None:
        if self._told_s is not None and clock() - self._told_s < self._every_s:
            self._untold += 1
            return
        more = f" (and {self._untold} more like it before)" if self._untold else ""
        self._told_s, self._untold = clock(), 0
        self._tell(notice + more)


class Mission:
    """The mission that has the robot."""

    def __init__(self, connection: Connection, hello: Hello, now_s: float) -> None:
        self.connection = connection
        name = "a mission without a name" if hello.mission is None else f"`{shortened(hello.mission)}`"
        self.who = f"{name} from {connection.address}"
        self.since_s = self.heard_s = now_s
        self.began: Optional[Perceived] = None
        """What was perceived when its first commands came."""
        self.next = 0
        """The number of its next percept."""
        self.newest: Optional[Commands] = None
        self._order: object = None
        self.messages: List[List[str]] = []
        """What people have sent, and it has not been told."""

    def newest_is(self, commands: Commands) -> None:
        """Commands that come between two periods replace each other, but the gripper is told what it was told."""
        self._order = commands.gripper or self._order
        self.newest = commands

    def take_order(self) -> object:
        """What the gripper is to begin, if anything."""
        order, self._order = self._order, None
        return order


class Server:
    """A host that is served."""

    def __init__(self, host: Host, listener: socket.socket, service: Service, is_stopped: Callable[[], bool]) -> None:
        listener.setblocking(False)
        self.host = host
        self.service = service
        self.record = Record()
        self._is_stopped = is_stopped
        self._listener = listener
        self._selector = selectors.DefaultSelector()
        self._selector.register(listener, selectors.EVENT_READ)
        self._door: Dict[Connection, None] = {}
        self._leaving: Dict[Connection, None] = {}
        self._mission: Optional[Mission] = None
        self._guard = Guard()
        self._perception = Perception()
        self._actuators = Actuators(host)
        self._watchdog = Watchdog(host.halt if host.halts_any_time else None)
        self._began_s = self._polled_s = clock()
        self._steps = 0
        self._refusals = Seldom(host.tell, TELL_REFUSALS_EVERY_S)
        self._delays = Seldom(host.tell, TELL_DELAYS_EVERY_S)

    def run(self) -> Record:
        """Serves until it is told to stop, or the robot's methods raise; then the motors are off."""
        why: Optional[str] = None
        try:
            self._actuators.halt()
            with self._watchdog:
                self._run()
        except BaseException as error:
            why = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
            raise
        finally:
            try:
                self._actuators.halt()
            finally:
                self._close(why)
        return self.record

    def _run(self) -> None:
        period_s = self.host.period_s / self.service.factor
        due_s: Optional[float] = None
        while not self._is_stopped() and not self._is_over():
            wakes = (clock() + LOOK_EVERY_S, due_s, self._guard.silent_at_s())
            self._listen_until(min(wake_s for wake_s in wakes if wake_s is not None))
            now_s = clock()
            self._cut_motors(self._guard.look_at_clock(now_s))
            self._look_at_connections(now_s)
            if self.record.missions == 0 or (due_s is not None and now_s < due_s):
                continue
            # While the robot's methods work nothing is heard: the silence begins where it would anyway.
            self._watchdog.expect(self._guard.silent_at_s())
            self._step()
            self._watchdog.expect(None)
            due_s = (now_s if due_s is None else due_s) + period_s
            took_s = clock() - now_s
            if clock() > due_s + MOST_BEHIND_S:
                self.record.delays += 1
                self._delays.tell(
                    f"the host is behind: this time `drive`, `step` and `read` took {took_s:.3f} s, and there are "
                    f"{period_s:.3f} s"
                )
                due_s = clock()

    def _is_over(self) -> bool:
        stands = self._perception.last is None or self._perception.last.stands()
        return self.service.once and self.record.missions > 0 and self._mission is None and stands

    # The robot.

    def _step(self) -> None:
        commands = self._mission.newest if self._mission is not None else None
        order = self._mission.take_order() if self._mission is not None else None
        self._actuators.apply(commands, order, self._guard.halt)
        self.host.step()
        self._steps += 1
        perceived = self._read()
        self._cut_motors(self._guard.look_at_bumper(perceived.is_bumped, perceived.stands()))
        self.record.percepts += 1
        if self._mission is not None and self._mission.began is not None:
            self._send(self._mission, self._mission.began, perceived)

    def _read(self) -> Perceived:
        reading = self.host.read()
        if self.host.is_stepped():
            time_s = self._steps * self.host.period_s
        else:
            time_s = (clock() - self._began_s) * self.service.factor
        return self._perception.take(reading, time_s)

    def _send(self, mission: Mission, began: Perceived, perceived: Perceived) -> None:
        percept = perceived.percept(began, self._actuators.sonars_on)
        messages = mission.messages + percept.pop("messages", [])
        mission.messages = []
        if messages:
            percept["messages"] = messages
        if mission.newest is not None:
            percept["commands"] = mission.newest.number
        mission.connection.send(line_of("percept", {"number": mission.next, **percept}), clock())
        mission.next += 1
        if mission.connection.unsent() > MOST_UNSENT:
            self._leave("it does not take what the robot perceives")

    def _cut_motors(self, halt: Optional[Halt]) -> None:
        if halt is not None:
            self._actuators.halt()
            self.host.tell(f"the motors are off: {halt.value}")

    # Those who are connected.

    def _listen_until(self, wake_s: float) -> None:
        # What is there already may have come at any time since it was looked last, and counts from then: the robot's
        # methods may have taken long.
        ready, came_s = self._selector.select(0), self._polled_s
        if not ready:
            ready, came_s = self._selector.select(max(0.0, wake_s - clock())), clock()
        self._polled_s = clock()
        for key, _ in ready:
            if key.data is None:
                self._let_in()
            # Somebody else who was ready may have sent it away.
            elif key.fileobj in self._selector.get_map():
                self._serve(key.data, came_s)

    def _let_in(self) -> None:
        try:
            stream, address = self._listener.accept()
        except OSError as error:
            if not isinstance(error, (BlockingIOError, InterruptedError, ConnectionAbortedError)):
                self._refusals.tell(f"nobody can be let in for now: {error}")
                # The listener stays ready: without a pause nothing else would be done.
                time.sleep(0.01)
            return
        if len(self._door) >= MOST_AT_DOOR:
            longest = next(iter(self._door))
            self._refuse(longest, f"{MOST_AT_DOOR} wait without a greeting; {longest.address}")
        connection = Connection(stream, address_of(address), clock())
        self._selector.register(stream, selectors.EVENT_READ, connection)
        self._door[connection] = None

    def _serve(self, connection: Connection, came_s: float) -> None:
        connection.flush()
        try:
            for line in connection.receive(clock()):
                if connection.leaves_by_s is None:
                    self._take(connection, line, came_s)
        except LineFault as fault:
            self._end(connection, str(fault))

    def _take(self, connection: Connection, line: bytes, came_s: float) -> None:
        try:
            message = heard(line)
        except WordsError as error:
            raise LineFault(f"it has sent what is no message: {error}") from None
        if isinstance(message, Bye):
            raise LineFault(message.told())
        mission = self._mission
        if mission is not None and mission.connection is connection:
            if isinstance(message, Hello):
                raise LineFault("it greets a second time")
            self._command(mission, message, came_s)
        elif isinstance(message, Commands):
            raise LineFault("it commands before it greets")
        else:
            self._greet(connection, message)

    def _greet(self, connection: Connection, hello: Hello) -> None:
        unfit = hello.unfit(self.host.robot, self.service.token)
        if unfit is not None:
            return self._refuse(connection, f"{connection.address} {unfit}")
        now_s = clock()
        if self._mission is not None:
            since_s = now_s - self._mission.since_s
            who = f"another mission is here: {self._mission.who}, since {since_s:.0f} s"
            return self._refuse(connection, f"{who}; {connection.address} has to wait")
        del self._door[connection]
        self._mission = Mission(connection, hello, now_s)
        answer = {
            "protocol": PROTOCOL,
            "robot": self.host.robot,
            "period_us": round(self.host.period_s * 1e6),
            "factor": self.service.factor,
            "start_known": self.service.start_known and self.record.missions == 0,
        }
        connection.send(line_of("hello", answer), now_s)
        self.host.tell(f"here is {self._mission.who}")

    def _command(self, mission: Mission, commands: Commands, came_s: float) -> None:
        behind = mission.next - commands.number
        if behind < 0:
            raise LineFault(f"it answers up to percept {commands.number}, and {mission.next} is the next that is sent")
        if mission.began is None:
            self.record.missions += 1
            mission.began = self._perception.last
            if mission.began is None:
                mission.began = self._read()
                mission.messages = mission.began.rest.get("messages", [])
        mission.newest_is(commands)
        # Who has not seen where the robot is now is as good as silent.
        if behind * self.host.period_s / self.service.factor <= min(BLIND_S, self.service.patience_s):
            mission.heard_s = max(mission.heard_s, came_s)
            self._guard.heard(came_s)

    def _look_at_connections(self, now_s: float) -> None:
        greeting_s = min(GREETING_S, self.service.patience_s)
        line_s = min(LINE_S, self.service.patience_s)
        for key in list(self._selector.get_map().values()):
            connection = key.data
            if connection is None:
                continue
            if connection.leaves_by_s is not None:
                if connection.unsent() == 0:
                    connection.close_for_writing()
                if now_s > connection.leaves_by_s:
                    self._forget(connection)
                    continue
            else:
                try:
                    connection.look(now_s, line_s)
                    if connection in self._door and now_s - connection.since_s > greeting_s:
                        raise LineFault(f"it has not greeted within {greeting_s:.1f} s")
                except LineFault as fault:
                    self._end(connection, str(fault))
                    continue
            write = selectors.EVENT_WRITE if connection.unsent() else 0
            if key.events != selectors.EVENT_READ | write:
                self._selector.modify(connection.stream, selectors.EVENT_READ | write, connection)
        patience_s = self.service.patience_s
        if self._mission is not None and now_s - self._mission.heard_s > patience_s:
            self._leave(f"it has given no commands for {patience_s:.1f} s")

    def _end(self, connection: Connection, why: str) -> None:
        if connection.leaves_by_s is not None:
            self._forget(connection)
        elif self._mission is not None and self._mission.connection is connection:
            self._leave(why)
        else:
            self._refuse(connection, f"{connection.address}: {why}")

    def _leave(self, why: str) -> None:
        """The mission has to go, or has gone: the motors are off."""
        mission, self._mission = self._mission, None
        if mission is None:
            return
        if mission.began is not None:
            self._guard.line_closed()
        self._actuators.halt()
        self._show_out(mission.connection, why)
        self.host.tell(f"{mission.who} has gone: {why}")

    def _refuse(self, connection: Connection, why: str) -> None:
        del self._door[connection]
        self._show_out(connection, why)
        self._refusals.tell(f"refused: {why}")

    def _show_out(self, connection: Connection, why: Optional[str]) -> None:
        """Tells somebody why to go. What it has to hear before that is written first, if that does not take long."""
        if len(self._leaving) >= MOST_AT_DOOR:
            self._forget(next(iter(self._leaving)))
        now_s = clock()
        connection.leaves_by_s = now_s + LINE_S
        self._leaving[connection] = None
        connection.send(bye(why), now_s)

    def _forget(self, connection: Connection) -> None:
        del self._leaving[connection]
        self._selector.unregister(connection.stream)
        connection.stream.close()

    def _close(self, why: Optional[str]) -> None:
        """The host has ended: everybody hears why, if that goes soon."""
        self.record.halts = dict(self._guard.counts)
        self._listener.close()
        self._selector.unregister(self._listener)
        here = list(self._door) + ([] if self._mission is None else [self._mission.connection])
        self._door, self._mission = {}, None
        for connection in here:
            self._show_out(connection, why or "the host has ended")
        until_s = clock() + FAREWELL_S
        while self._leaving and clock() < until_s:
            self._look_at_connections(clock())
            for key, _ in self._selector.select(LOOK_EVERY_S):
                self._serve(key.data, 0.0)
        for connection in list(self._leaving):
            self._forget(connection)
        self._selector.close()


class Actuators:
    """What the host was told last: what has not changed is told once, but for the speeds."""

    def __init__(self, host: Host) -> None:
        self._host = host
        self.sonars_on = False
        self._pan_radps: Optional[float] = None
        self._others: Dict[str, object] = {}

    def apply(self, commands: Optional[Commands], order: object, halt: Optional[Halt]) -> None:
        """Tells the robot what a mission wants, as far as it may."""
        self._sonars(commands is not None and commands.sonars_on)
        if commands is None or halt not in (None, Halt.BUMPER):
            self._look(None)
            return self.halt()
        # After a bump a mission that is there still has its hand and its eye.
        self._look(commands.pan_radps)
        if isinstance(order, dict):
            self._host.grasp(order["grasp"])
        elif order is not None:
            self._host.release()
        if halt is not None:
            return self.halt()
        others = commands.others or {}
        if others != self._others:
            self._others = others
            self._host.actuate(others)
        self._host.drive(commands.translation_mps, commands.rotation_radps)

    def halt(self) -> None:
        """The motors are off."""
        if self._others:
            self._others = {}
            self._host.actuate({})
        self._host.halt()

    def _sonars(self, on: bool) -> None:
        if on != self.sonars_on:
            self.sonars_on = on
            self._host.sonars(on)

    def _look(self, pan_radps: Optional[float]) -> None:
        if pan_radps != self._pan_radps:
            self._pan_radps = pan_radps
            self._host.look(pan_radps)
