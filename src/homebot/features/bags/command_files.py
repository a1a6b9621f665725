"""Bags on the command line without a running homebot: their content, their repair, and recordings as bags."""

import argparse
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from homebot.devices import Device, GatewayNames, RawMessage, Sighting
from homebot.devices.command_messages import CommandResult
from homebot.devices.gateway_messages import Report
from homebot.devices.names import OWNER_REQUESTS
from homebot.devices.places_messages import OwnerRequest
from homebot.features.bags.bag_files import bag_files
from homebot.features.bags.bag_topic import BagMessage, BagTopic, qos_text
from homebot.features.bags.bag_writer import BagWriter
from homebot.features.bags.mcap_file import DamagedFileError
from homebot.features.bags.public_message import without_raw_secrets
from homebot.graph import QoSProfile
from homebot.messages.cdr import message_to_cdr
from homebot.messages.definition import definition_text
from homebot.messages.message import Message
from homebot.recording.lines import GatewayNews, LeaseNews, RecordedCommand
from homebot.recording.recording import Recording, load_recording
from homebot.support.printable import printable

_NAMES: Final[Mapping[type[Message], Callable[[Any], str]]] = {
    Sighting: lambda one: GatewayNames(one.gateway).received_topics,
    Report: lambda one: GatewayNames(one.gateway).readings,
    GatewayNews: lambda one: GatewayNames(one.gateway).state,
    RawMessage: lambda one: GatewayNames(one.gateway).received_data(*one.key.split("/")),
    OwnerRequest: lambda _: OWNER_REQUESTS,
    Device: lambda _: "/recording/devices",
    RecordedCommand: lambda _: "/recording/commands",
    CommandResult: lambda _: "/recording/outcomes",
    LeaseNews: lambda _: "/recording/leases",
}


def info(options: argparse.Namespace) -> int:
    """Print the content of a bag like ``ros2 bag info``."""
    files = bag_files(Path(options.bag))
    contents = [file.content() for file in files]
    used = [content for content in contents if sum(content.counts.values())]
    start, end = min((content.start for content in used), default=0), max((content.end for content in used), default=0)
    counts: Counter[BagTopic] = sum((Counter(content.counts) for content in contents), Counter())
    print(f"Files:             {', '.join(file.path.name for file in files)}")
    print(f"Bag size:          {sum(file.path.stat().st_size for file in files) / 1024:,.1f} KiB")
    print("Storage id:        mcap")
    print(f"Duration:          {(end - start) / 1e9:.3f} s")
    print(f"Start:             {_time(start)}")
    print(f"End:               {_time(end)}")
    print(f"Messages:          {counts.total():,}")
    for topic, count in sorted(counts.items(), key=lambda counted: counted[0].name):
        print(f"Topic:             {printable(topic.name)} | {printable(topic.ros_type)} | {count:,}")
    return 0


def recover(options: argparse.Namespace) -> int:
    """Copy the whole messages of a bag, and say if there are others."""
    files = bag_files(Path(options.bag))
    with BagWriter(Path(options.new)) as writer:
        for file in files:
            before = writer.count
            what = "messages, all that it has"
            try:
                for message in file.whole_messages():
                    writer.write(message)
            except DamagedFileError:
                what = "messages; others are cut off or damaged"
            print(f"{file.path}: {writer.count - before:,} {what}")
    return 0


def export(options: argparse.Namespace) -> int:
    """Write a recording of homebot as a bag."""
    recording = load_recording(Path(options.recording))
    with BagWriter(Path(options.new)) as writer:
        for message in recorded_messages(recording):
            writer.write(without_raw_secrets(message))
    print(f"{options.new}: {writer.count:,} messages")
    return 0


def _time(nanoseconds: int) -> str:
    return f"{datetime.fromtimestamp(nanoseconds / 1e9, UTC).astimezone():%Y-%m-%d %H:%M:%S} ({nanoseconds / 1e9:.3f})"


def recorded_messages(recording: Recording) -> Iterator[BagMessage]:
    """Yield the messages of *recording* in order of time; those from before its start come at its start."""
    start = recording.header.started_at
    began = start.sec * 1_000_000_000 + start.nanosec
    timed: list[tuple[float, Message]] = [
        (0.0, message) for message in (*recording.devices.values(), *recording.before)
    ]
    timed += [(event.at, event.message) for event in recording.events]
    timed += [
        (command.at, part)
        for command in recording.commands
        for part in (command.command, command.result)
        if part is not None
    ]
    timed += recording.leases
    for at, message in sorted(timed, key=lambda timed_message: timed_message[0]):
        name = _NAMES[type(message)](message)
        carried: Message = message.state if isinstance(message, GatewayNews) else message
        yield BagMessage(_topic(name, type(carried)), began + round(at * 1e9), message_to_cdr(carried))


@lru_cache(maxsize=1024)
def _topic(name: str, message_type: type[Message]) -> BagTopic:
    return BagTopic.of(name, message_type.ros_type, definition_text(message_type), qos_text([QoSProfile().to_plain()]))
