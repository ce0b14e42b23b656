"""Behaviours that block: each works in a thread of its own, in the time of the run."""

from __future__ import annotations

import threading
from typing import Callable, Optional

NEXT_TICK_US = 1
"""Who sleeps for no time sleeps until the next tick."""


class Stopped(BaseException):
    """Raised by ``sleep`` and ``wait_until`` in a ``run`` that the plan needs no longer.

    It is no ``Exception``, so that ``except Exception`` does not keep it: put what must be undone into ``finally``.
    """


class Action:
    """A function that may sleep, in a thread of its own.

    In lock step either the thread or the loop of the module works, never both: what comes of it depends on nothing but
    the messages. With a live module the thread goes on beside the loop, which waits for nobody.
    """

    def __init__(self, work: Callable[[], None], now_us: int, in_lock_step: bool) -> None:
        self._work = work
        self._now_us = now_us
        self._in_lock_step = in_lock_step
        self._changed = threading.Condition()
        self._sleeps_until_us: Optional[int] = None
        self._is_stopped = False
        self.is_over = False
        self._thread = threading.Thread(target=self._run, daemon=True)

    def begin(self) -> None:
        """Lets it work: in lock step until it sleeps or is over."""
        with self._changed:
            self._thread.start()
            self._let_go_on()

    def sleep_us(self, duration_us: int) -> None:
        """Called in the thread: returns after so much time of the run, at the earliest with the next tick."""
        if threading.current_thread() is not self._thread:
            raise RuntimeError("only `run` itself can sleep: a thread that it has started, or `start` and `step`, cannot")
        with self._changed:
            self._sleeps_until_us = self._now_us + max(NEXT_TICK_US, duration_us)
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._is_stopped or self._sleeps_until_us is None)
            if self._is_stopped:
                raise Stopped()

    def tick(self, now_us: int) -> None:
        """Time has passed."""
        with self._changed:
            self._now_us = now_us
            if self._sleeps_until_us is not None and self._sleeps_until_us <= now_us:
                self._sleeps_until_us = None
                self._changed.notify_all()
                self._let_go_on()

    def stop(self, patience_s: Optional[float] = None) -> None:
        """It is to end: it hears of it where it sleeps. Waits for its end in lock step, or for so long."""
        with self._changed:
            self._is_stopped = True
            self._changed.notify_all()
            if self._in_lock_step or patience_s is not None:
                self._changed.wait_for(lambda: self.is_over, patience_s)

    def _let_go_on(self) -> None:
        if self._in_lock_step:
            self._changed.wait_for(lambda: self.is_over or self._sleeps_until_us is not None)

    def _run(self) -> None:
        try:
            self._work()
        finally:
            with self._changed:
                self.is_over = True
                self._changed.notify_all()
