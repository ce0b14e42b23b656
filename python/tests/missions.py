"""Missions as far as a host can tell, and hosts that are served as long as a test lasts."""

import json
import socket
import threading
import time
from typing import Any, Callable, Dict, List, Optional, Tuple

from rpl_host import Host, Record
from rpl_host._server import Server, Service

HELLO = {"type": "hello", "protocol": 2, "rpl": "0.2.0", "robot": "fly", "mission": "plan.rpl"}
FOREVER_S = 10.0
"""What a test waits for comes at once, or something is wrong."""


def commands(number: int, translation_mps: float = 0.5, **more: Any) -> Dict[str, Any]:
    speeds = {"translation_mps": translation_mps, "rotation_radps": 0.0}
    return {"type": "commands", "number": number, **speeds, "sonars_on": True, **more}


class Client:
    """A mission, as far as a host can tell."""

    def __init__(self, address: Tuple[str, int]) -> None:
        self.stream = socket.create_connection(address, timeout=FOREVER_S)
        self._lines = self.stream.makefile("rb")

    def say(self, *messages: Any) -> None:
        self.stream.sendall(b"".join(json.dumps(message).encode() + b"\n" for message in messages))

    def hear(self) -> Dict[str, Any]:
        line = self._lines.readline()
        assert line, "the line is closed"
        found: Dict[str, Any] = json.loads(line)
        return found

    def hear_until(self, fits: Callable[[Dict[str, Any]], bool]) -> Dict[str, Any]:
        """What comes first and is so."""
        message = self.hear()
        while not fits(message):
            message = self.hear()
        return message

    def farewell(self) -> str:
        """Why it has to go; then the line is closed."""
        reason: str = self.hear_until(lambda message: message["type"] == "bye")["reason"]
        assert self._lines.readline() == b""
        self.close()
        return reason

    def close(self) -> None:
        self._lines.close()
        self.stream.close()


class Served:
    """A host that is served in another thread as long as this lasts."""

    def __init__(self, host: Host, service: Service = Service(start_known=True)) -> None:
        self.record: Optional[Record] = None
        self.error: Optional[BaseException] = None
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address: Tuple[str, int] = self._listener.getsockname()
        self._ends = threading.Event()
        self.server = Server(host, self._listener, service, self._ends.is_set)
        self._thread = threading.Thread(target=self._serve)
        self._clients: List[Client] = []

    def _serve(self) -> None:
        try:
            self.record = self.server.run()
        except BaseException as error:
            self.error = error

    def __enter__(self) -> "Served":
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        # The host would wait for them.
        for client in self._clients:
            client.close()
        self.end()

    def end(self) -> None:
        self._ends.set()
        self.wait()

    def wait(self) -> None:
        self._thread.join(FOREVER_S)
        assert not self._thread.is_alive(), "the host does not end"

    def client(self, *messages: Any) -> Client:
        client = Client(self.address)
        self._clients.append(client)
        client.say(*messages)
        return client

    def mission(self, *messages: Any) -> Client:
        """One that has the robot."""
        client = self.client({**HELLO, "robot": self.server.host.robot}, *messages)
        assert client.hear()["type"] == "hello"
        return client


def until(fits: Callable[[], bool]) -> None:
    end_s = time.monotonic() + FOREVER_S
    while not fits():
        assert time.monotonic() < end_s, "it does not happen"
        time.sleep(0.001)
