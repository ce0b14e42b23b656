"""How a host serves missions, without rpl and without a robot."""

import contextlib
import io
import json
import math
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest
from dataclasses import replace
from pathlib import Path
from typing import Any, Iterator, List, Optional
from unittest import mock

from missions import FOREVER_S, HELLO, Client, Served, commands, until
from rpl_host import CameraReading, Halt, Host, Reading, ReadingError
from rpl_host._guard import Guard
from rpl_host._reading import Perceived, Perception, Pose
from rpl_host._server import Service
from rpl_host._words import WordsError, heard, token_of

PACKAGES = Path(__file__).parent.parent


class Fly(Host):
    """A simulator whose robot drives along a line as it is told."""

    robot = "fly"
    period_s = 0.01
    start_known = True

    def __init__(self) -> None:
        self.y_m = 1.0
        self.reading = Reading(5.0, self.y_m, math.pi / 2)
        self.speed_mps = 0.0
        self.calls: List[Any] = []
        self.notices: List[str] = []

    def step(self) -> None:
        self.y_m += self.speed_mps * self.period_s
        self.reading = replace(self.reading, y_m=self.y_m)

    def read(self) -> Reading:
        return self.reading

    def drive(self, translation_mps: float, rotation_radps: float) -> None:
        self.speed_mps = translation_mps
        self.note(("drive", translation_mps, rotation_radps))

    def sonars(self, on: bool) -> None:
        self.note(("sonars", on))

    def grasp(self, thing: str) -> None:
        self.note(("grasp", thing))

    def release(self) -> None:
        self.note("release")

    def look(self, pan_radps: Optional[float]) -> None:
        self.note(("look", pan_radps))

    def actuate(self, others: Any) -> None:
        self.note(("actuate", dict(others)))

    def note(self, call: Any) -> None:
        if not self.calls or self.calls[-1] != call:
            self.calls.append(call)

    def tell(self, notice: str) -> None:
        self.notices.append(notice)


