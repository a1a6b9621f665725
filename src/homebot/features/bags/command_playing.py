"""Playing of a bag into a running homebot, over the door."""

from __future__ import annotations

import argparse
import time
from collections import deque
from collections.abc import Callable, Iterable
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from homebot.bridges.rosbridge.access import right_to_publish
from homebot.devices import RawCommand
from homebot.devices.gateway_messages import Command
from homebot.devices.names import DEFINE_TYPE
from homebot.errors import HomebotError, PeerError, RefusedError, UsageError
from homebot.features.bags.bag_files import bag_files
from homebot.features.bags.bag_topic import CDR
from homebot.messages.cdr import message_from_cdr
from homebot.messages.json import message_to_json
from homebot.rights import Right
from homebot.support.name_patterns import fits_any
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.cli.door_client import DoorClient
    from homebot.features.bags.bag_topic import BagMessage, BagTopic
    from homebot.messages.message import Message

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
        player.go_on(lambda due=due: deque(door.until(due - time.monotonic()), 0))  # type: ignore[misc]
        player.publish(message)
    player.go_on(door.settle)
    print(f"{player.count:,} messages were played; topics: {_names(player.types)}")
    for reason, topics in player.left_out.items():
        print(f"left out, {reason}: {_names(topics)}")
    for name, (count, reason) in player.bad.items():
        print(f"left out, {count:,} messages of {printable(name)}: {printable(reason)}")
    return 0


@final
class _Player:
    """Publishes messages, each topic first advertised with its type.

    Attributes:
        count: The number of messages published.
        types: The types of the topics published.
        left_out: The topics left out, by the reason.
        bad: The other messages left out: how many by the name of the topic, and why the last.
    """

    def __init__(self, door: DoorClient, options: argparse.Namespace) -> None:
        self.count = 0
        self.types: dict[BagTopic, type[Message]] = {}
        self.left_out: dict[str, set[BagTopic]] = {}
        self.bad: dict[str, tuple[int, str]] = {}
        self._others: set[BagTopic] = set()
        self._door, self._patterns, self._commands = door, options.topics, options.commands

    def plays(self, topic: BagTopic) -> bool:
        """Return whether messages of *topic* are played."""
        if topic in self._others:
            return False
        if topic in self.types:
            return True
        if self._patterns and not fits_any(topic.name, self._patterns):
            return False
        if reason := self._why_left_out(topic):
            self._leave_out(topic, reason)
        return not reason

    def go_on(self, step: Callable[[], object]) -> None:
        """Take *step*, again while homebot refuses something sent before, which is left out."""
        while True:
            try:
                step()
            except RefusedError as exc:
                verb, _, name = exc.what.rpartition(" ")
                topics = [topic for topic in self.types if topic.name == name]
                if not topics:
                    raise
                if verb == "advertising":
                    self._leave_out(topics[0], f"as homebot refuses it ({exc.reason})")
                else:
                    self.count -= 1
                    self._count_bad(name, exc.reason)
            else:
                return

    def _leave_out(self, topic: BagTopic, reason: str) -> None:
        self._others.add(topic)
        self.types.pop(topic, None)
        self.left_out.setdefault(reason, set()).add(topic)

    def _count_bad(self, name: str, reason: str) -> None:
        self.bad[name] = (self.bad.get(name, (0, ""))[0] + 1, reason)

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
        """Publish *message*, unless it is none of its topic's type.

        Raises:
            LinkError: The connection broke.
        """
        topic = message.topic
        if topic not in self.types:
            self.go_on(self._door.settle)
            try:
                try:
                    self._door.call("/rosapi/message_details", {"type": topic.ros_type})
                except PeerError:  # homebot does not know it
                    self._door.ask(DEFINE_TYPE, {"type": topic.ros_type, "definition": topic.definition})
                self._door.advertise(topic.name, topic.ros_type, latch=topic.is_latched)
                self.types[topic] = topic.message_type()
                self.go_on(self._door.settle)
            except PeerError as exc:
                self._leave_out(topic, f"as homebot refuses it ({exc})")
            if topic in self._others:
                return
        try:
            fields = message_to_json(message_from_cdr(self.types[topic], message.data), finite=False)
        except HomebotError as exc:
            self._count_bad(topic.name, str(exc))
            return
        self._door.publish(topic.name, fields)
        self.count += 1
        if self.count % _SETTLED_EVERY == 0:
            self.go_on(self._door.settle)


def _names(topics: Iterable[BagTopic]) -> str:
    return ", ".join(sorted(printable(topic.name) for topic in topics))


def _is_own(topic: BagTopic) -> bool:
    return right_to_publish(topic.name) is Right.RAW or topic.ros_type.startswith("homebot/")
