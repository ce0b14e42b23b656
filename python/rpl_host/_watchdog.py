"""Cuts the motors of a robot one of whose methods does not return."""

from __future__ import annotations

import threading
import time
from types import TracebackType
from typing import Callable, Optional, Type


class Watchdog:
    """Calls something from a thread of its own when a piece of work takes longer than it may.

    The thread runs only while this is entered. Where there is nothing to call there is no thread.
    """

    def __init__(self, halt: Optional[Callable[[], None]]) -> None:
        self._halt = halt
        self._changed = threading.Condition()
        self._due_s: Optional[float] = None
        self._is_over = False

    def __enter__(self) -> Watchdog:
        if self._halt is not None:
            threading.Thread(target=self._watch, args=(self._halt,), daemon=True).start()
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        with self._changed:
            self._is_over = True
            self._changed.notify()

    def expect(self, due_s: Optional[float]) -> None:
        """Work begins that has to be over by a time of the monotonic clock; none if it is over, or may take long."""
        with self._changed:
            self._due_s = due_s
            self._changed.notify()

    def _watch(self, halt: Callable[[], None]) -> None:
        with self._changed:
            while not self._is_over:
                left_s = None if self._due_s is None else self._due_s - time.monotonic()
                if left_s is not None and left_s <= 0.0:
                    self._due_s = None
                    halt()
                else:
                    self._changed.wait(left_s)