class Missions(unittest.TestCase):
    def test_time_and_odometry_begin_with_each_mission_and_only_the_first_start_is_known(self) -> None:
        fly = Fly()
        with Served(fly) as served:
            first = served.client(HELLO)
            greeting = {"type": "hello", "protocol": 2, "robot": "fly", "period_us": 10_000, "factor": 1.0}
            self.assertEqual(first.hear(), {**greeting, "start_known": True})
            first.say(commands(0))
            percept = first.hear()
            self.assertEqual((percept["number"], percept["time_us"], percept["commands"]), (0, 10_000, 0))
            # It looks along the y axis: ahead is x.
            self.assertAlmostEqual(percept["odometry_in_odom"]["x_m"], 0.005)
            self.assertAlmostEqual(percept["odometry_in_odom"]["y_m"], 0.0)
            self.assertAlmostEqual(percept["translation_mps"], 0.5)
            self.assertEqual((percept["gripper"], percept["bumped"], percept["battery"]), ("open", False, 1.0))
            self.assertEqual([first.hear()["number"] for _ in range(3)], [1, 2, 3])
            first.say({"type": "bye"})
            self.assertEqual(first.farewell(), "it says goodbye")
            second = served.client(HELLO)
            self.assertEqual(second.hear(), {**greeting, "start_known": False})
            second.say(commands(0, 0.0))
            percept = second.hear()
            self.assertEqual((percept["number"], percept["time_us"]), (0, 10_000))
            self.assertEqual(percept["odometry_in_odom"], {"x_m": 0.0, "y_m": 0.0, "heading_rad": 0.0})
            served.end()
            self.assertEqual(second.farewell(), "the host has ended")
        assert served.record is not None
        self.assertEqual((served.record.missions, served.record.halts[Halt.LINE_CLOSED]), (2, 1))
        self.assertEqual(fly.speed_mps, 0.0)

    def test_the_world_waits_for_the_first_commands_and_then_goes_on(self) -> None:
        fly = Fly()
        with Served(fly) as served, mock.patch.object(Fly, "step", autospec=True) as step:
            mission = served.mission()
            self.assertEqual(step.call_count, 0)
            mission.say(commands(0))
            mission.hear()
            mission.close()
            steps = step.call_count
            until(lambda: step.call_count > steps + 5)

    def test_a_second_mission_is_told_which_one_is_here(self) -> None:
        with Served(Fly()) as served:
            first = served.mission(commands(0))
            reason = served.client({**HELLO, "mission": "b"}).farewell()
            self.assertRegex(reason, r"another mission is here: `plan.rpl` from 127.0.0.1:\d+, since 0 s; .* has to wait")
            self.assertEqual(first.hear()["type"], "percept")

    def test_who_does_not_fit_is_told_why(self) -> None:
        token = "0123456789abcdef"
        with Served(Fly(), Service(token=token)) as served:
            for said, why in (
                ({"token": token, "robot": "b21"}, "is for the robot `b21`, and this host moves `fly`"),
                ({"token": token, "protocol": 1}, "speaks version 1 of the messages, and this host 2"),
                ({"robot": "b21"}, "has no token, and this host wants one"),
                ({"token": "0123456789abcdeF"}, "has another token than this host"),
                ({"token": 5}, "it has sent what is no message: `token` is no text"),
                ({"tokens": token}, "`tokens` is no key of it"),
            ):
                self.assertIn(why, served.client({**HELLO, **said}).farewell())
            self.assertIn("it commands before it greets", served.client(commands(0)).farewell())
            self.assertEqual(served.client({**HELLO, "token": token}).hear()["type"], "hello")

    def test_a_mission_that_is_at_fault_has_to_go_and_the_motors_are_off(self) -> None:
        for said, why in (
            (HELLO, "it greets a second time"),
            (commands(9), "it answers up to percept 9, and "),
            ({**commands(0), "translation_mps": "fast"}, "`translation_mps` is no number"),
            ({"type": "percept"}, "its `type` is none of"),
        ):
            fly = Fly()
            with Served(fly) as served:
                mission = served.mission(commands(0))
                mission.hear()
                mission.say(said)
                self.assertIn(why, mission.farewell())
                self.assertEqual(fly.speed_mps, 0.0)

    def test_lines_and_greetings_have_a_bound_in_length_and_in_time(self) -> None:
        with Served(Fly()) as served:
            long = served.client()
            with contextlib.suppress(OSError):  # It may be shown out while it still speaks.
                long.stream.sendall(b"x" * ((1 << 20) + 1))
            self.assertIn("a line of more than 1048576 bytes", long.farewell())
        with mock.patch("rpl_host._server.LINE_S", 0.1), Served(Fly()) as served:
            slow = served.client()
            slow.stream.sendall(b'{"type":')
            self.assertIn("has not ended within 0.1 s", slow.farewell())
        with mock.patch("rpl_host._server.GREETING_S", 0.1), Served(Fly()) as served:
            self.assertIn("it has not greeted within 0.1 s", served.client().farewell())

    def test_sixty_four_wait_at_the_door_and_the_one_that_waits_longest_has_to_go(self) -> None:
        with Served(Fly()) as served:
            waiting = [served.client() for _ in range(65)]
            self.assertIn("64 wait without a greeting", waiting[0].farewell())
            waiting[64].say(HELLO)
            self.assertEqual(waiting[64].hear()["type"], "hello")

    def test_a_mission_that_gives_no_commands_loses_the_robot(self) -> None:
        with Served(Fly(), Service(patience_s=0.4)) as served:
            mission = served.mission(commands(0))
            self.assertEqual(mission.farewell(), "it has given no commands for 0.4 s")
            self.assertEqual(served.client(HELLO).hear()["type"], "hello")

    def test_who_commands_by_percepts_of_long_ago_drives_blindly_and_is_as_good_as_silent(self) -> None:
        # Two seconds, but no longer than a mission may be silent.
        with Served(Fly(), Service(patience_s=0.4)) as served:
            mission = served.mission(commands(0))
            message = mission.hear()
            while message["type"] == "percept":
                mission.say(commands(0))
                message = mission.hear()
            self.assertEqual(message["reason"], "it has given no commands for 0.4 s")

    def test_a_mission_that_does_not_read_is_gone(self) -> None:
        fly = Fly()
        fly.reading = replace(fly.reading, others={"long": "x" * 100_000})
        with Served(fly, Service(factor=10.0, patience_s=0.5)) as served:
            mission = served.mission(commands(0))
            number = 0
            while not any("it does not take what" in notice for notice in fly.notices):
                mission.say(commands(number))
                time.sleep(0.01)
                number += 1
                assert number < 1000
            self.assertEqual(fly.speed_mps, 0.0)

    def test_the_end_of_a_host_is_clean(self) -> None:
        fly = Fly()
        with Served(fly) as served:
            mission, visitor = served.mission(commands(0)), served.client()
            mission.hear()
            until(lambda: len(served.server._door) == 1)
            served.end()
            self.assertEqual((mission.farewell(), visitor.farewell()), ("the host has ended", "the host has ended"))
        self.assertEqual(fly.speed_mps, 0.0)

    def test_once_ends_when_the_first_mission_has_gone(self) -> None:
        with Served(Fly(), Service(once=True)) as served:
            mission = served.mission(commands(0))
            mission.hear()
            mission.say({"type": "bye", "reason": "all is done"})
            self.assertEqual(mission.farewell(), "it says goodbye: all is done")
            served.wait()


