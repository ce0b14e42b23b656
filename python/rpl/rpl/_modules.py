"""Modules in Python that are called in this process."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, Protocol
from weakref import WeakKeyDictionary


class Hearing(Protocol):
    """A module: what `rpl_module.Module` is."""

    def hear(self, message: dict[str, Any], /) -> list[dict[str, Any]]:
        """Takes in one message of the protocol, and gives the answers."""


#: The conversation that each module is in.
_current: WeakKeyDictionary[Hearing, object] = WeakKeyDictionary()


def opened(module: Hearing) -> Callable[[], Callable[[str], str]]:
    """What begins a conversation with a module, and ends the one before: a function from lines to lines of JSON."""
    if not callable(getattr(module, "hear", None)):
        raise TypeError(f"{module!r} is no module; `rpl_module.Module(...)` is one")

    def begin() -> Callable[[str], str]:
        conversation = object()
        _current[module] = conversation

        def turn(lines: str) -> str:
            if _current[module] is not conversation:
                raise RuntimeError("the module serves a newer mission")
            answers = [answer for line in lines.splitlines() for answer in module.hear(json.loads(line))]
            return "\n".join(json.dumps(answer, allow_nan=False) for answer in answers)

        return turn

    return begin
