"""Tours through `flat` with another simulator as the host: who arrives, and how far off the robot believes to be.

    python examples/hosts/tours.py irsim --seeds 50101-50120 --unknown-start

Each seed is a tour of four places in an order of its own. `rpl` has to be installed, or `--rpl` says where it is.
"""

import argparse
import importlib.util
import json
import math
import random
import socket
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

from rpl_host.worlds import World

FOLDER = Path(__file__).parent
PLACES = 4
RIGHT_M, RIGHT_RAD, SURE = 0.5, math.radians(10.0), 0.9
"""What `rpl localize` calls right and sure."""


def simulator(name):
    """The class of the host, and where its robot really is."""
    spec = importlib.util.spec_from_file_location(f"{name}_host", FOLDER / name / "host.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if name == "irsim":
        return module.IrSim, lambda host: host.env.robot.state.flat[:3]

    def pose(host):
        x_m, y_m, _, w, _, _, z = host.data.qpos[:7]
        return x_m, y_m, 2 * math.atan2(z, w)

    return module.MuJoCo, pose


def measured(kind, true_pose):
    """The same host, which notes where it is after each period, and when contacts begin."""

    class Measured(kind):
        def step(self):
            super().step()
            self.poses = getattr(self, "poses", [])
            self.poses.append(tuple(map(float, true_pose(self))))

        def read(self):
            reading = super().read()
            was, self.was_bumped = getattr(self, "was_bumped", False), bool(reading.bumped)
            self.contacts = getattr(self, "contacts", 0) + (self.was_bumped and not was)
            return reading

        def tell(self, notice):
            if "behind" in notice or "motors" in notice:
                print(f"  {notice}", file=sys.stderr)

    return Measured


def tour(kind, world_file, world, robot, seed, options):
    """What came of one tour."""
    host = kind(World.read(world_file), seed=seed)
    host.start_known = not options.unknown_start
    listener = socket.create_server(("127.0.0.1", 0))
    address = "127.0.0.1:{}".format(listener.getsockname()[1])
    serving = threading.Thread(target=host.serve, args=(listener,), kwargs={"factor": options.speed, "once": True})
    serving.start()
    order = random.Random(seed).sample(sorted(world), PLACES)
    plan, trace = world_file.with_name("tour.rpl"), world_file.with_name("trace.jsonl")
    plan.write_text("".join(f"(go-to '{place})\n(log '{place})\n" for place in order))
    ended = subprocess.run(
        [options.rpl, "run", plan, "--world", "flat", "--robot", robot, "--host", address, "--seed", str(seed),
         "--trace", trace, "--trace-poses", "20", "--until", "900s"],
        capture_output=True, text=True,
    )
    host.stop()
    serving.join()
    lines = [json.loads(line) for line in trace.read_text().splitlines()]

    def truth(time_s):
        # A plan begins with the first percept.
        return host.poses[min(round(time_s / host.period_s), len(host.poses) - 1)]

    arrivals = [line for line in lines if line.get("kind") == "log"]
    errors = []
    for line in lines:
        if line.get("kind") == "pose" and line["certainty"] >= SURE:
            (x_m, y_m, heading_rad), (true_x_m, true_y_m, true_rad) = line["estimated"], truth(line["time_s"])
            turned_rad = abs(math.remainder(heading_rad - true_rad, math.tau))
            errors.append((math.hypot(x_m - true_x_m, y_m - true_y_m), turned_rad))
    there = sum(
        math.dist(truth(line["time_s"])[:2], world[place]) <= RIGHT_M for line, place in zip(arrivals, order)
    )
    return {
        "seed": seed,
        "succeeded": ended.returncode == 0 and there == PLACES,
        "arrivals": there,
        "contacts": host.contacts,
        "time_s": lines[-1]["time_s"],
        "sure": len(errors),
        "wrong": sum(off_m > RIGHT_M or turned_rad > RIGHT_RAD for off_m, turned_rad in errors),
        "error_m": sum(off_m for off_m, _ in errors) / max(len(errors), 1),
        "error_deg": math.degrees(sum(turned_rad for _, turned_rad in errors) / max(len(errors), 1)),
        "why": "" if ended.returncode == 0 else ended.stderr.strip().splitlines()[-1],
    }


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("simulator", choices=["irsim", "mujoco"])
    options.add_argument("--seeds", default="1-3", help="the first and the last one")
    options.add_argument("--unknown-start", action="store_true", help="the mission has to find out where the robot is")
    options.add_argument("--speed", type=float, default=2.0, help="how many times faster than the clock")
    options.add_argument("--rpl", default="rpl", help="the command")
    options = options.parse_args()
    first, _, last = options.seeds.partition("-")
    kind = measured(*simulator(options.simulator))
    robot = FOLDER / options.simulator / "robot.toml"
    tours = []
    with tempfile.TemporaryDirectory() as folder:
        world_file = Path(folder) / "flat.toml"
        subprocess.run([options.rpl, "worlds", "flat", "--toml", world_file], check=True, capture_output=True)
        places = World.read(world_file).places
        for seed in range(int(first), int(last or first) + 1):
            tours.append(tour(kind, world_file, places, robot, seed, options))
            print(json.dumps(tours[-1]), flush=True)
    sure, wrong = (sum(tour[key] for tour in tours) for key in ("sure", "wrong"))
    errors_m = sorted(tour["error_m"] for tour in tours)
    print(
        f"{sum(tour['succeeded'] for tour in tours)} of {len(tours)} tours, "
        f"{sum(tour['arrivals'] for tour in tours)} of {PLACES * len(tours)} places, "
        f"{sum(tour['contacts'] for tour in tours)} contacts, {sum(tour['time_s'] for tour in tours):.0f} s; "
        f"mean error {sum(errors_m) / len(errors_m):.3f} m ({errors_m[0]:.3f} to {errors_m[-1]:.3f}); "
        f"sure {sure}, of these wrong {wrong} ({100 * wrong / max(sure, 1):.2f} %)"
    )


if __name__ == "__main__":
    main()