class Safety(unittest.TestCase):
    def test_silence_cuts_the_motors_and_commands_start_them_again(self) -> None:
        fly = Fly()
        with Served(fly) as served:
            spoken_s = time.monotonic()
            mission = served.mission(commands(0))
            mission.hear()
            until(lambda: fly.speed_mps == 0.0)
            self.assertGreaterEqual(time.monotonic() - spoken_s, 0.25)
            self.assertIn("the motors are off: no commands for 0.3 s", fly.notices)
            number = mission.hear()["number"]
            mission.say(commands(number))
            until(lambda: fly.speed_mps == 0.5)
            served.end()
        assert served.record is not None
        self.assertGreaterEqual(served.record.halts[Halt.SILENCE], 1)

    def test_a_closed_line_cuts_the_motors_at_once(self) -> None:
        fly = Fly()
        # The next period would be too late, and the silence, too.
        fly.period_s = 10 * FOREVER_S
        with mock.patch("rpl_host._guard.SILENCE_S", 10 * FOREVER_S), Served(fly) as served:
            mission = served.mission(commands(0))
            mission.hear()
            mission.close()
            until(lambda: fly.speed_mps == 0.0)

    def test_a_bump_stops_the_robot_which_then_may_back_off(self) -> None:
        fly = Fly()
        with Served(fly) as served:
            mission = served.mission(commands(0))
            mission.hear()
            fly.calls.clear()
            fly.reading = replace(fly.reading, bumped=True)
            for message in iter(mission.hear, None):
                mission.say(commands(message["number"] + 1, -0.1))
                if fly.calls[-1:] == [("drive", -0.1, 0.0)] and ("drive", 0.0, 0.0) in fly.calls:
                    break
        assert served.record is not None
        self.assertEqual(served.record.halts[Halt.BUMPER], 1)
        self.assertIn("the motors are off: the bumper is pressed", fly.notices)

    def test_an_exception_of_the_robot_ends_the_host_with_the_motors_off_and_is_told(self) -> None:
        for method in ("read", "step"):
            fly = Fly()
            with Served(fly) as served:
                mission = served.mission(commands(0))
                mission.hear()
                with mock.patch.object(Fly, method, side_effect=OSError("the cable is cut")):
                    self.assertEqual(mission.farewell(), "OSError: the cable is cut")
                    served.wait()
            self.assertIsInstance(served.error, OSError)
            self.assertEqual(fly.calls[-1], ("drive", 0.0, 0.0))

    def test_commands_that_waited_while_the_robot_took_long_do_not_count(self) -> None:
        fly = Fly()
        drove: List[float] = []

        def hang(host: Fly) -> None:
            """What came before it ended may have come when it began."""
            if not drove:
                mission.say(commands(0))
                time.sleep(0.5)
            drove.append(host.speed_mps)

        with Served(fly) as served, mock.patch.object(Fly, "step", hang):
            mission = served.mission()
            mission.say(commands(0))
            until(lambda: len(drove) > 1)
        self.assertEqual(drove[:2], [0.5, 0.0])
        self.assertIn("the motors are off: no commands for 0.3 s", fly.notices)

    def test_a_method_that_hangs_does_not_keep_the_motors_on(self) -> None:
        class Hanging(Fly):
            halts_any_time = True

            def __init__(self) -> None:
                super().__init__()
                self.is_off = threading.Event()
                self.was_cut = False

            def step(self) -> None:
                self.is_off.clear()
                # It comes back only because somebody else has cut the motors meanwhile.
                self.was_cut = self.was_cut or self.is_off.wait(FOREVER_S)

            def halt(self) -> None:
                super().halt()
                self.is_off.set()

        hanging = Hanging()
        with Served(hanging) as served:
            served.mission(commands(0)).hear()
            self.assertTrue(hanging.was_cut)

    def test_what_cannot_be_perceived_is_told_by_its_name(self) -> None:
        fly = Fly()
        fly.reading = replace(fly.reading, laser_m=[1.0] * 8)
        with Served(fly) as served:
            mission = served.mission(commands(0))
            self.assertEqual(mission.hear()["laser_m"], [1.0] * 8)
            fly.reading = replace(fly.reading, laser_m=[1.0] * 5 + [math.nan] + [1.0] * 2)
            self.assertIn("`laser_m[5]` is nan", mission.farewell())
            served.wait()
        self.assertIsInstance(served.error, ReadingError)
        self.assertEqual(fly.speed_mps, 0.0)

    def test_a_guard_lets_nobody_drive_before_commands_have_come(self) -> None:
        guard = Guard()
        self.assertIs(guard.halt, Halt.UNUSED)
        self.assertIsNone(guard.look_at_clock(1e6))
        guard.heard(10.0)
        self.assertIsNone(guard.halt)
        self.assertIsNone(guard.look_at_clock(10.29))
        self.assertIs(guard.look_at_clock(10.31), Halt.SILENCE)
        self.assertIsNone(guard.look_at_clock(10.4))
        self.assertEqual(guard.counts[Halt.SILENCE], 1)

    def test_a_guard_that_a_bump_has_halted_waits_until_the_robot_stands(self) -> None:
        guard = Guard()
        guard.heard(10.0)
        self.assertIs(guard.look_at_bumper(True, stands=False), Halt.BUMPER)
        guard.heard(10.1)
        self.assertIsNone(guard.look_at_bumper(True, stands=False))
        self.assertIs(guard.halt, Halt.BUMPER)
        # It stands and is pressed still: it may back off.
        self.assertIsNone(guard.look_at_bumper(True, stands=True))
        self.assertIsNone(guard.halt)
        self.assertIsNone(guard.look_at_bumper(False, stands=False))
        self.assertIs(guard.look_at_bumper(True, stands=False), Halt.BUMPER)
        self.assertEqual(guard.counts[Halt.BUMPER], 2)


