"""The packets between the test broker and its clients, in words, with protocol errors."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Final, Literal, final

from homebot.mqtt.packets import (
    NO_PROPERTIES,
    Acknowledgement,
    Connack,
    Connect,
    Disconnect,
    Packet,
    PacketError,
    Properties,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    ReasonCode,
    Suback,
    Subscribe,
    Unsuback,
    Unsubscribe,
)

PROTOCOL_NAMES = {ProtocolVersion.V31: "3.1", ProtocolVersion.V311: "3.1.1", ProtocolVersion.V5: "5"}
"""Common names of the versions."""

_MAX_PAYLOAD = 120
_SECRET = ("authentication_data",)


def packet_text(packet: Packet) -> str:
    """Return one line about *packet*, without passwords and with long payloads cut."""
    properties = getattr(packet, "properties", NO_PROPERTIES)
    return f"{type(packet).__name__.upper()}{_FACTS.get(type(packet), _no_facts)(packet)}{_property_text(properties)}"


def _publish(packet: Publish) -> str:
    payload = repr(packet.payload[:_MAX_PAYLOAD].decode(errors="replace"))
    cut = f"… ({len(packet.payload)} bytes)" if len(packet.payload) > _MAX_PAYLOAD else ""
    number = f" id {packet.packet_id}" if packet.packet_id else ""
    flags = f"{' retain' if packet.retain else ''}{' dup' if packet.dup else ''}"
    return f" {packet.topic} {payload}{cut} QoS {packet.qos}{number}{flags}"


def _connect(packet: Connect) -> str:
    user = "" if packet.username is None else f", user {packet.username!r}"
    will = "" if packet.will is None else f", will on {packet.will.topic}"
    clean = "clean start" if packet.clean_start else "persistent session"
    name = f"{packet.client_id!r} MQTT {PROTOCOL_NAMES[packet.version]}"
    return f" {name}, {clean}, keep-alive {packet.keep_alive} s{user}{will}"


def _acknowledgement(packet: Acknowledgement) -> str:
    return f" id {packet.packet_id}{f' {packet.reason.text}' if packet.reason else ''}"


def _suback(packet: Suback) -> str:
    reasons = ", ".join(reason.text if reason.failed else f"QoS {int(reason)}" for reason in packet.reasons)
    return f" id {packet.packet_id}: {reasons}"


def _no_facts(_packet: Packet) -> str:
    return ""


_FACTS: Final[Mapping[type, Callable[[Any], str]]] = {
    Publish: _publish,
    Connect: _connect,
    Connack: lambda packet: f" {packet.reason.text}{', session present' if packet.session_present else ''}",
    Puback: _acknowledgement,
    Pubrec: _acknowledgement,
    Pubrel: _acknowledgement,
    Pubcomp: _acknowledgement,
    Subscribe: lambda packet: (
        f" id {packet.packet_id}: {', '.join(f'{wish.filter} QoS {wish.qos}' for wish in packet.filters)}"
    ),
    Suback: _suback,
    Unsubscribe: lambda packet: f" id {packet.packet_id}: {', '.join(packet.filters)}",
    Unsuback: lambda packet: f" id {packet.packet_id}: {', '.join(reason.text for reason in packet.reasons)}".rstrip(
        ": "
    ),
    Disconnect: lambda packet: f" {packet.reason.text}" if packet.reason else "",
}


def _property_text(properties: Properties) -> str:
    if properties == NO_PROPERTIES:
        return ""
    known = {field.name: getattr(properties, field.name) for field in fields(properties) if field.name not in _SECRET}
    shown = ", ".join(f"{name}={value!r}" for name, value in known.items() if value is not None and value != ())
    return f" [{shown}]" if shown else ""


MAX_PACKETS = 1000
"""How many are kept; beyond it the oldest is forgotten and counted."""


@dataclass(frozen=True, slots=True)
class PacketRecord:
    """One packet, or one event of a connection.

    Attributes:
        at: Seconds since the broker started.
        direction: ``in`` from a client, ``out`` to it, ``note`` an event such as a connection that was lost.
    """

    at: float
    direction: Literal["in", "out", "note"]
    client: str
    what: Packet | str

    def __str__(self) -> str:
        text = self.what if isinstance(self.what, str) else packet_text(self.what)
        return f"{self.at:9.4f} s  {self.client:20}  {_ARROWS[self.direction]}  {text}"


@final
class PacketLog:
    """The newest 1,000 records; may be read from any thread.

    Args:
        now: The time in seconds; the log counts from its making.
    """

    def __init__(self, now: Callable[[], float]) -> None:
        self.total = 0
        self._now = now
        self._start = now()
        self._records: deque[PacketRecord] = deque(maxlen=MAX_PACKETS)

    @property
    def records(self) -> tuple[PacketRecord, ...]:
        """Packets that are kept, the oldest first."""
        return tuple(self._records.copy())

    def add(self, direction: Literal["in", "out", "note"], client: str, what: Packet | str) -> None:
        """Note something that happens now."""
        self.total += 1
        self._records.append(PacketRecord(self._now() - self._start, direction, client, what))

    def text(self, newest: int = MAX_PACKETS) -> str:
        """Return the newest records in lines, ``→`` to the broker and ``←`` from it."""
        shown = self.records[-newest:]
        left_out = self.total - len(shown)
        lines = [f"… {left_out} earlier packets"] if left_out else []
        return "\n".join([*lines, *map(str, shown)])


_ARROWS = {"in": "→", "out": "←", "note": "·"}


_MAX_KEPT = 20
_NO_BREACH = (
    ReasonCode.KEEP_ALIVE_TIMEOUT,  # silence may be the purpose of a test
    ReasonCode.UNSUPPORTED_PROTOCOL_VERSION,  # clients try the newest first
    ReasonCode.BAD_AUTHENTICATION_METHOD,  # allowed, but not supported here
)


@dataclass(frozen=True, slots=True)
class ProtocolViolation:
    """One connection that the broker closed because its client broke the protocol."""

    client: str
    reason: ReasonCode
    problem: str

    def __str__(self) -> str:
        return f"client {self.client!r} broke the protocol: {self.problem} (0x{self.reason:02x}, {self.reason.text})"


@final
class ViolationLog:
    """The first 20 unread breaches; written on the broker's thread, read in any."""

    def __init__(self) -> None:
        self.untold = 0
        self._kept: deque[ProtocolViolation] = deque()

    @property
    def kept(self) -> tuple[ProtocolViolation, ...]:
        """In their order."""
        return tuple(self._kept.copy())

    def record(self, client: str, error: PacketError) -> None:
        """Note why a connection was closed, where that is a breach."""
        if error.code in _NO_BREACH:
            return
        if len(self._kept) == _MAX_KEPT:
            self.untold += 1
        else:
            self._kept.append(ProtocolViolation(client, error.code, error.problem))

    def clear(self) -> None:
        """Forget them, those that were not kept too."""
        self._kept.clear()
        self.untold = 0
