"""The messages of a recording of homebot, on the topics that had them, or else below ``/recording``. Pure."""

from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import Any, Final

from homebot.devices import Device, GatewayNames, RawMessage, Sighting
from homebot.devices.command_messages import CommandResult
from homebot.devices.gateway_messages import Report
from homebot.devices.names import OWNER_REQUESTS
from homebot.devices.places_messages import OwnerRequest
from homebot.features.bags.bag_topic import BagMessage, BagTopic, qos_text
from homebot.graph import QoSProfile
from homebot.messages.cdr import message_to_cdr
from homebot.messages.definition import definition_text
from homebot.messages.message import Message
from homebot.recording.lines import GatewayNews, LeaseNews, RecordedCommand
from homebot.recording.recording import Recording

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