class Orders(unittest.TestCase):
    def test_the_gripper_is_told_once_and_commands_between_two_periods_lose_no_order(self) -> None:
        fly = Fly()
        fly.period_s = 0.05
        with Served(fly) as served:
            mission = served.mission(commands(0, gripper={"grasp": "cup"}), commands(0))
            mission.hear()
            mission.hear()
            mission.say(commands(1, gripper="release"))
            mission.hear_until(lambda message: message["commands"] == 1)
        orders = [call for call in fly.calls if call[0] == "grasp" or call == "release"]
        self.assertEqual(orders, [("grasp", "cup"), "release"])

    def test_sonars_camera_and_others_are_told_what_has_changed_and_are_off_at_the_end(self) -> None:
        fly = Fly()
        fly.reading = replace(fly.reading, sonar_m=[1.0, 2.0], camera=CameraReading(0.1, b"\x00\x01\x02"))
        with Served(fly) as served:
            mission = served.mission(commands(0, camera={"pan_radps": 0.5}, others={"lamp": [1.0, "red", True]}))
            percept = mission.hear()
            self.assertEqual(percept["sonar_m"], [1.0, 2.0])
            self.assertEqual(percept["camera"], {"pan_rad": 0.1, "image": "AAEC"})
            mission.say({**commands(1), "sonars_on": False})
            self.assertNotIn("sonar_m", mission.hear_until(lambda message: message["commands"] == 1))
        calls = [call for call in fly.calls if call[0] != "drive"]
        lamp = ("actuate", {"lamp": [1.0, "red", True]})
        self.assertEqual(calls, [
            ("sonars", True), ("look", 0.5), lamp, ("sonars", False), ("look", None), ("actuate", {}),
        ])

    def test_messages_of_people_are_words(self) -> None:
        fly = Fly()
        fly.reading = replace(fly.reading, messages=["bring  the mail", " "])
        with Served(fly) as served:
            mission = served.mission(commands(0))
            # What had come when the mission began is not lost.
            self.assertEqual(mission.hear()["messages"], [["bring", "the", "mail"]] * 2)
            self.assertEqual(mission.hear()["messages"], [["bring", "the", "mail"]])


