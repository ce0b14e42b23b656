"""A lamp that blinks, and a light sensor: two things a robot of yours may have and rpl does not know."""

import math
from typing import Optional

from rpl_module import Behaviour, Failure, Module, Tick

module = Module("lamp")


@module.each_tick
def sense(tick: Tick) -> None:
    """The corridor has a window at each end of it: it is brighter there."""
    if tick.position is not None:
        module.set("light*", 0.5 + 0.5 * math.cos(tick.position.x_m / 4))


@module.behaviour("blink")
class Blink(Behaviour):
    def start(self, times: int = 3) -> None:
        if times < 1:
            raise Failure("lamp-failure", f"a lamp cannot blink {times} times", times=times)
        self.steps_left = 4 * times

    def step(self, tick: Tick) -> None:
        self.steps_left -= 1
        module.set("lamp-on?*", self.steps_left % 4 >= 2)
        if self.steps_left == 0:
            self.succeed()

    def stop(self, reason: str) -> None:
        module.set("lamp-on?*", False)


if __name__ == "__main__":
    module.run()
