"""Missions: stepped, forked, saved, looked into."""

import signal
import threading

import numpy as np
import pytest

import rpl

GO = "(go-to 'table-side)"


def test_a_mission_in_three_lines():
    mission = rpl.Mission(GO, world="test-room", seed=1)
    mission.run()
    assert mission.outcome == "succeeded"
    x_m, y_m, _ = mission.true_pose
    believed_x_m, believed_y_m, _ = mission.estimate
    assert np.hypot(x_m - believed_x_m, y_m - believed_y_m) < 0.3


def test_the_same_seed_gives_the_same_mission_however_it_is_gone_on_with():
    whole = rpl.Mission(GO, world="test-room", seed=3)
    whole.run()
    stepped = rpl.Mission(GO, world="test-room", seed=3)
    for _ in range(40):
        assert stepped.step()
    fork = stepped.fork()
    assert type(fork) is rpl.Mission
    loaded = rpl.Mission(GO, world="test-room", seed=3)
    loaded.load(stepped.save())
    for mission in (stepped, fork, loaded):
        mission.run()
        assert mission.save() == whole.save()


def test_a_fork_leaves_the_first_where_it_is():
    mission = rpl.Mission("(wait-time 5) (print 'there)")
    mission.run_until(1.0)
    fork = mission.fork()
    fork.run()
    assert (mission.outcome, mission.printed) == (None, [])
    assert (fork.outcome, fork.printed, fork.time_s) == ("succeeded", ["there"], 5.0)


def test_the_belief_is_a_probability_that_cannot_be_written():
    mission = rpl.Mission(GO, world="test-room", seed=1)
    belief = mission.belief
    assert belief.ndim == 2 and abs(belief.sum() - 1.0) < 1e-6
    assert not belief.flags.writeable and not belief.flags.owndata
    with pytest.raises(ValueError):
        belief[0, 0] = 1.0
    for array in (belief, belief.base):
        with pytest.raises(ValueError):
            array.setflags(write=True)
    left_m, right_m, bottom_m, top_m = mission.belief_extent
    row, column = np.unravel_index(belief.argmax(), belief.shape)
    x_m, y_m, _ = mission.true_pose
    cell_m = (right_m - left_m) / belief.shape[1]
    assert abs(left_m + (column + 0.5) * cell_m - x_m) < 0.5 and abs(bottom_m + (row + 0.5) * cell_m - y_m) < 0.5
    # It stays what it was when the mission goes on, and is gone.
    before = belief.copy()
    mission.run()
    del mission
    assert (belief == before).all()
    assert rpl.Mission("(wait-time 1)").belief is None


def test_a_failure_is_an_exception_with_its_causes():
    plan = "(try-all (seq (wait-time 1) (fail \"the door\")) (seq (wait-time 2) (fail \"the window\")))"
    with pytest.raises(rpl.PlanFailed) as failed:
        rpl.Mission(plan).run()
    assert [cause.message for cause in failed.value.causes] == ["the door", "the window"]
    assert failed.value.__cause__ is failed.value.causes[0]
    assert (failed.value.causes[0].file, failed.value.causes[0].line) == ("plan.rpl", 1)


def test_a_fork_has_the_history_of_the_first_and_then_its_own():
    mission = rpl.Mission("(print 'one) (wait-time 2) (print 'two) (wait-time 2) (print 'three)")
    mission.run_until(1.0)
    first, second = mission.fork(), mission.fork()
    first.run_until(3.0)
    second.run()
    mission.run()
    assert (first.printed, second.printed) == (["one", "two"], ["one", "two", "three"])
    assert mission.trace.equals(second.trace)
    assert first.trace.equals(mission.trace.head(len(first.trace))[first.trace.columns])


def test_a_mission_that_takes_too_long_says_so_and_can_be_gone_on_with():
    mission = rpl.Mission("(wait-time 5)")
    with pytest.raises(rpl.TimeUp):
        mission.run(until_s=2.0)
    mission.run()
    assert mission.time_s == 5.0


def test_a_mission_says_where_it_stands():
    mission = rpl.Mission("(wait-time 5) 7")
    assert repr(mission) == "<Mission without a robot, seed 1, at 0.0 s: goes on>"
    mission.run()
    assert repr(mission) == "<Mission without a robot, seed 1, at 5.0 s: succeeded with 7>"
    failed = rpl.Mission('(fail "no")', world="test-room", seed=3)
    with pytest.raises(rpl.PlanFailed):
        failed.run()
    assert repr(failed).startswith("<Mission in test-room, seed 3, at 0.0 s: failed: ") and "no" in repr(failed)


