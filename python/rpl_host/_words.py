"""What missions say, and how hosts write what they say."""

from __future__ import annotations

import hmac
import json
import math
import re
from dataclasses import dataclass
from typing import Any, Callable, Dict, Optional, Union

PROTOCOL = 2
"""The version of the messages."""

LONGEST_LINE = 1 << 20
"""Bytes of a line, at most."""

encode = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode


class WordsError(ValueError):
    """One clause that says why a line is no message."""


@dataclass(frozen=True)
class Hello:
    """How a mission greets."""

    protocol: int
    rpl: str
    robot: str
    mission: Optional[str] = None
    token: Optional[str] = None

    def unfit(self, robot: str, token: Optional[str]) -> Optional[str]:
        """Why a host of this robot cannot serve it, as a clause about it, if it cannot."""
        if self.protocol != PROTOCOL:
            return f"speaks version {self.protocol} of the messages, and this host {PROTOCOL}"
        # Whoever has no token learns nothing of what is here.
        if token is not None and self.token is None:
            return "has no token, and this host wants one: `--token-file FILE`"
        if token is not None and not hmac.compare_digest(token.encode(), (self.token or "").encode()):
            return "has another token than this host"
        if self.robot != robot:
            return f"is for the robot `{shortened(self.robot)}`, and this host moves `{robot}`"
        return None


@dataclass(frozen=True)
class Commands:
    """What the robot is to do until others come."""

    number: int
    translation_mps: float
    rotation_radps: float
    sonars_on: bool
    gripper: Union[None, str, Dict[str, str]] = None
    """``"release"``, or ``{"grasp": THING}``."""
    pan_radps: Optional[float] = None
    """How fast the camera is to turn; it is off without."""
    others: Optional[Dict[str, Any]] = None


@dataclass(frozen=True)
class Bye:
    """A farewell."""

    reason: Optional[str] = None

    def told(self) -> str:
        return "it says goodbye" if self.reason is None else f"it says goodbye: {shortened(self.reason)}"


def heard(line: bytes) -> Union[Hello, Commands, Bye]:
    """The message of a line."""
    try:
        return message_of(json.loads(line.decode("utf-8"), parse_constant=no_constant))
    except WordsError:
        raise
    except UnicodeDecodeError:
        raise WordsError("it is not UTF-8") from None
    except RecursionError:
        raise WordsError("it is nested too deeply") from None
    except ValueError as error:
        raise WordsError(f"it is not JSON: {shortened(str(error))}") from None


def message_of(message: Any) -> Union[Hello, Commands, Bye]:
    if not isinstance(message, dict):
        raise WordsError("it is no object")
    kind = message.pop("type", None)
    if kind == "hello":
        return Hello(**checked(
            message, {"protocol": whole, "rpl": text, "robot": text}, {"mission": text, "token": text}
        ))
    if kind == "commands":
        found = checked(
            message,
            {"number": whole, "translation_mps": real, "rotation_radps": real, "sonars_on": truth},
            {"gripper": gripper, "camera": camera, "others": signals},
        )
        found["pan_radps"] = found.pop("camera", None)
        return Commands(**found)
    if kind == "bye":
        return Bye(**checked(message, {}, {"reason": text}))
    raise WordsError("its `type` is none of hello, commands, bye")


Kind = Callable[[Any], Any]


def checked(message: Dict[str, Any], required: Dict[str, Kind], optional: Dict[str, Kind]) -> Dict[str, Any]:
    """The values of a message, each of its kind."""
    for name in required:
        if name not in message:
            raise WordsError(f"`{name}` is missing")
    found = {}
    for name, value in message.items():
        kind = required.get(name, optional.get(name))
        if kind is None:
            raise WordsError(f"`{shortened(name)}` is no key of it")
        if value is None and name in optional:
            continue
        try:
            found[name] = kind(value)
        except TypeError as error:
            raise WordsError(f"`{name}` is no {error}") from None
    return found


def whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 1 << 64:
        raise TypeError("count")
    return value


def real(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError("number")
    try:
        found = float(value)
    except OverflowError:
        found = math.inf
    if not math.isfinite(found):
        raise TypeError("finite number")
    return found


def truth(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError("truth value")
    return value


def text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("text")
    return value


def gripper(value: Any) -> Union[str, Dict[str, str]]:
    if value == "release":
        return "release"
    if isinstance(value, dict) and list(value) == ["grasp"]:
        return {"grasp": text(value["grasp"])}
    raise TypeError("order of a gripper")


def camera(value: Any) -> float:
    if not isinstance(value, dict) or list(value) != ["pan_radps"]:
        raise TypeError("order of a camera")
    return real(value["pan_radps"])


def signals(value: Any) -> Dict[str, Any]:
    if not isinstance(value, dict):
        raise TypeError("object with signals")
    return {name: signal(item) for name, item in value.items()}


def signal(value: Any) -> Any:
    if isinstance(value, (bool, str)):
        return value
    if isinstance(value, list):
        return [signal(item) for item in value]
    return real(value)


def no_constant(name: str) -> Any:
    raise WordsError(f"{name} is no number of JSON")


def line_of(kind: str, message: Dict[str, Any]) -> bytes:
    """A message as a line."""
    return (encode({"type": kind, **message}) + "\n").encode()


def bye(reason: Optional[str]) -> bytes:
    return line_of("bye", {} if reason is None else {"reason": reason})


def shortened(told: str) -> str:
    """What somebody has said, in a line that can be read."""
    visible = "".join(sign if sign.isprintable() else f"\\u{{{ord(sign):x}}}" for sign in told[:100])
    return visible + ("…" if len(told) > 100 else "")


def token_of(contents: str) -> str:
    """The token of a file's text: its only line."""
    token = contents.rstrip()
    if not 16 <= len(token) <= 1024:
        raise ValueError(f"the token has {len(token)} characters, and 16 to 1024 are expected")
    if not re.fullmatch("[!-~]+", token):
        raise ValueError("the token has other characters than ASCII letters, digits and signs, or more than a line")
    return token
