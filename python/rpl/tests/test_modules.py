"""Modules in Python, called in the process of the mission."""

import importlib.util
from pathlib import Path

import pytest

import rpl
from rpl_module import Behaviour, Module

FOLDER = Path(__file__).parents[3] / "examples" / "modules"
LAMP = str(FOLDER / "lamp.toml")


def lamp():
    spec = importlib.util.spec_from_file_location("lamp", FOLDER / "lamp.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.module


def mission(plan, module):
    return rpl.Mission(plan, world="test-room", seed=1, modules={LAMP: module})


def test_a_plan_uses_a_behaviour_and_a_fluent_of_it():
    run = mission("(blink-lamp 2) (print (< 0 (value light*)))", lamp())
    run.run()
    assert run.outcome == "succeeded" and run.printed == ["t"]


def test_a_mission_with_a_module_is_the_same_each_time():
    runs = [mission("(go-to 'table-side) (blink-lamp 2)", lamp()) for _ in range(2)]
    for run in runs:
        run.run()
    assert runs[0].trace.equals(runs[1].trace)


def test_a_failure_of_a_behaviour_reaches_the_plan():
    with pytest.raises(rpl.PlanFailed) as failed:
        mission("(blink-lamp 0)", lamp()).run()
    assert failed.value.failure_class == "lamp-failure"
    assert failed.value.message == "a lamp cannot blink 0 times"


def test_an_exception_outside_of_behaviours_is_shown_once_and_the_module_goes_on(capsys):
    module = lamp()

    @module.each_tick
    def sense(tick):
        raise LookupError("no bulb")

    mission("(blink-lamp 1)", module).run()
    assert capsys.readouterr().err.count("LookupError: no bulb") == 1


def test_whoever_interrupts_a_behaviour_interrupts_the_mission():
    module = Module("lamp")

    @module.behaviour("blink")
    class Blink(Behaviour):
        def step(self, tick):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mission("(with-failure-handling (((module-failure) (f) nil)) (blink-lamp 1)) (wait-time 1000)", module).run()


def test_a_module_serves_the_newest_mission():
    module = lamp()
    first = mission("(loop (blink-lamp 1))", module)
    first.run_until(1.0)
    second = mission("(blink-lamp 2)", module)
    second.run()
    with pytest.raises(rpl.PlanFailed, match="newer mission"):
        first.run()


def test_a_mission_with_modules_is_no_value():
    run = mission("(blink-lamp 2)", lamp())
    for of_a_value in (run.fork, run.save, lambda: run.load(b"")):
        with pytest.raises(ValueError, match="modules in Python cannot be forked or saved"):
            of_a_value()


def test_what_is_no_module_is_refused():
    with pytest.raises(TypeError, match="is no module"):
        mission("(wait-time 1)", "lamp.py")
    with pytest.raises(rpl.SetUpError, match="the module `lamp` needs a robot; name a world"):
        rpl.Mission("(wait-time 1)", modules={LAMP: lamp()})
    with pytest.raises(rpl.SetUpError, match="cannot read the module `none.toml`"):
        rpl.Mission("(wait-time 1)", world="test-room", modules={"none.toml": lamp()})
    with pytest.raises(rpl.PlanFailed, match="calls itself `torch`"):
        mission("(blink-lamp 1)", Module("torch")).run()
