"""What hosts say is what the schema of the protocol has."""

import json
import unittest
from dataclasses import replace
from pathlib import Path

import pytest

from missions import HELLO, Served, commands
from rpl_host import CameraReading
from test_host import Fly

SCHEMA = Path(__file__).parents[2] / "protocol" / "schema" / "from-host.json"


class Messages(unittest.TestCase):
    def test_all_messages_fit_the_schema(self) -> None:
        jsonschema = pytest.importorskip("jsonschema")
        schema = jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text()))
        fly = Fly()
        fly.reading = replace(
            fly.reading, laser_m=[1.0, 2.0], sonar_m=[3.0], camera=CameraReading(0.1, b"\x00\x01\x02"),
            failed=["sonars"], gripper="closed", holding="cup", messages=["bring mail"],
            others={"heat": [20.5, "high", True]},
        )
        with Served(fly) as served:
            mission = served.client(HELLO)
            messages = [mission.hear()]
            mission.say(commands(0, camera={"pan_radps": 0.0}))
            messages.append(mission.hear())
            mission.say(HELLO)
            messages.append(mission.hear_until(lambda message: message["type"] == "bye"))
        self.assertEqual([message["type"] for message in messages], ["hello", "percept", "bye"])
        for message in messages:
            schema.validate(message)
        percept = messages[1]
        self.assertLessEqual({"laser_m", "sonar_m", "camera", "failed", "holding", "messages", "others"}, set(percept))
        with self.assertRaises(jsonschema.ValidationError):
            schema.validate({**percept, "bumped": None})
