"""What a module says for what it hears, without rpl."""

import contextlib
import io
import json
import math
import threading
import unittest
from typing import Any, Dict, List

from rpl_module import Behaviour, Failure, Module, Symbol, Tick

HELLO = {"type": "hello", "protocol": 2, "rpl": "0.2.0", "module": "m", "period_us": 50000, "pace": "lock-step", "seed": 7}


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
    assert answers.pop(0) == {"type": "hello", "protocol": 2, "module": "m"}
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

    def test_a_behaviour_may_wait_and_its_result_is_the_value_of_the_call(self) -> None:
        module = Module("m")

        @module.behaviour("b")
        class Fetches(Behaviour):
            def run(self, thing: str) -> str:
                module.event("begun")
                self.sleep(0.12)
                module.set("x*", 1)
                self.wait_until(lambda: self.sleep(0) is None)
                return Symbol(thing)

        begun = {"type": "event", "what": "begun", "details": {}}
        success = {"type": "success", "id": 1, "value": {"symbol": "cup"}}
        ticks = [tick(step) for step in range(1, 6)]
        for _ in range(20):
            # Whichever thread comes first, the answers are the same.
            self.assertEqual(said(module, start("b", thing="cup"), *ticks), [
                begun, done(1), done(2), {"type": "fluents", "values": {"x*": 1}}, done(3), success, done(4), done(5),
            ])

    def test_a_behaviour_that_waits_hears_there_that_it_is_stopped_and_may_fail(self) -> None:
        heard: List[str] = []
        module = Module("m")

        @module.behaviour("b")
        class Waits(Behaviour):
            def run(self) -> None:
                try:
                    self.sleep(0.05)
                    try:
                        self.sleep(10)
                    except Exception:
                        heard.append("no mistake")
                finally:
                    heard.append("cleaned up")

            def stop(self, reason: str) -> None:
                heard.append(reason)

        self.assertEqual(said(module, start("b"), tick(1), stop("interrupted"), tick(2)), [done(1), done(2)])
        self.assertEqual(heard, ["cleaned up", "interrupted"])

        @module.behaviour("b")
        class Fails(Behaviour):
            def run(self) -> None:
                self.sleep(0)
                self.fail("no-cup", "gone", what="cup")
                raise Failure("no-cup", "none there", message="left")

        failed = {"type": "failure", "id": 1, "class": "no-cup", "message": "none there", "slots": {"message": "left"}}
        self.assertEqual(said(module, start("b"), tick(1), tick(2)), [failed, done(1), done(2)])

    def test_a_live_module_goes_on_beside_its_loop(self) -> None:
        module, go_on, is_there = Module("m"), threading.Event(), threading.Event()

        @module.behaviour("b")
        class Blocks(Behaviour):
            def run(self) -> int:
                is_there.set()
                go_on.wait()
                return 3

        module.hear({**HELLO, "pace": "live"})
        self.assertEqual(module.hear(start("b")), [])
        is_there.wait()
        self.assertEqual(module.hear(tick(1)), [done(1)])
        go_on.set()
        answers: List[Dict[str, Any]] = []
        step = 1
        while not any(answer["type"] == "success" for answer in answers):
            step += 1
            answers = module.hear(tick(step))
        self.assertEqual(answers, [{"type": "success", "id": 1, "value": 3}, done(step)])

    def test_queries_are_answered_at_once(self) -> None:
        module = Module("m")

        @module.query("distance")
        def distance(a: float, b: float) -> float:
            if a == b:
                raise Failure("no-way", "it is there")
            return abs(a - b)

        def query(*arguments: Any, name: str = "distance") -> Dict[str, Any]:
            return {"type": "query", "id": 1, "query": name, "arguments": list(arguments), "time_us": 0}

        self.assertEqual(said(module, query(1, 3.5)), [{"type": "success", "id": 1, "value": 2.5}])
        refused = {"type": "failure", "id": 1, "class": "no-way", "message": "it is there", "slots": {}}
        self.assertEqual(said(module, query(1, 1)), [refused])
        for wrong in (query("a", 1), query(1), query(name="far")):
            with contextlib.redirect_stderr(io.StringIO()):
                self.assertEqual([answer["class"] for answer in said(module, wrong)], ["module-failure"])

    def test_a_mistake_in_each_tick_does_not_end_the_module(self) -> None:
        module = Module("m")

        @module.each_tick
        def sense(tick: Tick) -> None:
            module.event("sensed", what="x", message="y")
            raise ZeroDivisionError

        errors = io.StringIO()
        with contextlib.redirect_stderr(errors):
            answers = said(module, tick(1))
        self.assertEqual([answer["type"] for answer in answers], ["event", "done"])
        self.assertEqual(answers[0]["details"], {"what": "x", "message": "y"})
        self.assertIn("ZeroDivisionError", errors.getvalue())


if __name__ == "__main__":
    unittest.main()
