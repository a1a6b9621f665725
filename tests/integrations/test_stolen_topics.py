"""A hostile announcement in a house of real products: whatever it names, it is told nothing that is another's.

The broker lets the intruder publish on its own topics alone: there it announces what it likes, in whose name it likes.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.integrations.real_devices import announcing, rows_of
from tests.sizes import examples

from homebot.conventions.convention import Convention
from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication
from homebot.conventions.installed_conventions import default_conventions, find_conventions
from homebot.devices.value import PlainValue
from homebot.discovery import DeviceIndex
from homebot.errors import RefusedError
from homebot.gateways.announced.announcement import StoredAnnouncement
from homebot.gateways.mqtt.reserved import ReservedTopics
from homebot.messages import Time

pytestmark = pytest.mark.slow

HOSTILE = "homeassistant:light/intruder"
RESERVED = (
    "$SYS/broker/log",
    "homebot/computer/mqtt/status",
    "homebot/things/door/td",
    "homeassistant/light/victim/config",
    "homeassistant/device/victim/config",
    "homeassistant/status",
    "zigbee2mqtt/bridge/request/permit_join",
    "zigbee2mqtt/bridge/devices",
    "tasmota/discovery/2462AB03B2A1/config",
    "cmnd/tasmotas/POWER",
    "home425/lights/lamp/out",
)


@lru_cache(maxsize=1)
def understood() -> ReservedTopics:
    return ReservedTopics(find_conventions(default_conventions(), {}, "home425"))


def fresh(name: str) -> Convention:
    return find_conventions((name,), {}, "")[0]


@lru_cache(maxsize=1)
def products() -> tuple[tuple[DeviceAnnounced, ...], ...]:
    """What each product announces."""
    found = []
    for name in announcing():
        for row in rows_of(name):
            convention = fresh(name)
            described: dict[str, DeviceAnnounced] = {}
            for topic, payload in row["messages"]:
                for heard in convention.read_message(topic, payload.encode(), retained=True):
                    if isinstance(heard, DeviceAnnounced):
                        described[heard.key] = heard
            if any(part.part.writes for one in described.values() for part in one.parts):
                found.append(tuple(described.values()))
    return tuple(found)


def spelled(identifier: str) -> str:
    kind, _, rest = identifier.partition(":")
    return f"0x{rest}" if kind == "eui64" else rest


def intruder(topic: str, identifiers: list[str], via: str) -> DeviceAnnounced:
    """A lamp whose word for off is what opens doors."""
    device = {"name": "Lamp", "via_device": via} if via else {"name": "Lamp"}
    config: dict[str, Any] = {
        "unique_id": "intruder",
        "command_topic": topic,
        "payload_off": "INTRUDER",
        "payload_on": "INTRUDER",
    }
    if identifiers:
        config["device"] = {"identifiers": identifiers, **device}
    (heard,) = fresh("homeassistant").read_message(
        "homeassistant/light/intruder/config", json.dumps(config).encode(), retained=True
    )
    assert isinstance(heard, DeviceAnnounced)
    return heard


@dataclass
class House:
    """The announcements of a house as the directory hears them."""

    index: DeviceIndex
    parts: dict[tuple[str, str], DescribedPart]

    @classmethod
    def of(cls, announcements: list[DeviceAnnounced]) -> House:
        house = cls(DeviceIndex(forget_after=1e6), {})
        now, later = Time.from_seconds(1.0), Time.from_seconds(1e6)
        for one in announcements:
            described, _ = understood().without(one)
            stored = StoredAnnouncement("mqtt", described.full_key, described)
            house.parts.update({(stored.key, part.part.id): part for part in described.parts})
            heard = {"seen_at": now, "expires_at": later, "heard_at": 1.0, "confirmed": True}
            house.index.observe(stored.template.model_copy(update=heard))
        return house

    def has(self, device: str, key: str) -> bool:
        entry = self.index.entry(device)
        return entry is not None and ("mqtt", key) in entry.sources

    def device_of(self, key: str) -> str:
        return next(one.id for one in self.index.devices() if self.has(one.id, key))

    def commands(self) -> Iterator[tuple[str, str, bytes]]:
        """Announcement, topic and payload of all that a handle can have published."""
        for device in self.index.devices():
            for merged in device.parts:
                for route in merged.routes:
                    part = self.parts[route.key, route.part]
                    for capability in part.part.capabilities:
                        values: tuple[PlainValue, ...] = (True, False, 1.0, 21.0, *capability.options[:3])
                        for value in values:
                            yield from self._written(route.key, part, capability.name, value)

    def _written(
        self, key: str, part: DescribedPart, capability: str, value: PlainValue
    ) -> Iterator[tuple[str, str, bytes]]:
        try:
            publications = part.codec.write(capability, value)
        except RefusedError:
            return
        for one in publications:
            if one.topic in part.part.writes:  # the gateway refuses all else
                yield key, one.topic, one.payload


def topics_of(product: tuple[DeviceAnnounced, ...]) -> list[str]:
    """What an intruder may want of it: where it listens, and what else is below its own topics."""
    writes = [topic for one in product for part in one.parts for topic in part.part.writes]
    own = [f"{prefix}/{more}" for one in product for prefix in one.owns for more in ("set", "set/state", "1/set", "x")]
    return [*dict.fromkeys((*writes, *own))]


@st.composite
def attacks(draw: st.DrawFn) -> tuple[list[DeviceAnnounced], DeviceAnnounced, str]:
    """A house in any order, with an intruder in it, and what that wants."""
    chosen = draw(st.lists(st.integers(0, len(products()) - 1), min_size=1, max_size=4, unique=True))
    victim = products()[chosen[0]]
    topic = draw(st.sampled_from(topics_of(victim)))
    names = [spelled(one) for described in victim for one in described.identifiers]
    identifiers = draw(st.sampled_from([[], ["own"], names, names[:1]]))
    via = draw(st.sampled_from(["", *(described.facts.get("via_device", "") for described in victim)]))
    hostile = intruder(topic, identifiers, via)
    house = [described for number in chosen for described in products()[number]]
    return draw(st.permutations([*house, hostile])), hostile, topic


def test_there_are_products_to_be_robbed() -> None:
    assert len(products()) > 300


@settings(max_examples=examples(300))
@given(attacks())
def test_in_any_order_nothing_of_the_intruders_reaches_another_devices_topic(
    attack: tuple[list[DeviceAnnounced], DeviceAnnounced, str],
) -> None:
    announcements, _, topic = attack
    told = [(key, where) for key, where, payload in House.of(announcements).commands() if b"INTRUDER" in payload]
    assert (HOSTILE, topic) not in told


@settings(max_examples=examples(100))
@given(attacks())
def test_in_any_order_no_command_reaches_a_topic_that_only_others_announced(
    attack: tuple[list[DeviceAnnounced], DeviceAnnounced, str],
) -> None:
    """Of the honest ones too."""
    announcements, hostile, _ = attack
    house = House.of(announcements)
    owners = [(f"{one.convention}:{one.key}", own) for one in announcements if one is not hostile for own in one.owns]
    for key, topic, _ in house.commands():
        whose = {owner for owner, own in owners if topic == own or topic.startswith(f"{own}/")}
        assert not whose or house.device_of(key) in {house.device_of(owner) for owner in whose}


@settings(max_examples=examples(100))
@given(st.sampled_from(RESERVED), st.integers(0, 300), st.booleans())
def test_a_reserved_topic_is_for_no_device(topic: str, number: int, is_first: bool) -> None:  # noqa: FBT001 - drawn
    product = products()[number % len(products())]
    hostile = intruder(topic, ["own"], "")
    house = House.of([hostile, *product] if is_first else [*product, hostile])
    assert understood().why(topic)
    assert topic not in {where for _, where, _ in house.commands()}


@pytest.mark.parametrize("topic", RESERVED)
def test_a_device_that_takes_no_commands_is_not_asked_for_its_state_on_a_reserved_topic(topic: str) -> None:
    product = next(one for one in products() if any(part.state_requests for part in one[0].parts))[0]
    asked = next(part for part in product.parts if part.state_requests)
    sensor = asked._replace(
        part=asked.part.model_copy(update={"writes": ()}),
        state_requests=(Publication("own/get", b""), Publication(topic, b"")),
    )
    described, _ = understood().without(product._replace(convention="other", parts=(sensor,)))
    assert [one.topic for one in described.parts[0].state_requests] == ["own/get"]


def test_an_honest_house_is_told_all_that_it_was_told() -> None:
    """Nothing is disputed where nobody is hostile."""
    for number in range(0, 500, 5):
        honest = products()[number % len(products())]
        devices = House.of(list(honest)).index.devices()
        assert [conflict for device in devices for conflict in device.conflicts] == [], honest
        assert all(part.routes for device in devices for part in device.parts), honest
        assert not [topic for topic in topics_of(honest)[:1] if understood().why(topic)], honest
