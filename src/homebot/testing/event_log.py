"""The log of everything that happens in a virtual house, with times, to read and compare."""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import AsyncIterator, Iterable, Iterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from typing import Literal, cast

from homebot.cli.watch_lines import HouseLines, WatchLine, fitted, line_cells
from homebot.clock import Clock
from homebot.devices.capabilities import CAPABILITIES, OWN, SETTABLE
from homebot.devices.device import DeviceChange, StateChange, part_names
from homebot.devices.journal_messages import JournalEntry, ReadJournal
from homebot.devices.names import JOURNAL_ENTRIES, READ_JOURNAL
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import to_seconds
from homebot.errors import ClosedError, ServiceError
from homebot.graph import EntityKind, GraphChange, Node, QoSProfile, qos_profile_rosout
from homebot.messages import Message
from homebot.messages.json import message_to_json
from homebot.messages.rcl_interfaces import Log
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import MqttConnection
from homebot.testing.contexts import in_background
from homebot.testing.house import TestHouse
from homebot.testing.virtual_house import VirtualHouse

MAX_EVENTS = 100_000

NODE = "event_log"


@dataclass(frozen=True, slots=True)
class HouseEvent:
    """A logged event.

    Attributes:
        at: Seconds since the Unix epoch, in the time of the house.
        source: A message on MQTT, a message on a topic of the graph, or a change of the graph.
        said: The original payload or message; or the entity concerned.
    """

    at: float
    source: Literal["mqtt", "topic", "graph"]
    name: str
    said: bytes | Message | str

    @property
    def text(self) -> str:
        """The payload as text, made on demand because most events are never read."""
        match self.said:
            case bytes():
                return self.said.decode(errors="backslashreplace")
            case Message():
                return json.dumps(message_to_json(self.said), ensure_ascii=False)
            case _:
                return self.said

    def __str__(self) -> str:
        stamp = datetime.fromtimestamp(self.at, UTC).isoformat(sep=" ", timespec="milliseconds")
        return f"{stamp[:23]} {self.source} {self.name} {self.text}"


class EventLog:
    """A log of the last 100,000 events of a house; older ones are dropped."""

    def __init__(self, clock: Clock) -> None:
        self.events: deque[HouseEvent] = deque(maxlen=MAX_EVENTS)
        self.lost = 0
        self._clock = clock

    def __str__(self) -> str:
        return "".join(f"{event}\n" for event in self.events)

    def record(self, source: Literal["mqtt", "topic", "graph"], name: str, said: bytes | Message | str) -> None:
        """Add an event at the current time."""
        self.lost += len(self.events) == MAX_EVENTS
        self.events.append(HouseEvent(self._clock.now(), source, name, said))

    @classmethod
    @asynccontextmanager
    async def of(cls, house: TestHouse) -> AsyncIterator[EventLog]:
        """Log *house* during the block: all messages on MQTT and the graph, and all nodes that come and go.

        It begins with the journal of the time before, such as the first commands of apps. It runs a node ``/event_log``
        and an ordinary client of the broker. The pytest fixtures already keep one: ``house.log``.
        """
        log = cls(house.runtime.graph.clock)
        async with Node(house.runtime.graph, NODE) as node, house.client(NODE) as connection:
            await connection.subscribe(MqttSubscription("#"))
            await connection.wait_connected()
            works = (
                partial(_read_mqtt, connection, log),
                partial(_read_graph, node, log),
                partial(_read_journal, node, log),
            )
            async with in_background(*works):
                house.log = log
                if isinstance(house, VirtualHouse):
                    await house.settle()
                yield log


async def _read_journal(node: Node, log: EventLog) -> None:
    """Put the journal of the time before the log first."""
    with suppress(ServiceError):
        answer = await node.create_client(ReadJournal, READ_JOURNAL).call(ReadJournal.Request())
        known = [event.said for event in log.events]
        before = (HouseEvent(entry.at.to_seconds(), "topic", JOURNAL_ENTRIES, entry) for entry in answer.entries)
        log.events.extendleft(reversed([event for event in before if event.said not in known]))