def test_what_does_not_go_together_is_told_with_what_would_be_right():
    with pytest.raises(rpl.SetUpError, match="did you mean `test-room`"):
        rpl.Mission(GO, world="test-rom")
    with pytest.raises(rpl.SetUpError, match="tabl-side|there is no plan"):
        rpl.Mission("no-such-plan.rpl", world="test-room")
    with pytest.raises(rpl.SetUpError, match="not a saved run"):
        rpl.Mission(GO, world="test-room").load(b"something else")


def test_worlds_and_robots_are_objects_that_missions_share():
    robot = rpl.Robot("turtlebot")
    world = rpl.World("test-room", robot)
    assert robot.name in rpl.Robot.names() and world.name in rpl.World.names()
    left_m, right_m, bottom_m, top_m = world.extent
    x_m, y_m, _ = world.places["table-side"]
    assert left_m < x_m < right_m and bottom_m < y_m < top_m and 0.05 < robot.radius_m < 0.5
    assert world._repr_svg_().startswith("<svg")
    of_objects = rpl.Mission(GO, world, robot, seed=2)
    of_names = rpl.Mission(GO, "test-room", "turtlebot", seed=2)
    assert of_objects.true_pose == of_names.true_pose == world.start
    assert of_objects.run() == of_names.run()
    assert of_objects.save() == of_names.save()
    with pytest.raises(rpl.SetUpError, match="did you mean"):
        rpl.Robot("turtelbot")


def test_a_scenario_is_a_text_or_a_name():
    turned = rpl.Mission("(wait-time 4)", "test-room", seed=1, scenario="(wait-time 2) (rotate-robot! 90deg)")
    still = rpl.Mission("(wait-time 4)", "test-room", seed=1)
    turned.run()
    still.run()
    turn_rad = turned.true_pose[2] - still.true_pose[2]
    assert np.cos(turn_rad - np.pi / 2) > 0.99
    with pytest.raises(rpl.SetUpError, match="add `--world dept`"):
        rpl.Mission("(wait-time 4)", scenario="(wait-time 2)")


def test_a_fluent_is_looked_at_by_its_name():
    mission = rpl.Mission("(def-fluent count 0) (wait-time 1) (setf (value count) 3) (wait-time 1)")
    mission.run_until(0.5)
    assert (mission.fluent("count"), mission.fluent("no-such-fluent")) == ("0", None)
    mission.run()
    assert mission.fluent("count") == "3"


def test_an_interrupt_ends_the_stepping_and_not_the_mission():
    # Who starts the tests in the background may have them ignore interrupts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    mission = rpl.Mission("(loop (wait-time 1))")
    timer = threading.Timer(0.1, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        mission.run()
    reached_s = mission.time_s
    assert mission.step() and mission.time_s > reached_s


def test_check_finds_what_is_wrong_and_says_where():
    (finding,) = rpl.Plan("(seq\n  (prnt 1))").check()
    assert (finding.severity, finding.line) == ("error", 2)
    assert "print" in f"{finding.help} {finding.message}"
    assert rpl.Plan("(print 1)").check() == []


def test_the_trace_is_a_data_frame():
    mission = rpl.Mission(GO, world="test-room", seed=1)
    mission.run()
    trace = mission.trace
    assert {"time_s", "task", "kind"} <= set(trace.columns)
    assert trace.time_s.is_monotonic_increasing and trace.time_s.iloc[-1] <= mission.time_s
    started = trace[(trace.kind == "behaviour") & trace.time_s.notna()]
    assert len(started) > 0


def test_the_figure_is_drawn_where_there_is_a_robot():
    mission = rpl.Mission(GO, world="test-room", seed=1)
    mission.run()
    assert mission.figure()._repr_svg_().startswith("<svg") and mission._repr_svg_()
    with pytest.raises(ValueError, match="name a world"):
        rpl.Mission("(wait-time 1)").figure()


def test_other_threads_go_on_while_a_mission_does():
    mission = rpl.Mission("(loop (wait-time 1))")
    is_running, is_over = threading.Event(), threading.Event()

    def run() -> None:
        is_running.set()
        mission.run_until(200_000.0)
        is_over.set()

    thread = threading.Thread(target=run)
    thread.start()
    is_running.wait()
    turns = 0
    while not is_over.is_set():
        turns += 1
    thread.join()
    assert mission.time_s >= 200_000.0 - 1.0 and turns > 0


def test_a_plan_without_an_end_does_not_fill_the_memory():
    mission = rpl.Mission("(loop (wait-time 1))")
    mission.run_until(600_000.0)
    with pytest.warns(RuntimeWarning, match="the trace is not whole: the first [0-9]+ are kept no longer"):
        trace = mission.trace_columns()
    assert 1_000_000 <= len(trace["time_s"]) < 1_100_000
    assert trace["time_s"][-1] > 599_990.0
