"""Relays and rollers of Shelly's first generation. Pure.

Source: Shelly Gen1 API, MQTT of Shelly1, Shelly2.5 and Plug.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.decode import NO_READINGS, Readings, to_text
from homebot.conventions.description import Publication
from homebot.conventions.part_builder import BytesPart, PartBuilder
from homebot.conventions.shelly.gen1_topics import Gen1Topics
from homebot.conventions.table_codec import raw_bytes
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = ["SWITCHED", "build_relay", "build_roller"]

SWITCHED: Mapping[str, Readings] = MappingProxyType(
    {"on": {"on_off": True}, "off": {"on_off": False}, "overpower": {"on_off": False}}
)
"""Readings of the payloads of a relay or light; one that drew too much power was switched off."""

_MOVEMENTS: Mapping[str, Readings] = MappingProxyType(
    {
        "open": {"movement": "opening"},
        "close": {"movement": "closing"},
        "stop": {"movement": "stopped"},
    }
)
_ORDERS = {"open": b"open", "closed": b"close", "stopped": b"stop"}
_FULLY_OPEN = 100


def build_relay(topics: Gen1Topics, index: int, *, is_plug: bool) -> BytesPart:
    """Describe a relay: a plug where it is a socket."""
    topic = topics.at(f"relay/{index}")

    def read(payload: bytes) -> Readings:
        return SWITCHED.get(to_text(payload) or "", NO_READINGS)

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (Publication(f"{topic}/command", b"on" if require_bool("on_off", value) else b"off"),)

    part = PartBuilder(raw_bytes, f"relay:{index}", "plug" if is_plug else "switch", advertised="relay")
    part.read_from(topic, read)
    part.add_command_topics(f"{topic}/command")
    part.add_capability("on_off", writer=write)
    return part


def build_roller(topics: Gen1Topics, index: int) -> BytesPart:
    """Describe a roller. One that was never calibrated does not know its position, and says -1."""
    topic = topics.at(f"roller/{index}")

    def read(payload: bytes) -> Readings:
        return _MOVEMENTS.get(to_text(payload) or "", NO_READINGS)

    def read_position(payload: bytes) -> Readings:
        position = to_number(to_text(payload))
        if position is None:
            return NO_READINGS
        return {"position": position if 0 <= position <= _FULLY_OPEN else None}

    def move(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (Publication(f"{topic}/command", _ORDERS[require_option("movement", value, _ORDERS)]),)

    def go(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        position = round(require_number("position", value, 0, _FULLY_OPEN, "%"))
        return (Publication(f"{topic}/command/pos", b"%d" % position),)

    part = PartBuilder(raw_bytes, f"roller:{index}", "window_covering", advertised="roller")
    part.read_from(topic, read)
    part.read_from(f"{topic}/pos", read_position)
    part.add_command_topics(f"{topic}/command")
    part.add_command_topics(f"{topic}/command/pos")
    part.add_capability("movement", writer=move, options=("open", "closed", "opening", "closing", "stopped"))
    part.add_capability("position", writer=go)
    return part
