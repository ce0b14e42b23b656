"""The simulators of others as hosts: `examples/hosts`."""

import importlib.util
import math
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from missions import Served
from rpl_host._reading import Perception
from rpl_host.worlds import World

REPOSITORY = Path(__file__).parents[2]
EXAMPLES = REPOSITORY / "examples" / "hosts"
RPL = shutil.which("rpl", path=str(Path(sys.executable).parent)) or shutil.which("rpl")
"""The command that was installed with this Python, or any."""

RIGHT, AHEAD, LEFT = 90, 180, 270
"""Which readings of a laser with 360 of them look there."""


@pytest.fixture(params=[("irsim", "IrSim"), ("mujoco", "MuJoCo")], ids=["irsim", "mujoco"])
def simulator(request):
    """The class of a host."""
    name, kind = request.param
    pytest.importorskip(name)
    pytest.importorskip("tomllib")
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / name / "host.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return getattr(module, kind)


@pytest.fixture
def flat():
    return World.read(REPOSITORY / "robot" / "worlds" / "flat.toml")


def driven(host, seconds, translation_mps, rotation_radps):
    """What is perceived at the end, and the odometry of the way."""
    perception = Perception()
    for period in range(round(seconds / host.period_s)):
        host.drive(translation_mps, rotation_radps)
        host.step()
        perceived = perception.take(host.read(), period * host.period_s)
    return perceived


def test_the_laser_sees_from_right_to_left(simulator, flat):
    # In the hallway, which is from 3.875 to 5.325 m, nearer to the wall on the right.
    host = simulator(replace(flat, start=(5.0, 4.4, 0.0)))
    host.halt()
    host.step()
    laser_m = host.read().laser_m
    assert len(laser_m) == 360
    assert laser_m[RIGHT] == pytest.approx(0.525, abs=0.06)
    assert laser_m[LEFT] == pytest.approx(0.925, abs=0.06)
    assert laser_m[AHEAD] == pytest.approx(12.125 - 5.0, abs=0.1)


def test_without_an_echo_the_laser_says_its_range(simulator, flat):
    host = simulator(replace(flat, shapes=()))
    host.halt()
    host.step()
    assert min(host.read().laser_m) > 7.9 and max(host.read().laser_m) < 8.1


def test_odometry_goes_ahead_and_turns_to_the_left(simulator, flat):
    straight = driven(simulator(flat), 2.0, 0.5, 0.0).pose_in_odom
    assert straight.x_m == pytest.approx(1.0, abs=0.15) and abs(straight.y_m) < 0.1
    turned = driven(simulator(flat), 1.0, 0.0, 1.0).pose_in_odom
    assert turned.heading_rad == pytest.approx(1.0, abs=0.2) and abs(turned.x_m) < 0.05


def test_a_wall_presses_the_bumper(simulator, flat):
    # The wall on the right is a third of a metre from the body.
    facing = replace(flat, start=(5.0, 4.4, -math.pi / 2))
    assert not driven(simulator(facing), 0.3, 0.5, 0.0).is_bumped
    assert driven(simulator(facing), 1.5, 0.5, 0.0).is_bumped


@pytest.mark.skipif(RPL is None, reason="the command `rpl` is missing")
def test_a_plan_drives_it(simulator, flat, tmp_path):
    robot = EXAMPLES / simulator.__module__ / "robot.toml"
    plan = tmp_path / "plan.rpl"
    plan.write_text("(go-to 'door-mat)\n(print 'there)\n")
    with Served(simulator(flat)) as served:
        ended = subprocess.run(
            [RPL, "run", plan, "--world", "flat", "--robot", robot, "--host", "127.0.0.1:{}".format(served.address[1])],
            capture_output=True, text=True, timeout=300,
        )
    assert (ended.returncode, ended.stdout) == (0, "there\n"), ended.stderr
