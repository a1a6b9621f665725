"""Relays and rollers of Shelly's first generation. Pure.

Source: Shelly Gen1 API, MQTT of Shelly1, Shelly2.5 and Plug.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from homebot.devices.value import PlainValue
from homebot.gateways.mqtt.description import Publication
from homebot.gateways.mqtt.part_table import BytesPart, PartTable
from homebot.gateways.mqtt.readings import NOTHING, Readings, number_in, text_in
from homebot.gateways.mqtt.shelly.gen1_place import Gen1Place
from homebot.gateways.mqtt.table_codec import raw_bytes
from homebot.gateways.mqtt.wanted import wanted_flag, wanted_number, wanted_option

__all__ = ["SWITCHED", "build_relay", "build_roller"]

SWITCHED: Mapping[str, Readings] = MappingProxyType(
    {"on": {"on_off": True}, "off": {"on_off": False}, "overpower": {"on_off": False}}
)
"""What the words of a relay or light mean; one that drew too much power was switched off."""

_MOVEMENTS: Mapping[str, Readings] = MappingProxyType(
    {
        "open": {"movement": "opening"},
        "close": {"movement": "closing"},
        "stop": {"movement": "stopped"},
    }
)
_ORDERS = {"open": b"open", "closed": b"close", "stopped": b"stop"}
_FULLY_OPEN = 100


def build_relay(place: Gen1Place, index: int, *, is_plug: bool) -> BytesPart:
    """Describe a relay: a plug where it is a socket."""
    topic = place.at(f"relay/{index}")

    def read(payload: bytes) -> Readings:
        return SWITCHED.get(text_in(payload) or "", NOTHING)

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (Publication(f"{topic}/command", b"on" if wanted_flag("on_off", value) else b"off"),)

    part = PartTable(raw_bytes, f"relay:{index}", "plug" if is_plug else "switch", advertised="relay")
    part.reads(topic, read)
    part.listens(f"{topic}/command")
    part.offers("on_off", writer=write)
    return part


def build_roller(place: Gen1Place, index: int) -> BytesPart:
    """Describe a roller. One that was never calibrated does not know its position, and says -1."""
    topic = place.at(f"roller/{index}")

    def read(payload: bytes) -> Readings:
        return _MOVEMENTS.get(text_in(payload) or "", NOTHING)

    def read_position(payload: bytes) -> Readings:
        position = number_in(text_in(payload))
        if position is None:
            return NOTHING
        return {"position": position if 0 <= position <= _FULLY_OPEN else None}

    def move(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (Publication(f"{topic}/command", _ORDERS[wanted_option("movement", value, _ORDERS)]),)

    def go(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        position = round(wanted_number("position", value, 0, _FULLY_OPEN, "%"))
        return (Publication(f"{topic}/command/pos", b"%d" % position),)

    part = PartTable(raw_bytes, f"roller:{index}", "window_covering", advertised="roller")
    part.reads(topic, read)
    part.reads(f"{topic}/pos", read_position)
    part.listens(f"{topic}/command")
    part.listens(f"{topic}/command/pos")
    part.offers("movement", writer=move, options=("open", "closed", "opening", "closing", "stopped"))
    part.offers("position", writer=go)
    return part
