"""What a host does for safety by itself, whatever a mission is."""

from __future__ import annotations

import enum
from typing import Dict, Optional

SILENCE_S = 0.3
"""A host that hears no commands for this time stops the motors, by the clock on the wall."""


class Halt(enum.Enum):
    """Why motors are off."""

    UNUSED = "no mission has given commands yet"
    SILENCE = f"no commands for {SILENCE_S} s"
    LINE_CLOSED = "the mission is gone"
    BUMPER = "the bumper is pressed"


class Guard:
    """Stands between commands and motors. Times are of one clock that never goes back, in seconds."""

    def __init__(self) -> None:
        self.halt: Optional[Halt] = Halt.UNUSED
        self.counts: Dict[Halt, int] = {Halt.SILENCE: 0, Halt.LINE_CLOSED: 0, Halt.BUMPER: 0}
        """How often it has cut the motors. What happens to a robot that stands is not counted."""
        self._heard_s = 0.0
        self._was_bumped = False

    def heard(self, at_s: float) -> None:
        """Commands, or the same again, have come. A robot that the bumper stops comes to stand first."""
        self._heard_s = max(self._heard_s, at_s)
        if self.halt is not Halt.BUMPER:
            self.halt = None

    def line_closed(self) -> None:
        """The mission is gone."""
        self._begin(Halt.LINE_CLOSED)

    def silent_at_s(self) -> Optional[float]:
        """When the silence cuts the motors if nothing comes; none if nobody may drive anyway."""
        return self._heard_s + SILENCE_S if self.halt in (None, Halt.BUMPER) else None

    def look_at_clock(self, now_s: float) -> Optional[Halt]:
        """The halt that begins now for want of commands, if one does."""
        silent_s = self.silent_at_s()
        if silent_s is None or now_s < silent_s:
            return None
        if self.halt is Halt.BUMPER:
            # The bumper has cut the motors already, and that was counted.
            self.halt = Halt.SILENCE
            return self.halt
        return self._begin(Halt.SILENCE)

    def look_at_bumper(self, is_bumped: bool, stands: bool) -> Optional[Halt]:
        """The halt that begins by what was perceived, if one does. Once the robot stands it may back off."""
        is_new = is_bumped and not self._was_bumped
        self._was_bumped = is_bumped
        if self.halt is Halt.BUMPER and stands:
            self.halt = None
        return self._begin(Halt.BUMPER) if is_new and self.halt is None else None

    def _begin(self, halt: Halt) -> Halt:
        self.halt = halt
        self.counts[halt] += 1
        return halt
