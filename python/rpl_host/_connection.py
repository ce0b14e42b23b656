"""The line to somebody who has connected; it never waits."""

from __future__ import annotations

import socket
from collections import deque
from typing import Any, Deque, List, Optional, Tuple

from ._words import LONGEST_LINE

LINE_S = 2.0
"""From its first byte to its end a line takes no longer, in either direction."""

READ_AT_ONCE = 1 << 16


def address_of(told: Tuple[Any, ...]) -> str:
    """The address that a socket tells, as people write it."""
    name, port = told[:2]
    return f"[{name}]:{port}" if ":" in name else f"{name}:{port}"


class LineFault(Exception):
    """One clause about whoever is connected that says why the line ends."""


class Connection:
    """Lines from a socket and to it. Times are of one clock that never goes back, in seconds."""

    def __init__(self, stream: socket.socket, address: str, now_s: float) -> None:
        stream.setblocking(False)
        stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.stream = stream
        self.address = address
        self.since_s = now_s
        self.leaves_by_s: Optional[float] = None
        """It has been said farewell to: what is left is written until then, and nothing is heard any more."""
        self._heard = bytearray()
        self._line_began_s = 0.0
        self._unsent: Deque[Tuple[bytes, float]] = deque()
        """What is left of lines, and since when each waits."""

    def receive(self, now_s: float) -> List[bytes]:
        """The lines that are complete now."""
        try:
            data = self.stream.recv(READ_AT_ONCE)
        except (BlockingIOError, InterruptedError):
            return []
        except OSError as error:
            raise LineFault(f"its line is broken: {error.strerror}") from None
        if not data:
            raise LineFault("it has closed the line")
        if not self._heard:
            self._line_began_s = now_s
        *ends, rest = data.split(b"\n")
        lines = []
        for end in ends:
            lines.append(bytes(self._heard + end))
            self._heard.clear()
            self._line_began_s = now_s
        self._heard += rest
        if any(len(line) > LONGEST_LINE for line in (*lines, self._heard)):
            raise LineFault(f"it has sent a line of more than {LONGEST_LINE} bytes")
        return lines

    def look(self, now_s: float, line_s: float) -> None:
        """A line that has begun has to end, and one that is written has to be taken."""
        if self._heard and now_s - self._line_began_s > line_s:
            raise LineFault(f"it has sent a line that has not ended within {line_s:.1f} s")
        if self._unsent and now_s - self._unsent[0][1] > line_s:
            raise LineFault("it does not take what it is sent")

    def send(self, line: bytes, now_s: float) -> None:
        """Writes what can be written now, and the rest later."""
        self._unsent.append((line, now_s))
        self.flush()

    def flush(self) -> None:
        """Writes what can be written now."""
        while self._unsent:
            line, since_s = self._unsent[0]
            try:
                count = self.stream.send(line)
            except (BlockingIOError, InterruptedError):
                return
            except OSError:
                # Whoever reads this line finds out why it is broken.
                self._unsent.clear()
                return
            if count < len(line):
                self._unsent[0] = (line[count:], since_s)
                return
            self._unsent.popleft()

    def unsent(self) -> int:
        """The lines that wait to be written."""
        return len(self._unsent)

    def close_for_writing(self) -> None:
        """The other end is to hear what was written, and then that nothing more comes."""
        try:
            self.stream.shutdown(socket.SHUT_WR)
        except OSError:
            pass