class Walker(Fly):
    """A robot: it has a clock of its own, and nobody steps it."""

    step = Host.step


class Times(unittest.TestCase):
    def test_a_robot_that_is_not_stepped_has_the_time_of_the_wall(self) -> None:
        with Served(Walker()) as served:
            began_s = time.monotonic()
            mission = served.mission(commands(0))
            first = mission.hear()
            last = mission.hear_until(lambda message: message["number"] == 20)
            passed_s = time.monotonic() - began_s
            self.assertGreater(last["time_us"] - first["time_us"], 100_000)
            self.assertLess(last["time_us"], passed_s * 1e6)

    def test_a_clock_of_the_robot_is_taken(self) -> None:
        fly, ticks = Walker(), iter(range(100_000))
        with Served(fly) as served, mock.patch.object(
            Walker, "read", lambda self: replace(self.reading, time_s=1e9 + 0.01 * next(ticks))
        ):
            mission = served.mission(commands(0))
            self.assertEqual([mission.hear()["time_us"] for _ in range(3)], [10_000, 20_000, 30_000])

    def test_a_simulator_goes_as_fast_as_its_factor_says(self) -> None:
        fly = Fly()
        with Served(fly, Service(factor=10.0)) as served:
            began_s = time.monotonic()
            mission = served.mission(commands(0))
            last = mission.hear_until(lambda message: message["number"] == 199)
            self.assertEqual(last["time_us"], 2_000_000)
            self.assertGreater(time.monotonic() - began_s, 0.15)

    def test_a_host_that_is_behind_says_so_and_does_not_hurry(self) -> None:
        fly = Fly()
        slow = iter([0.7])
        with Served(fly) as served, mock.patch.object(Fly, "step", lambda self: time.sleep(next(slow, 0.0))):
            mission = served.mission(commands(0))
            mission.hear()
            mission.hear()
        assert served.record is not None
        self.assertGreaterEqual(served.record.delays, 1)
        self.assertTrue(any(notice.startswith("the host is behind") for notice in fly.notices), fly.notices)


SCRIPT = """
from rpl_host import Host, Reading

class Robot(Host):
    "A robot."
    robot = "fly"

    def __init__(self):
        self.driven = []

    def read(self):
        return Reading(0.0, 0.0, 0.0)

    def drive(self, translation_mps, rotation_radps):
        self.driven.append(translation_mps)

robot = Robot()
robot.main()
print("ended after", robot.driven[-2:])
"""


