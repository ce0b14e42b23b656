"""A robot or a simulator of your own, as the host of RPL missions.

A host is a class with ``read`` and ``drive``::

    from rpl_host import Host, Reading

    class Mine(Host):
        robot = "my-robot"      # the `name` in the robot's file
        period_s = 0.05         # its `step`

        def read(self) -> Reading:
            x_m, y_m, heading_rad = base.odometry()
            return Reading(x_m, y_m, heading_rad, laser_m=[min(r, 8.0) for r in laser.scan()])

        def drive(self, translation_mps: float, rotation_radps: float) -> None:
            base.set_speeds(translation_mps, rotation_radps)

    Mine().main()

It listens for missions (``rpl run PLAN --host 127.0.0.1:7300``), keeps time, and switches the motors off when no
commands come, when the mission is gone and when the bumper is pressed.
"""

from ._guard import Halt
from ._host import Host
from ._reading import CameraReading, Reading, ReadingError, Signal
from ._server import Record

__all__ = ["CameraReading", "Halt", "Host", "Reading", "ReadingError", "Record", "Signal"]
__version__ = "0.2.0"
