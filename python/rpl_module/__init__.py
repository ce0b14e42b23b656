"""Behaviours and fluents for RPL plans, in a process of their own.

A behaviour is a class with ``start``, ``step`` and ``stop``::

    from rpl_module import Behaviour, Module, Tick

    module = Module("lamp")

    @module.behaviour("blink")
    class Blink(Behaviour):
        def start(self, times: int = 3) -> None:
            self.left = 2 * times

        def step(self, tick: Tick) -> None:
            module.set("lamp-on?*", self.left % 2 == 0)
            self.left -= 1
            if self.left < 0:
                self.succeed()

    module.run()

What it offers to plans, and how it is started, says its manifest.
"""

from ._module import Behaviour, Module
from ._values import Failure, Percept, Pose, Position, Symbol, Tick, Value

__all__ = ["Behaviour", "Failure", "Module", "Percept", "Pose", "Position", "Symbol", "Tick", "Value"]
__version__ = "0.2.0"
