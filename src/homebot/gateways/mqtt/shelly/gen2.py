"""Shelly's second generation and later: who is there, and what they answer when asked. Pure.

These devices do not announce themselves. One that says that it is online, or tells anything, is asked who it is, how
it is set up and how it is; the last answer makes it known. One that sleeps most of the time tells its whole status
when it wakes, which does as well.

Source: Shelly Gen2+ API, General (RPC Protocol, Notifications) and MQTT.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from homebot.devices.identity import identifiers
from homebot.devices.part import Part
from homebot.errors import WireError
from homebot.gateways.mqtt.bounded import Bounded
from homebot.gateways.mqtt.description import Availability, Described, DescribedPart, Heard, Question, Withdrawn
from homebot.gateways.mqtt.payload import clean_text, parse_object, shown
from homebot.gateways.mqtt.readings import json_in, number_in
from homebot.gateways.mqtt.shelly.gen2_answers import fields_in, is_prefix, kind_of, sleeps, tells_change, text_of
from homebot.gateways.mqtt.shelly.gen2_component import Fields, Gen2Place
from homebot.gateways.mqtt.shelly.gen2_parts import build_parts
from homebot.gateways.mqtt.shelly.online import OnlineTopic
from homebot.gateways.mqtt.shelly.rpc import call

__all__ = ["MAX_ANSWER_BYTES", "Gen2"]

MAX_ANSWER_BYTES = 128 * 1024
"""Longest answer; that of a gateway with all the sensors it takes is about 40 kB."""

_MAX_DEVICES = 3000
_MAX_KEPT_BYTES = 32 * 1024 * 1024
_QUESTIONS = ("Shelly.GetDeviceInfo", "Shelly.GetConfig", "Shelly.GetStatus")
_NOTHING: Fields = MappingProxyType({})
_PLUGS = ("plug", "pstrip", "powerstrip", "outdoors")


@dataclass(slots=True)
class _Device:
    prefix: str
    info: Fields = field(default_factory=dict)
    config: Fields = field(default_factory=dict)
    status: Fields = field(default_factory=dict)
    sizes: dict[str, int] = field(default_factory=dict)
    heard: int = 0
    described: Described | None = None


class Gen2:
    """Knows the devices of the second generation in one broker.

    There is room for 3,000: of more, the one that was heard first and never described is forgotten. Answers are kept
    up to 32 MB together.

    Args:
        client: As whom homebot asks; answers come on ``<client>/rpc`` and ``<client>/<prefix>/rpc``.
        prefixes: Filters of prefixes of several levels.
    """

    def __init__(self, client: str, prefixes: tuple[str, ...]) -> None:
        self.filters = (
            f"{client}/rpc",
            *(f"{client}/{prefix}/rpc" for prefix in ("+", *prefixes)),
            *(f"{prefix}/{rest}" for prefix in ("+", *prefixes) for rest in ("online", "events/rpc")),
        )
        self._client = client
        self._devices: Bounded[_Device] = Bounded(_MAX_DEVICES, self._release)
        self._kept = 0
        self._refused = 0

    def knows(self, prefix: str) -> bool:
        """Whether a device of this generation was heard at *prefix*."""
        return self._devices.get(prefix) is not None

    @property
    def dropped(self) -> int:
        """How many devices or answers were forgotten or not taken for want of room."""
        return self._devices.dropped + self._refused

    def take(self, topic: str, payload: bytes, *, retained: bool) -> tuple[Heard, ...]:
        """Take a message on one of the filters.

        Raises:
            WireError: An answer breaks the rules.
        """
        if topic == f"{self._client}/rpc":
            return self._answered("", payload)
        if topic.startswith(f"{self._client}/") and topic.endswith("/rpc"):
            return self._answered(topic.removeprefix(f"{self._client}/").removesuffix("/rpc"), payload)
        if topic.endswith("/events/rpc"):
            return self._notified(topic.removesuffix("/events/rpc"), payload)
        return self._online(topic.removesuffix("/online"), payload, retained=retained)

    def _online(self, prefix: str, payload: bytes, *, retained: bool) -> tuple[Heard, ...]:
        if not payload:
            return self._gone(prefix)
        if payload != b"true":
            return ()
        device = self._device(prefix)
        if device is None:
            return ()
        if device.described is not None:
            return () if retained else (self._question(device),)
        return (self._question(device),) if retained else self._asked(device)

    def _gone(self, prefix: str) -> tuple[Heard, ...]:
        device = self._devices.remove(prefix)
        if device is None:
            return ()
        self._release(device)
        return (Withdrawn(prefix, "its online topic was removed"),) if device.described is not None else ()

    def _release(self, device: _Device) -> None:
        self._kept -= sum(device.sizes.values())

    def _notified(self, prefix: str, payload: bytes) -> tuple[Heard, ...]:
        frame = json_in(payload)
        if not isinstance(frame, dict):
            return ()
        device = self._device(prefix)
        if device is None:
            return ()
        method, params = frame.get("method"), frame.get("params")
        if not isinstance(params, dict):
            return ()
        if device.described is not None:
            return (self._question(device),) if method == "NotifyEvent" and tells_change(params) else ()
        asked = self._asked(device)
        if method == "NotifyFullStatus" and self._keep(device, "status", params, len(payload)):
            return self._described(device, f"{prefix}/events/rpc", text_of(frame.get("src"))) + asked
        return asked

    def _answered(self, prefix: str, payload: bytes) -> tuple[Heard, ...]:
        frame = parse_object(payload, MAX_ANSWER_BYTES)
        result, source = frame.get("result"), frame.get("src")
        if not isinstance(result, dict):
            return ()
        if not isinstance(source, str):
            raise WireError(f"an answer has the src {shown(source)}")
        device = self._device(prefix or source)
        kind = kind_of(result)
        if device is None or not kind or not self._keep(device, kind, result, len(payload)):
            return ()
        return self._described(device, f"{device.prefix}/rpc", text_of(source))

    def _device(self, prefix: str) -> _Device | None:
        device = self._devices.get(prefix)
        if device is None and is_prefix(prefix):
            device = _Device(prefix)
            if not self._devices.add(prefix, device):
                return None
        return device

    def _asked(self, device: _Device) -> tuple[Heard, ...]:
        """Ask at the first sign of life, the second, the fourth, the eighth: it may be no Shelly at all."""
        device.heard += 1
        return (self._question(device),) if device.heard & (device.heard - 1) == 0 else ()

    def _question(self, device: _Device) -> Question:
        source = f"{self._client}/{device.prefix}"
        return Question(device.prefix, tuple(call(device.prefix, source, method) for method in _QUESTIONS))

    def _keep(self, device: _Device, kind: str, result: Fields, size: int) -> bool:
        grown = size - device.sizes.get(kind, 0)
        if size > MAX_ANSWER_BYTES or self._kept + grown > _MAX_KEPT_BYTES:
            self._refused += 1
            return False
        self._kept += grown
        device.sizes[kind] = size
        match kind:
            case "info":
                device.info = result
            case "config":
                device.config = result
            case _:
                device.status = result
        return True

    def _described(self, device: _Device, topic: str, device_id: str) -> tuple[Heard, ...]:
        mac = text_of(device.info.get("mac")) or text_of(fields_in(device.status, "sys").get("mac"))
        if not device.status or not mac:
            return ()
        device_id = text_of(device.info.get("id")) or device_id
        models = f"{device_id} {text_of(device.info.get('app'))}".casefold()
        place = Gen2Place(
            device.prefix,
            self._client,
            f"{self._client}/{device.prefix}/rpc",
            is_plug=any(word in models for word in _PLUGS),
        )
        parts = build_parts(place, device.status, device.config)
        if not parts:
            return self._emptied(device)
        self._devices.keep(device.prefix)
        described = Described(
            key=device.prefix,
            convention="shelly",
            identifiers=identifiers((mac, device_id if device_id.casefold().startswith("shelly") else "")),
            name=_name(device),
            parts=parts,
            topic=topic if device.described is None else device.described.topic,
            facts=_facts(device),
            availability=None if sleeps(device.status) else Availability((OnlineTopic(f"{device.prefix}/online"),)),
            is_sighting=True,
        )
        if device.described is not None and _looks(device.described) == _looks(described):
            return ()
        device.described = described
        return (described,)

    def _emptied(self, device: _Device) -> tuple[Heard, ...]:
        if device.described is None:
            return ()
        device.described = None
        return (Withdrawn(device.prefix, "no component of it is left"),)


def _looks(described: Described) -> tuple[tuple[Part, ...], str, Mapping[str, str], tuple[str, ...]]:
    parts: tuple[DescribedPart, ...] = described.parts
    return tuple(one.part for one in parts), described.name, described.facts, described.identifiers


def _name(device: _Device) -> str:
    own = text_of(device.info.get("name"))
    return own or text_of(fields_in(fields_in(device.config, "sys"), "device").get("name")) or clean_text(device.prefix)


def _facts(device: _Device) -> dict[str, str]:
    generation = number_in(device.info.get("gen"))
    facts = {
        "manufacturer": "Shelly",
        "model": text_of(device.info.get("model")),
        "model_id": text_of(device.info.get("app")),
        "sw_version": text_of(device.info.get("ver")),
        "generation": "" if generation is None else f"{generation:g}",
    }
    return {name: value for name, value in facts.items() if value}
