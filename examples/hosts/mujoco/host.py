"""MuJoCo as a host, with a robot whose wheels slip in a world of rpl: `python host.py flat.toml`."""

import math
import sys
from pathlib import Path

import mujoco
import numpy as np
from rpl_host import Host, Reading
from rpl_host.worlds import Disc, World

WHEEL_M, TRACK_M, RANGE_M, HEIGHT_M = 0.08, 0.32, 8.0, 1.0
ANGLES_RAD = np.radians(np.arange(360) - 179.5)
RAYS = np.stack([np.cos(ANGLES_RAD), np.sin(ANGLES_RAD), np.zeros(360)], axis=1)


class MuJoCo(Host):
    robot = "mujoco-robot"
    start_known = True

    def __init__(self, world: World, seed: int = 1) -> None:
        self.random, self.bumped = np.random.default_rng(seed), False
        spec = mujoco.MjSpec.from_file(str(Path(__file__).with_name("robot.xml")))
        for shape in world.shapes:
            spec.worldbody.add_geom(**geom(shape))
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        x_m, y_m, heading_rad = world.start
        self.data.qpos[:7] = [x_m, y_m, 0.08, *turned(heading_rad)]
        mujoco.mj_forward(self.model, self.data)

    def drive(self, translation_mps: float, rotation_radps: float) -> None:
        aside_mps = rotation_radps * TRACK_M / 2
        self.data.ctrl[:] = (translation_mps - aside_mps) / WHEEL_M, (translation_mps + aside_mps) / WHEEL_M

    def step(self) -> None:
        self.bumped = False
        for _ in range(round(self.period_s / self.model.opt.timestep)):
            mujoco.mj_step(self.model, self.data)
            # Whoever presses against a wall trembles: the bumper feels the least touch in a period.
            self.bumped = self.bumped or self.is_touched()

    def read(self) -> Reading:
        left_mps, right_mps = (WHEEL_M * self.data.joint(name).qvel[0] for name in ("left", "right"))
        return Reading(
            translation_mps=(left_mps + right_mps) / 2,
            rotation_radps=(right_mps - left_mps) / TRACK_M,
            laser_m=self.scan_m(),
            bumped=self.bumped,
        )

    def scan_m(self) -> np.ndarray:
        laser, robot = self.data.site("laser"), self.model.body("robot").id
        distances_m, hit = np.empty(360), np.empty(360, np.int32)
        rays = (RAYS @ laser.xmat.reshape(3, 3).T).ravel()
        mujoco.mj_multiRay(
            self.model, self.data, laser.xpos, rays, None, True, robot, hit, distances_m, None, 360, RANGE_M
        )
        distances_m += self.random.normal(0.0, 0.01, 360)
        # The floor is without end: a ray hits it far away.
        return np.where(hit < 0, RANGE_M, np.minimum(distances_m, RANGE_M))

    def is_touched(self) -> bool:
        """Whether a part of the robot touches something else than the floor."""
        floor = self.model.geom("floor").id
        return bool(np.any(np.all(self.data.contact.geom != floor, axis=1)))


def turned(heading_rad: float) -> list:
    return [math.cos(heading_rad / 2), 0.0, 0.0, math.sin(heading_rad / 2)]


def geom(shape):
    if isinstance(shape, Disc):
        size, kind, turn = [shape.radius_m, HEIGHT_M, 0.0], mujoco.mjtGeom.mjGEOM_CYLINDER, turned(0.0)
    else:
        size = [shape.length_m / 2, shape.width_m / 2, HEIGHT_M]
        kind, turn = mujoco.mjtGeom.mjGEOM_BOX, turned(shape.heading_rad)
    return {"type": kind, "size": size, "pos": [shape.x_m, shape.y_m, 0.0], "quat": turn}


if __name__ == "__main__":
    MuJoCo(World.read(sys.argv.pop(1))).main()
