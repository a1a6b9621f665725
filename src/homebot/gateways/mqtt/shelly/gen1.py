"""Shelly's first generation: who announces itself, and what is heard below ``shellies/``. Pure.

A device's model and mode say what it consists of; what it is heard to publish besides is added. It announces itself
on two topics at once, of which one counts where both say the same. One that does not announce itself is known once it
says that it is online and has published something known.

Source: Shelly Gen1 API, MQTT; iobroker.shelly 12.0.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from homebot.devices.identity import identifiers
from homebot.errors import WireError
from homebot.gateways.mqtt.bounded import Bounded
from homebot.gateways.mqtt.description import Availability, Described, Heard, Publication, Withdrawn
from homebot.gateways.mqtt.payload import clean_text, parse_object, shown
from homebot.gateways.mqtt.shelly.gen1_models import Gen1Model, find_model
from homebot.gateways.mqtt.shelly.gen1_parts import build_parts, is_known_topic
from homebot.gateways.mqtt.shelly.gen1_place import Gen1Place
from homebot.gateways.mqtt.shelly.online import OnlineTopic

__all__ = ["BIRTHS", "FILTERS", "Gen1"]

BIRTHS = (Publication("shellies/command", b"announce"), Publication("shellies/command", b"update"))
"""Make all devices announce themselves, and tell their states."""

FILTERS = (
    "shellies/announce",
    "shellies/+/announce",
    "shellies/+/online",
    *(f"shellies/+/{kind}/+" for kind in ("relay", "roller", "light", "color", "white", "input", "input_event")),
    *(f"shellies/+/{kind}/+/status" for kind in ("light", "color", "white")),
    *(f"shellies/+/{kind}/+/power" for kind in ("relay", "roller", "light", "color", "white")),
    *(f"shellies/+/{kind}/+/energy" for kind in ("relay", "roller", "light", "color", "white")),
    "shellies/+/emeter/+/+",
    *(f"shellies/+/{kind}/+" for kind in ("adc", "ext_temperature", "ext_humidity", "ext_switch", "sensor")),
    *(f"shellies/+/{kind}" for kind in ("temperature", "overtemperature", "overpower", "status")),
)
"""Narrow ones: what is below them is what parts are known by, and nothing else."""

_MAX_DEVICES = 5000
_LONGEST_NAME = 100
_HARDWARE_ID = re.compile(r"shelly[a-z0-9-]*-(?:[0-9a-f]{6}|[0-9a-f]{12})", re.IGNORECASE)
_NO_NAMES = frozenset({"announce", "command"})
_LEVELS = 3


@dataclass(slots=True)
class _Device:
    place: Gen1Place
    suffixes: set[str] = field(default_factory=set)
    model: Gen1Model | None = None
    model_name: str = ""
    mode: str = ""
    mac: str = ""
    version: str = ""
    address: str = ""
    is_announced: bool = False
    is_online: bool = False
    topic: str = ""


class Gen1:
    """Knows the devices of the first generation in one broker.

    There is room for 5,000: of more, the one that was named first and never described is forgotten.
    """

    def __init__(self) -> None:
        self._devices: Bounded[_Device] = Bounded(_MAX_DEVICES)
        self._names: dict[str, str] = {}

    @property
    def dropped(self) -> int:
        """How many devices were forgotten or not taken for want of room."""
        return self._devices.dropped

    def take(self, topic: str, payload: bytes) -> tuple[Heard, ...]:
        """Take a message below ``shellies/``.

        Raises:
            WireError: An announcement breaks the rules.
        """
        levels = topic.split("/", 2)
        if topic == "shellies/announce":
            return self._announced(topic, "", payload)
        if len(levels) < _LEVELS or levels[1] in _NO_NAMES or not 0 < len(levels[1]) <= _LONGEST_NAME:
            return ()
        _, name, suffix = levels
        if suffix == "announce":
            return self._announced(topic, name, payload) if payload else ()
        if suffix == "online":
            return self._online(topic, name, payload)
        return self._heard(topic, name, suffix) if payload and is_known_topic(suffix) else ()

    def _announced(self, topic: str, name: str, payload: bytes) -> tuple[Heard, ...]:
        told = parse_object(payload)
        device_id, mac = told.get("id"), told.get("mac", "")
        if not isinstance(device_id, str) or not 0 < len(device_id) <= _LONGEST_NAME or set(device_id) & set("+#/\0"):
            raise WireError(f"an announcement has the id {shown(device_id)}")
        if not isinstance(mac, str):
            raise WireError(f"an announcement has the mac {shown(mac)}")
        mac = clean_text(mac, 20)
        if not name and mac and mac in self._names:
            name = self._names[mac]
        device = self._device(name or device_id)
        if device is None:
            return ()
        gone = self._renamed(mac, device.place.name)
        before = _said(device)
        model_name, mode = told.get("model"), told.get("mode")
        device.model_name = clean_text(model_name, 40) if isinstance(model_name, str) else ""
        device.model = find_model(device.model_name, device_id)
        device.mode = mode if isinstance(mode, str) else ""
        device.mac = mac
        device.version = _text(told.get("fw_ver"))
        device.address = _text(told.get("ip"))
        if not device.is_announced:
            device.is_announced, device.topic = True, topic
        elif not gone and topic != device.topic and _said(device) == before:
            return ()
        return gone + self._described(device, topic)

    def _online(self, topic: str, name: str, payload: bytes) -> tuple[Heard, ...]:
        if payload == b"false" or not payload:
            return ()
        device = self._device(name)
        if device is None or device.is_online:
            return ()
        device.is_online = True
        return () if device.is_announced else self._described(device, topic)

    def _heard(self, topic: str, name: str, suffix: str) -> tuple[Heard, ...]:
        device = self._device(name)
        if device is None or suffix in device.suffixes:
            return ()
        known = _known(device)
        device.suffixes.add(suffix)
        is_news = _known(device) != known or not device.topic
        return self._described(device, topic) if is_news else ()

    def _device(self, name: str) -> _Device | None:
        device = self._devices.get(name)
        if device is None:
            device = _Device(Gen1Place(name))
            device.model = find_model("", name)
            if not self._devices.add(name, device):
                return None
        return device

    def _renamed(self, mac: str, name: str) -> tuple[Heard, ...]:
        if not mac:
            return ()
        before = self._names.get(mac)
        if before is None and len(self._names) >= _MAX_DEVICES:
            return ()
        self._names[mac] = name
        if before is None or before == name or self._devices.remove(before) is None:
            return ()
        return (Withdrawn(f"shellies/{before}", f"it is called {name} now"),)

    def _described(self, device: _Device, topic: str) -> tuple[Heard, ...]:
        if not (device.is_announced or device.is_online):
            return ()
        place = device.place
        parts = build_parts(place, device.model, _known(device))
        if not parts:
            return ()
        self._devices.keep(place.name)
        device.topic = device.topic or topic
        sleeps = device.model is not None and device.model.sleeps
        declared = (device.mac, place.name if _HARDWARE_ID.fullmatch(place.name) else "")
        return (
            Described(
                key=place.topic,
                convention="shelly",
                identifiers=identifiers(declared),
                name=clean_text(place.name),
                parts=parts,
                topic=device.topic,
                facts=_facts(device),
                availability=None if sleeps else Availability((OnlineTopic(place.at("online")),)),
                is_sighting=True,
            ),
        )


def _known(device: _Device) -> frozenset[str]:
    """What the device publishes: what is sure of its model, and what was heard."""
    model = device.model
    if model is None:
        return frozenset(device.suffixes)
    mode = model.modes.get(device.mode)
    if mode is not None:
        others = {kind for topics in model.modes.values() for kind in map(_kind, topics)}
        wrong = others - set(map(_kind, mode)) - {"input", "input_event"}
        return model.topics | mode | {suffix for suffix in device.suffixes if _kind(suffix) not in wrong}
    return model.topics | device.suffixes


def _said(device: _Device) -> tuple[str, ...]:
    return device.model_name, device.mode, device.mac, device.version, device.address


def _kind(suffix: str) -> str:
    return suffix.partition("/")[0]


def _facts(device: _Device) -> dict[str, str]:
    facts = {
        "manufacturer": "Shelly",
        "model": device.model_name or (device.model.name if device.model is not None else ""),
        "sw_version": device.version,
        "ip_address": device.address,
        "mode": clean_text(device.mode, 20),
    }
    return {name: value for name, value in facts.items() if value}


def _text(value: object) -> str:
    return clean_text(value) if isinstance(value, str) else ""
