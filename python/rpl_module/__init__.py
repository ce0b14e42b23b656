"""Behaviours and fluents for RPL plans, in a process of their own.

A behaviour is a class with ``run``, which may wait; or with ``start``, ``step`` and ``stop``, which may not::

    from rpl_module import Behaviour, Module

    module = Module("lamp")

    @module.behaviour("blink")
    class Blink(Behaviour):
        def run(self, times: int = 3) -> None:
            try:
                for _ in range(times):
                    for is_on in (True, False):
                        module.set("lamp-on?*", is_on)
                        self.sleep(0.1)
            finally:
                module.set("lamp-on?*", False)

    module.run()

What it offers to plans, and how it is started, says its manifest.
"""

from ._action import Stopped
from ._module import Behaviour, Module
from ._values import Failure, Percept, Pose, Position, Symbol, Tick, Value

__all__ = ["Behaviour", "Failure", "Module", "Percept", "Pose", "Position", "Stopped", "Symbol", "Tick", "Value"]
__version__ = "0.2.0"
