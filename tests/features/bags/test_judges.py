"""Bags of homebot are read by rosbags, and those of rosbags by homebot."""

from pathlib import Path
from typing import Any

import pytest
from tests.features.bags.bags import START, topic
from tests.messages.test_ros_packages import golden
from tests.messages.test_type_hash import WITH_CHAR

from homebot.features.bags.bag_files import bag_files
from homebot.features.bags.bag_topic import BagMessage
from homebot.features.bags.bag_writer import BagWriter
from homebot.graph import QoSProfile, qos_profile_latched
from homebot.graph.qos import LivelinessPolicy, ReliabilityPolicy
from homebot.messages.cdr import message_from_cdr
from homebot.messages.interfaces import find_message

highlevel: Any = pytest.importorskip("rosbags.highlevel")
rosbag2: Any = pytest.importorskip("rosbags.rosbag2")
typesys: Any = pytest.importorskip("rosbags.typesys")

SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT, deadline=1.5)
WATCHED = QoSProfile(liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, liveliness_lease_duration=2.0)


def write_golden(path: Path) -> dict[str, bytes]:
    """Write a message of each type of ROS 2's packages; return them by topic."""
    written = {}
    with BagWriter(path) as writer:
        for number, (name, _, raw) in enumerate(one for one in golden() if one[0] not in WITH_CHAR):
            described = topic(f"/golden/t{number}", find_message(name))
            writer.write(BagMessage(described, START + number, raw))
            written[described.name] = raw
    return written


@pytest.mark.parametrize("name", ["golden", "golden.mcap"])
def test_rosbags_decodes_every_message(tmp_path: Path, name: str) -> None:
    written = write_golden(tmp_path / name)
    found = {}
    with highlevel.AnyReader([tmp_path / name]) as reader:
        for connection, _, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            found[connection.topic] = bytes(reader.typestore.serialize_cdr(message, connection.msgtype))
    assert found == written


@pytest.mark.parametrize("name", ["qos", "qos.mcap"])
def test_rosbags_reads_the_quality_of_service_and_the_hash(tmp_path: Path, name: str) -> None:
    offered = {"/latched": qos_profile_latched, "/sensor": SENSOR, "/watched": WATCHED, "/plain": QoSProfile()}
    with BagWriter(tmp_path / name) as writer:
        for one, qos in offered.items():
            writer.write(BagMessage(topic(one, qos=qos), START, b"\x00\x01\x00\x00\x01\x00\x00\x00\x00"))
    with highlevel.AnyReader([tmp_path / name]) as reader:
        found = {one.topic: one.ext.offered_qos_profiles[0] for one in reader.connections}
        hashes = {one.digest for one in reader.connections}
    for one, qos in offered.items():
        read, infinite = found[one], 9_223_372_036
        assert (read.depth, read.history.name, read.reliability.name) == (qos.depth, "KEEP_LAST", qos.reliability.name)
        assert (read.durability.name, read.liveliness.name) == (qos.durability.name, qos.liveliness.name)
        assert read.deadline.sec == (int(qos.deadline) or infinite)
        assert read.liveliness_lease_duration.sec == (int(qos.liveliness_lease_duration) or infinite)
    assert found["/sensor"].deadline.nsec == 500_000_000
    if name == "qos":  # its reader takes it from the metadata
        assert hashes == {topic("/any").type_hash}


@pytest.mark.parametrize("compressed", [None, "STORAGE", "MESSAGE"])
def test_a_bag_of_rosbags_with_a_type_of_its_own_is_read(tmp_path: Path, compressed: str | None) -> None:
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    store.register(typesys.get_types_from_msg("string name\ngeometry_msgs/Point[2] ends\n", "acme_msgs/msg/Wall"))
    point, wall = store.types["geometry_msgs/msg/Point"], store.types["acme_msgs/msg/Wall"]
    plugin = rosbag2.StoragePlugin.MCAP
    writer = rosbag2.Writer(tmp_path / "theirs", version=9, storage_plugin=plugin)
    if compressed is not None:
        writer.set_compression(rosbag2.CompressionMode[compressed], rosbag2.CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/walls", "acme_msgs/msg/Wall", typestore=store)
        made = wall(name="north", ends=[point(x=0.0, y=1.0, z=2.0), point(x=3.0, y=4.0, z=5.0)])
        writer.write(connection, START, store.serialize_cdr(made, "acme_msgs/msg/Wall"))
    (file,) = bag_files(tmp_path / "theirs")
    (message,) = file.messages()
    assert (message.topic.name, message.topic.ros_type, message.at) == ("/walls", "acme_msgs/msg/Wall", START)
    found: Any = message_from_cdr(message.topic.message_type(), message.data)
    assert (found.name, found.ends[1].z) == ("north", 5.0)
