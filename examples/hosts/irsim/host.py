"""IR-SIM as a host, with a robot in a world of rpl: `python host.py flat.toml`."""

import sys
from pathlib import Path

import irsim
from rpl_host import Host, Reading
from rpl_host.worlds import Disc, World


class IrSim(Host):
    robot = "irsim-robot"
    start_known = True

    def __init__(self, world: World, seed: int = 1) -> None:
        self.env = irsim.make(str(Path(__file__).with_name("world.yaml")), headless=True, seed=seed)
        self.env.robot.set_state(world.start, init=True)
        self.env.add_objects([self.env.create_obstacle(**obstacle(shape)) for shape in world.shapes])

    def drive(self, translation_mps: float, rotation_radps: float) -> None:
        self.speeds = [translation_mps, rotation_radps]

    def step(self) -> None:
        self.env.step(self.speeds)

    def read(self) -> Reading:
        robot, scan = self.env.robot, self.env.get_lidar_scan()
        # Without a pose the host adds up the speeds, which here are what the wheels were told, not what they did.
        return Reading(None, None, None, *robot.velocity.flat, laser_m=scan["ranges"], bumped=robot.contact.in_contact)


def obstacle(shape):
    if isinstance(shape, Disc):
        return {"shape": {"name": "circle", "radius": shape.radius_m}, "state": [shape.x_m, shape.y_m, 0]}
    return {"shape": {"name": "polygon", "vertices": shape.corners}}


if __name__ == "__main__":
    IrSim(World.read(sys.argv.pop(1))).main()
