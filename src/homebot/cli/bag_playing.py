"""Playing of a bag into a running homebot, over the door."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from homebot.bags.bag_files import bag_files
from homebot.bags.bag_topic import CDR
from homebot.bridges.rosbridge.access import right_to_publish
from homebot.devices import RawCommand
from homebot.devices.client_rights import Right
from homebot.devices.gateway_messages import Command
from homebot.devices.names import DEFINE_TYPE
from homebot.errors import PeerError, UsageError
from homebot.messages.cdr import message_from_cdr
from homebot.messages.json import message_to_json
from homebot.support.name_patterns import fits_any
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.bags.bag_topic import BagMessage, BagTopic
    from homebot.cli.door_client import DoorClient
    from homebot.messages.message import Message

__all__ = ["play"]

_COMMANDS: Final = {
    RawCommand.ros_type,
    Command.ros_type,
    "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/TwistStamped",
}
"""The types of messages that set something in motion."""

_SETTLED_EVERY: Final = 100
"""Messages: the door reads a client that is too fast more slowly, and would answer the last call too late."""

_GOAL: Final = "/goal_pose"


def play(door: DoorClient, options: argparse.Namespace) -> int:
    """Publish the messages of a bag, and say which topics were left out."""
    player = _Player(door, options)
    began, first = time.monotonic(), None
    for message in chain.from_iterable(file.messages() for file in bag_files(Path(options.bag))):
        if not player.plays(message.topic):
            continue
        first = message.at if first is None else first
        due = began + (message.at - first) / 1e9 / options.rate
        for _ in door.until(due - time.monotonic()):  # raises what was refused
            pass
        player.publish(message)
    door.settle()
    print(f"{player.count:,} messages were played; topics: {_names(player.types)}")
    for reason, topics in player.left_out.items():
        print(f"left out, {reason}: {_names(topics)}")
    return 0


@final
class _Player:
    """Publishes messages, each topic first advertised with its type.

    Attributes:
        count: The number of messages published.
        types: The types of the topics published.
        left_out: The topics left out, by the reason.
    """

    def __init__(self, door: DoorClient, options: argparse.Namespace) -> None:
        self.count = 0
        self.types: dict[BagTopic, type[Message]] = {}
        self.left_out: dict[str, set[BagTopic]] = {}
        self._others: set[BagTopic] = set()
        self._door, self._patterns, self._commands = door, options.topics, options.commands

    def plays(self, topic: BagTopic) -> bool:
        """Return whether messages of *topic* are played."""
        if topic in self.types:
            return True
        if topic in self._others or (self._patterns and not fits_any(topic.name, self._patterns)):
            return False
        if reason := self._why_left_out(topic):
            self._others.add(topic)
            self.left_out.setdefault(reason, set()).add(topic)
        return not reason

    def _why_left_out(self, topic: BagTopic) -> str:
        if topic.ros_type in _COMMANDS or topic.name.endswith(_GOAL):
            return "" if self._commands else "as they are commands (--commands plays them)"
        if not self._patterns and _is_own(topic):
            return "as they are homebot's own (--topics plays them)"
        if topic.encodings != CDR:
            return f"as homebot reads {CDR[0]} of {CDR[1]}"
        try:
            topic.message_type()
        except UsageError as exc:  # rosbag2 records services and actions with the texts of these
            return str(exc)
        return ""

    def publish(self, message: BagMessage) -> None:
        """Publish *message*; errors as for :meth:`DoorClient.settle`, and that it is none of its topic's type."""
        topic = message.topic
        message_type = self.types.get(topic)
        if message_type is None:
            message_type = self.types[topic] = self._advertised(topic)
        self._door.publish(topic.name, message_to_json(message_from_cdr(message_type, message.data), finite=False))
        self.count += 1
        if self.count % _SETTLED_EVERY == 0:
            self._door.settle()

    def _advertised(self, topic: BagTopic) -> type[Message]:
        try:
            self._door.call("/rosapi/message_details", {"type": topic.ros_type})
        except PeerError:  # homebot does not know it
            self._door.ask(DEFINE_TYPE, {"type": topic.ros_type, "definition": topic.definition})
        self._door.advertise(topic.name, topic.ros_type, latch=topic.is_latched)
        return topic.message_type()


def _names(topics: Iterable[BagTopic]) -> str:
    return ", ".join(sorted(printable(one.name) for one in topics))


def _is_own(topic: BagTopic) -> bool:
    return right_to_publish(topic.name) is Right.RAW or topic.ros_type.startswith("homebot/")