class Programs(unittest.TestCase):
    def test_signals_end_a_program_with_the_motors_off(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            program = subprocess.Popen(
                [sys.executable, "-c", SCRIPT, "--listen", "127.0.0.1:0"],
                cwd=PACKAGES, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            )
            assert program.stdout is not None
            listening = program.stdout.readline()
            self.assertRegex(listening, r"^listening at 127\.0\.0\.1:\d+$")
            mission = Client(("127.0.0.1", int(listening.rpartition(":")[2])))
            mission.say(HELLO, commands(0))
            # The greeting, and at least one percept: it drives.
            self.assertEqual([mission.hear()["type"] for _ in range(2)], ["hello", "percept"])
            program.send_signal(number)
            self.assertEqual(mission.farewell(), "the host has ended")
            out, errors = program.communicate(timeout=FOREVER_S)
            self.assertEqual((program.returncode, out), (0, "ended after [0.5, 0.0]\n"), errors)
            self.assertIn("here is `plan.rpl` from 127.0.0.1:", errors)
            self.assertIn("1 mission(s), ", errors)

    def test_a_host_is_served_at_a_socket_until_it_is_stopped(self) -> None:
        fly, listener = Fly(), socket.create_server(("127.0.0.1", 0))
        records: List[Any] = []
        serving = threading.Thread(target=lambda: records.append(fly.serve(listener)))
        with contextlib.redirect_stdout(io.StringIO()):
            serving.start()
            mission = Client(listener.getsockname())
            mission.say(HELLO, commands(0))
            self.assertEqual([mission.hear()["type"] for _ in range(2)], ["hello", "percept"])
            fly.stop()
            self.assertEqual(mission.farewell(), "the host has ended")
            serving.join(FOREVER_S)
        self.assertEqual([record.missions for record in records], [1])
        self.assertTrue(fly.notices[-1].startswith("1 mission(s), "), fly.notices)

    def test_what_cannot_be_served_is_refused_before_anybody_comes(self) -> None:
        nameless = type("Nameless", (Fly,), {"robot": None})()
        with self.assertRaisesRegex(TypeError, "`robot` of Nameless is to be the `name` in the robot's file"):
            nameless.serve("127.0.0.1:0")
        for wrong in ({"factor": 0.0}, {"patience_s": 0.1}, {"token": "short"}):
            with self.assertRaises(ValueError):
                Fly().serve("127.0.0.1:0", **wrong)


class Readings(unittest.TestCase):
    def refused(self, *readings: Reading) -> str:
        perception = Perception()
        for at, reading in enumerate(readings[:-1]):
            perception.take(reading, float(at))
        with self.assertRaises(ReadingError) as refused:
            perception.take(readings[-1], float(len(readings)))
        return str(refused.exception)

    def test_what_no_robot_perceives_is_named(self) -> None:
        good = Reading(0.0, 0.0, 0.0)
        bad: Any = "1.5 m"
        none: Any = None
        for change, why in (
            ({"x_m": math.nan}, "`x_m` is nan"),
            ({"heading_rad": math.inf}, "`heading_rad` is inf"),
            ({"y_m": bad}, "`y_m` is a str, and a number is expected"),
            ({"y_m": none}, "a reading has a pose, `x_m`, `y_m` and `heading_rad`, or both speeds"),
            ({"x_m": none, "y_m": none, "heading_rad": none, "translation_mps": 0.1}, "or both speeds"),
            ({"translation_mps": math.nan}, "`translation_mps` is nan"),
            ({"laser_m": [1.0, math.inf]}, "`laser_m[1]` is inf, and no distance; without an echo it is the `range`"),
            ({"laser_m": [1.0, 1.0, 0.0]}, "`laser_m[2]` is 0, and nothing is in the laser"),
            ({"sonar_m": [-0.1]}, "`sonar_m[0]` is -0.1"),
            ({"battery": 1.1}, "`battery` is 1.1, and 0 to 1 is expected"),
            ({"gripper": "shut"}, "`gripper` has 'shut' in it, and one of open, moving, closed is expected"),
            ({"failed": ["lidar"]}, "`failed` has 'lidar' in it"),
            ({"messages": "bring mail"}, "`messages` is a text"),
            ({"others": {"heat": [1.0, math.nan]}}, "`others.heat[1]` is nan"),
            ({"camera": CameraReading(4.0)}, "`camera.pan_rad` is 4.0"),
        ):
            self.assertIn(why, self.refused(replace(good, **change)))
        no_reading: Any = (0.0, 0.0, 0.0)
        self.assertIn("`read` gives a tuple, and a `Reading` is expected", self.refused(no_reading))

    def test_the_number_of_distances_stays_the_same(self) -> None:
        first, second = (Reading(0.0, 0.0, 0.0, laser_m=[1.0] * count) for count in (360, 359))
        self.assertEqual(self.refused(first, second), "`laser_m` has 359 readings, and the first time it had 360")

    def test_a_clock_that_goes_back_stands_or_leaps_is_named(self) -> None:
        first = Reading(0.0, 0.0, 0.0, time_s=7.0)
        for time_s in (7.0, 6.9, 17.5):
            self.assertIn(f"`time_s` is {time_s}, and that of the last reading was 7.0",
                          self.refused(first, replace(first, time_s=time_s)))

    def test_speeds_that_are_left_out_are_those_of_the_odometry(self) -> None:
        perception = Perception()
        self.assertEqual(perception.take(Reading(1.0, 1.0, 3.1), 0.0).speeds, (0.0, 0.0))
        perceived = perception.take(Reading(0.9, 1.0, -3.1), 0.1)
        # It looks back along the x axis, and has turned over the half turn.
        self.assertAlmostEqual(perceived.speeds[0], 1.0, places=2)
        self.assertAlmostEqual(perceived.speeds[1], (math.tau - 6.2) / 0.1)
        told = perception.take(Reading(0.9, 1.0, -3.1, translation_mps=0.3, rotation_radps=-0.2), 0.2)
        self.assertEqual((told.speeds, told.stands()), ((0.3, -0.2), False))
        self.assertTrue(perception.take(Reading(0.9, 1.0, -3.1), 0.3).stands())

    def test_a_pose_that_is_left_out_is_the_sum_of_the_speeds(self) -> None:
        perception = Perception()
        for at in range(101):
            pose = perception.take(Reading(translation_mps=0.5, rotation_radps=math.pi / 10), at / 10).pose_in_odom
        # In ten seconds it has gone half around a circle of five metres' length.
        self.assertAlmostEqual(pose.heading_rad, math.pi)
        self.assertAlmostEqual(pose.x_m, 0.0)
        self.assertAlmostEqual(pose.y_m, 10 / math.pi, places=2)

    def test_a_pose_is_seen_from_where_the_mission_began(self) -> None:
        began = Perceived(5.0, Pose(2.0, 3.0, math.pi / 2), (0.0, 0.0), False, {})
        now = Perceived(6.5, Pose(2.0, 4.0, -math.pi / 2), (0.0, 0.0), False, {"sonar_m": [1.0]})
        percept = now.percept(began, sonars_on=False)
        pose = percept["odometry_in_odom"]
        self.assertAlmostEqual(pose["x_m"], 1.0)
        self.assertAlmostEqual(pose["y_m"], 0.0)
        self.assertAlmostEqual(abs(pose["heading_rad"]), math.pi)
        self.assertEqual(percept["time_us"], 1_500_000)
        self.assertNotIn("sonar_m", percept)

    def test_numbers_of_other_packages_are_taken(self) -> None:
        class Half:
            def __float__(self) -> float:
                return 0.5

        def scan() -> Iterator[Half]:
            yield Half()
            yield Half()

        perceived = Perception().take(Reading(Half(), 1, 0, laser_m=scan()), 0.0)
        self.assertEqual((perceived.pose_in_odom.x_m, perceived.rest["laser_m"]), (0.5, [0.5, 0.5]))


class Words(unittest.TestCase):
    def test_what_is_no_message_is_refused_in_words(self) -> None:
        deep = b'{"type":"commands","others":{"a":' + b"[" * 100_000 + b"]" * 100_000 + b"}}"
        for line, why in (
            (b"\xff", "it is not UTF-8"),
            (b"{", "it is not JSON"),
            (b"[]", "it is no object"),
            (deep, "it is nested too deeply"),
            (json.dumps({**commands(0), "rotation_radps": math.nan}).encode(), "NaN is no number of JSON"),
            (json.dumps(commands(0)).replace("0.5", "1e999").encode(), "`translation_mps` is no finite number"),
            (json.dumps({**commands(0), "number": -1}).encode(), "`number` is no count"),
            (json.dumps({**commands(0), "number": True}).encode(), "`number` is no count"),
            (json.dumps({**commands(0), "gripper": "shut"}).encode(), "`gripper` is no order of a gripper"),
            (b'{"type":"commands"}', "`number` is missing"),
        ):
            with self.assertRaises(WordsError) as refused:
                heard(line)
            self.assertIn(why, str(refused.exception))

    def test_a_token_is_a_line_that_nobody_guesses(self) -> None:
        self.assertEqual(token_of("0123456789abcdef\n"), "0123456789abcdef")
        for wrong in ("", "short", "two words are none", "0123456789abcdef\n0123456789abcdef", "x" * 1025):
            with self.assertRaises(ValueError):
                token_of(wrong)


if __name__ == "__main__":
    unittest.main()
