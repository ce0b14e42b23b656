"""Recordings for ROS tools: two readers that know nothing of each other find in them what the run was."""

import json
import math

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from test_experiment import command

PLAN = "(log \"off\") (go-to 'corner) (log \"there\")"

#: What is computed twice differs by no more; the trace has fewer digits.
NEAR = 1e-6


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mcap")
    (folder / "plan.rpl").write_text(PLAN)
    words = ["--world", "test-room", "--robot", "b21-laser", "--seed", "4", "-q", "--mcap", "run.mcap"]
    command(folder, "run", "plan.rpl", *words, "--trace", "run.jsonl", "--trace-poses", "20")
    return folder


def by_mcap(run):
    """All messages by topic, with their times, as `mcap` and `mcap-ros2-support` decode them."""
    found = {}
    with open(run / "run.mcap", "rb") as file:
        reader, decoders = make_reader(file), DecoderFactory()
        assert reader.get_header().profile == "ros2"
        for schema, channel, message in reader.iter_messages():
            said = decoders.decoder_for(channel.message_encoding, schema)(message.data)
            if "jsonschema" in channel.metadata:
                required = json.loads(channel.metadata["jsonschema"])["required"]
                said = json.loads(said.data)
                assert set(required) <= set(said)
            found.setdefault(channel.topic, []).append((message.log_time // 1000, said))
    return found


def heading(turn):
    return 2 * math.atan2(turn.z, turn.w)


def test_both_readers_find_the_same_messages(run):
    first = by_mcap(run)
    second = {}
    with AnyReader([run / "run.mcap"]) as reader:
        for connection, time_ns, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            second.setdefault(connection.topic, []).append((time_ns // 1000, message))
    topics = {"/map", "/tf", "/tf_static", "/odom", "/scan", "/sonars", "/cmd_vel", "/pose", "/certainty"}
    assert topics | {"/belief", "/plan", "/ground_truth", "/log", "/events"} == set(second)
    for topic, messages in second.items():
        assert [time for time, _ in messages] == [time for time, _ in first[topic]], topic
    for (_, one), (_, other) in zip(first["/scan"], second["/scan"], strict=True):
        assert list(one.ranges) == list(other.ranges)
    for (_, one), (_, other) in zip(first["/belief"], second["/belief"], strict=True):
        assert list(one.data) == list(other.data)
    for (_, one), (_, other) in zip(first["/pose"], second["/pose"], strict=True):
        assert one.pose.pose.position.x == other.pose.pose.position.x
        assert list(one.pose.covariance) == list(other.pose.covariance)


def test_poses_and_events_are_those_of_the_trace(run):
    found = by_mcap(run)
    lines = [json.loads(line) for line in (run / "run.jsonl").read_text().splitlines()[1:]]
    events = [line for line in lines if line["kind"] != "pose"]
    assert [said for _, said in found["/events"]] == events
    assert [said["text"] for _, said in found["/log"]] == ["off", "there"]
    traced = {round(line["time_s"] * 1e6): line for line in lines if line["kind"] == "pose"}
    compared = 0
    for topic, key in [("/pose", "estimated"), ("/ground_truth", "true")]:
        for time, message in found[topic]:
            if time not in traced:
                continue
            pose = message.pose.pose if topic == "/pose" else message.pose
            x, y, turned = traced[time][key]
            assert [pose.position.x, pose.position.y] == pytest.approx([x, y], abs=0.006)
            assert math.cos(heading(pose.orientation) - turned) == pytest.approx(1, abs=1e-4)
            compared += 1
    assert compared > 100


def test_frames_lead_from_the_map_to_the_estimate(run):
    found = by_mcap(run)
    poses = dict(found["/pose"])
    odometry = dict(found["/odom"])
    for time, message in found["/tf"]:
        to_odom, to_base = message.transforms
        assert (to_odom.header.frame_id, to_odom.child_frame_id) == ("map", "odom")
        assert (to_base.header.frame_id, to_base.child_frame_id) == ("odom", "base_link")
        assert to_base.transform.translation.x == odometry[time].pose.pose.position.x
        # Between two estimates the robot is where dead reckoning leads from the last.
        if time not in poses:
            continue
        turned = heading(to_odom.transform.rotation)
        x, y = to_base.transform.translation.x, to_base.transform.translation.y
        there = to_odom.transform.translation
        known = poses[time].pose.pose.position
        assert there.x + math.cos(turned) * x - math.sin(turned) * y == pytest.approx(known.x, abs=NEAR)
        assert there.y + math.sin(turned) * x + math.cos(turned) * y == pytest.approx(known.y, abs=NEAR)


def test_the_map_and_the_belief_are_grids_over_the_world(run):
    found = by_mcap(run)
    (_, world), *more = found["/map"]
    assert not more and world.info.width * world.info.resolution == pytest.approx(8, abs=0.2)
    assert set(world.data) <= {-1, 0, 100} and 100 in world.data
    for _, belief in found["/belief"]:
        assert len(belief.data) == belief.info.width * belief.info.height
        # What the scale of powers of ten says, cell by cell, is a probability of one in all.
        area = belief.info.resolution**2
        total = sum(10 ** (6 * cell / 100 - 4) * area for cell in belief.data if cell > 0)
        assert 0.8 < total < 1.25