async def _read_mqtt(connection: MqttConnection, log: EventLog) -> None:
    while True:
        try:
            messages = await connection.receive()
        except ClosedError:
            return
        for message in messages:
            log.record("mqtt", message.topic, message.payload)


async def _read_graph(node: Node, log: EventLog) -> None:
    topics: set[str] = set()
    # Its publisher comes with its first entry, which a subscription made then would miss.
    _record_topic(node, log, topics, JournalEntry, JOURNAL_ENTRIES)
    with node.graph.watch() as changes:
        for info in node.graph.get_endpoints():
            _follow(node, log, topics, GraphChange("added", info))
        async for change in changes:
            if change.entity.node != node.full_name:
                log.record(
                    "graph", change.entity.kind.value, f"{change.change} {change.entity.name} of {change.entity.node}"
                )
                _follow(node, log, topics, change)


def _follow(node: Node, log: EventLog, topics: set[str], change: GraphChange) -> None:
    info = change.entity
    if change.change == "removed" or info.kind is not EntityKind.PUBLISHER or info.name in topics:
        return
    message_type = node.graph.get_message_type(info.name)
    if message_type is not None:
        _record_topic(node, log, topics, message_type, info.name)


def _record_topic(node: Node, log: EventLog, topics: set[str], message_type: type[Message], name: str) -> None:
    topics.add(name)

    def on_message(message: Message) -> None:
        log.record("topic", name, message)

    # An app may have logged before the house was ready.
    qos = qos_profile_rosout if message_type is Log else QoSProfile(depth=1000)
    node.create_subscription(message_type, name, on_message, qos)


LINES = 36
"""Together with the lines above and the title below 40."""

WIDTH = 120


def house_report(house: TestHouse) -> str:
    """Return the time in *house*, its crashes, and the newest commands and changes in its log.

    If there are many, changes of measurements, such as power, are left out.
    """
    now = datetime.fromtimestamp(house.runtime.graph.clock.now(), UTC)
    happened = list(_lines(house.log.events))
    older = len(happened) - LINES
    if older > 0:
        happened = list(_lines(event for event in house.log.events if not _is_measured(event.said)))
    return "\n".join(
        [
            f"it is {now:%Y-%m-%d %H:%M:%S} UTC in the house; crashed: {', '.join(house.crashed) or 'nothing'}",
            *(f"{name}: {why}" for name, why in house.failures.items()),
            *([f"({older} older or measured changes are left out; print(house.log) has all)"] if older > 0 else []),
            *(happened[-LINES:] or ["no device was commanded or changed; print(house.log) shows every message"]),
        ]
    )


def _is_measured(said: bytes | Message | str) -> bool:
    return isinstance(said, StateChange) and all(
        CAPABILITIES.get(reading.capability, OWN).kind == "number" and reading.capability not in SETTABLE
        for reading in said.readings
    )


def _lines(events: Iterable[HouseEvent]) -> Iterator[str]:
    names: dict[str, str] = {}
    lines = HouseLines(names)
    written: list[WatchLine] = []
    for event in events:
        match event.said:
            case DeviceChange(device=device):
                names |= {key: name for key, name in part_names((device,)).items() if name}
            case StateChange():
                lines.add_change(cast("StateChange", JsonMessage(message_to_json(event.said))), event.at)
            case JournalEntry():
                lines.add_entry(cast("JournalEntry", JsonMessage(message_to_json(event.said))), event.at)
        written += lines.pop(event.at)
    for line in (*written, *lines.pop(math.inf)):
        stamp = f"{datetime.fromtimestamp(to_seconds(line.at), UTC):%H:%M:%S.%f}"[:-3]
        yield fitted(line_cells(line, names, stamp), WIDTH)
