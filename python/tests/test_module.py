"""What a module says for what it hears, without rpl."""

import contextlib
import io
import json
import math
import unittest
from typing import Any, Dict, List

from rpl_module import Behaviour, Failure, Module, Symbol, Tick

HELLO = {"type": "hello", "protocol": 1, "rpl": "0.2.0", "module": "m", "period_us": 50000, "pace": "lock-step", "seed": 7}


def start(behaviour: str, **arguments: Any) -> Dict[str, Any]:
    return {"type": "start", "id": 1, "behaviour": behaviour, "arguments": arguments, "time_us": 0}


def tick(step: int, **more: Any) -> Dict[str, Any]:
    return {"type": "tick", "time_us": 50000 * step, **more}


def stop(reason: str = "deactivated") -> Dict[str, Any]:
    return {"type": "stop", "id": 1, "behaviour": "b", "reason": reason}


def said(module: Module, *messages: Dict[str, Any]) -> List[Dict[str, Any]]:
    lines = "".join(json.dumps(message) + "\n" for message in (HELLO, *messages))
    output = io.BytesIO()
    module.run(io.BytesIO(lines.encode()), output)
    answers = [json.loads(line) for line in output.getvalue().splitlines()]
    assert answers.pop(0) == {"type": "hello", "protocol": 1, "module": "m"}
    return answers


def done(step: int, **more: Any) -> Dict[str, Any]:
    return {"type": "done", "time_us": 50000 * step, **more}


class Modules(unittest.TestCase):
    def test_a_behaviour_starts_steps_and_succeeds(self) -> None:
        module = Module("m")

        @module.behaviour("b")
        class Count(Behaviour):
            def start(self, max_count: int = 1) -> None:
                self.left = max_count

            def step(self, tick: Tick) -> None:
                self.left -= 1
                module.set("left*", self.left)
                if self.left == 0:
                    self.succeed()

        answers = said(module, start("b", **{"max-count": 2}), tick(1), tick(2), tick(3))
        self.assertEqual(answers, [
            {"type": "fluents", "values": {"left*": 1}}, done(1),
            {"type": "success", "id": 1}, {"type": "fluents", "values": {"left*": 0}}, done(2),
            done(3),
        ])
        self.assertEqual(module.seed, 7)

    def test_it_is_stopped_by_the_plan_and_at_the_end(self) -> None:
        reasons: List[str] = []
        module = Module("m")

        @module.behaviour("b")
        class Noted(Behaviour):
            def stop(self, reason: str) -> None:
                reasons.append(reason)

        said(module, start("b"), tick(1), stop("interrupted"), stop(), tick(2))
        said(module, start("b"), tick(1), {"type": "bye"}, tick(2))
        said(module, start("b"), tick(1))
        self.assertEqual(reasons, ["interrupted", "deactivated", "deactivated"])

    def test_a_failure_carries_class_message_and_slots(self) -> None:
        module = Module("m")

        @module.behaviour("b")
        class Fails(Behaviour):
            def step(self, tick: Tick) -> None:
                raise Failure("no-cup", "none there", looked_at=[Symbol("sink"), 3])

        slots = {"looked-at": [{"symbol": "sink"}, 3]}
        failed = {"type": "failure", "id": 1, "class": "no-cup", "message": "none there", "slots": slots}
        self.assertEqual(said(module, start("b"), tick(1), tick(2)), [failed, done(1), done(2)])

    def test_a_mistake_is_a_failure_with_a_traceback_and_the_module_goes_on(self) -> None:
        module = Module("m")

        @module.behaviour("b")
        class Wrong(Behaviour):
            def step(self, tick: Tick) -> None:
                module.set("x*", [1, math.nan])

        for message in (start("b"), start("b", colour=1), start("missing")):
            errors = io.StringIO()
            with contextlib.redirect_stderr(errors):
                failed, *rest = said(module, message, tick(1), tick(2))
            self.assertEqual((failed["type"], failed["class"], failed["id"]), ("failure", "module-failure", 1))
            self.assertIn("the behaviour has a mistake: ", failed["message"])
            self.assertIn("Traceback", errors.getvalue())
            self.assertEqual(rest, [done(1), done(2)])

    def test_it_drives_only_in_the_step_that_says_so(self) -> None:
        module = Module("m")

        @module.behaviour("b")
        class Drives(Behaviour):
            def step(self, tick: Tick) -> None:
                if tick.time_s < 0.1:
                    self.drive(0.2, 0.1)

        drive = {"translation_mps": 0.2, "rotation_radps": 0.1}
        self.assertEqual(said(module, start("b"), tick(1), tick(2)), [done(1, drive=drive), done(2)])

    def test_ticks_tell_what_is_wanted(self) -> None:
        ticks: List[Tick] = []
        module = Module("m")
        module.each_tick(ticks.append)
        position = {"x_m": 1.0, "y_m": 2.0, "heading_rad": 0.5, "certainty": 0.9}
        percept = {
            "number": 0, "time_us": 50000, "odometry_in_odom": {"x_m": 1.0, "y_m": 0.0, "heading_rad": 0.0},
            "translation_mps": 0.1, "rotation_radps": 0.0, "sonar_m": [1.0, 2.0], "bumped": False,
            "gripper": "open", "battery": 1.0, "something_new": 1,
        }
        said(module, tick(1), tick(2, position=position, percept=percept))
        self.assertEqual((ticks[0].time_s, ticks[0].position, ticks[0].percept), (0.05, None, None))
        seen, here = ticks[1].percept, ticks[1].position
        assert seen is not None and here is not None
        self.assertEqual((seen.odometry_in_odom.x_m, seen.sonar_m, seen.laser_m), (1.0, [1.0, 2.0], None))
        self.assertEqual((here.x_m, here.certainty), (1.0, 0.9))

    def test_what_is_printed_is_no_message(self) -> None:
        module = Module("m")
        module.each_tick(lambda tick: print("noise"))
        errors = io.StringIO()
        with contextlib.redirect_stderr(errors):
            self.assertEqual(said(module, tick(1)), [done(1)])
        self.assertEqual(errors.getvalue(), "noise\n")

    def test_values_that_no_plan_has_are_refused_where_they_are_given(self) -> None:
        module = Module("m")
        for value, mistake in ((math.inf, ValueError), ({"a": 1}, TypeError), (object(), TypeError)):
            with self.assertRaises(mistake):
                module.set("x*", value)  # type: ignore[arg-type]


if __name__ == "__main__":
    unittest.main()
