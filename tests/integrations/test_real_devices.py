"""Real products, by every convention: what they are, what they say, and what they are told.

``NAME/formats/real_devices.jsonl`` has a product per line; ``real_devices.md`` says where lines come from:

- ``messages``: topic and payload of each announcement;
- ``types``: service types it must have, settings and self-observations aside;
- ``says``: topic, payload, and the values that are known afterwards, by part;
- ``told``: part, capability, value, and what the judge publishes: topic, payload, and where it
  told them QoS and retain.

A part is named by its id, by its service type where ids are the convention's own, or not at all: any part.
"""

import json
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import pytest
from tests.integrations.real_devices import rows_of

from homebot.conventions.convention import Convention
from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.homie.formats import Homie, HomieSettings
from homebot.integrations.shelly.formats import Shelly, ShellySettings
from homebot.integrations.tasmota.formats import TasmotaDiscovery, TasmotaSettings
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings

Row: TypeAlias = dict[str, Any]

CONVENTIONS: Mapping[str, Callable[[], Convention]] = {
    "homeassistant": lambda: HomeAssistantDiscovery(HomeAssistantSettings()),
    "zigbee2mqtt": lambda: Zigbee2Mqtt(Zigbee2MqttSettings()),
    "tasmota": lambda: TasmotaDiscovery(TasmotaSettings()),
    "shelly": lambda: Shelly(ShellySettings()),
    "homie": lambda: Homie(HomieSettings()),
}
MODELS = 500
TOLERANCES = {"color_temperature": 40.0, "level": 0.7, "position": 0.51, "tilt": 0.51, "fan_speed": 0.51}
"""Judges show whole percents and mireds; of other numbers, they show fewer digits."""


def parts_of(convention: Convention, row: Row) -> list[DescribedPart]:
    """The parts of all that the announcements describe; a later one takes the place of an earlier one of its key."""
    described: dict[str, DeviceAnnounced] = {}
    for topic, payload in row["messages"]:
        for heard in convention.read_message(topic, payload.encode(), retained=True):
            if isinstance(heard, DeviceAnnounced):
                described[heard.key] = heard
    return [part for one in described.values() for part in one.parts]


def meant(parts: list[DescribedPart], who: str) -> list[DescribedPart]:
    return [one for one in parts if who in {"", one.part.id, one.part.service_type}]


def same(capability: str, ours: PlainValue, theirs: Any) -> bool:
    if isinstance(theirs, list):
        return isinstance(ours, tuple) and ours == pytest.approx(theirs, abs=2.5)
    if isinstance(theirs, bool | str | None):
        return ours == theirs
    return ours == pytest.approx(theirs, abs=TOLERANCES.get(capability, 0.06), rel=0.006)


def published(part: DescribedPart, capability: str, value: PlainValue) -> tuple[Publication, ...]:
    try:
        return part.codec.write(capability, value)
    except RefusedError:
        return ()


def says_the_same(ours: Publication, theirs: list[Any]) -> bool:
    """Equal as text or as JSON; where no QoS was told, more may be said than the JSON of the judge."""
    topic, payload, *delivery = theirs
    if ours.topic != topic or (delivery and [ours.qos, ours.retain] != delivery):
        return False
    if ours.payload == payload.encode():
        return True
    try:
        said, wanted = json.loads(ours.payload), json.loads(payload)
    except ValueError:
        return False
    if isinstance(wanted, dict) and isinstance(said, dict) and "method" in wanted:
        return said["method"] == wanted["method"] and holds(said["params"], wanted["params"])
    return bool(said == wanted) or (not delivery and holds(said, wanted))


def holds(said: object, wanted: object) -> bool:
    return isinstance(said, dict) and isinstance(wanted, dict) and wanted.items() <= said.items()


def properties(name: str, publications: tuple[Publication, ...]) -> Mapping[str, object]:
    """What Zigbee2MQTT sets on commands to the device *name*: every spelling of one command gives the same."""
    wanted: dict[str, object] = {}
    for one in publications:
        before, _, behind = one.topic.removeprefix(f"zigbee2mqtt/{name}/").rpartition("set")
        endpoint, attribute = before.strip("/"), behind.strip("/")
        try:
            value = json.loads(one.payload)
        except ValueError:
            value = one.payload.decode()
        message = {attribute: value} if attribute else value if isinstance(value, dict) else {"state": value}
        for key, item in message.items():
            spelled = f"{key}_{endpoint}" if endpoint and not key.endswith(f"_{endpoint}") else key
            wanted[spelled] = item.upper() if key.startswith("state") and isinstance(item, str) else item
    return wanted


def obeys(row: Row, ours: tuple[Publication, ...], theirs: Any) -> bool:
    if isinstance(theirs, dict):
        return properties(row["name"], ours) == theirs
    return len(ours) == len(theirs) and all(map(says_the_same, ours, theirs))


def test_hundreds_of_products_are_here() -> None:
    """No product counts twice."""
    assert len({(row["vendor"], row["model"]) for convention in CONVENTIONS for row in rows_of(convention)}) >= MODELS


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_products_are_understood_and_told_as_their_judge_does(convention: str) -> None:
    """What differs is listed, so that one run shows all of it."""
    found = [(row["vendor"], row["model"], differences(convention, row)) for row in rows_of(convention)]
    assert [product for product in found if product[-1]] == []


def differences(convention: str, row: Row) -> list[object]:
    """What homebot understands or publishes in another way than the judge of *row*."""
    parts = parts_of(CONVENTIONS[convention](), row)
    offered = {one.part.service_type for one in parts if not one.part.category}
    differs: list[object] = sorted(set(row["types"]) - offered)
    known: dict[int, dict[str, PlainValue]] = {id(one): {} for one in parts}
    for topic, payload, expected in row["says"]:
        for one in parts:
            known[id(one)].update(one.codec.read(topic, payload.encode(), retained=False))
        for who, values in expected.items():
            for capability, value in values.items():
                heard = [known[id(one)].get(capability) for one in meant(parts, who)]
                if not any(same(capability, ours, value) for ours in heard):
                    differs.append((who, capability, value, heard, payload))
    for who, capability, value, theirs in row["told"]:
        wanted = tuple(value) if isinstance(value, list) else value
        orders = [published(one, capability, wanted) for one in meant(parts, who)]
        if not any(obeys(row, ours, theirs) for ours in orders):
            differs.append((who, capability, value, theirs, orders))
    return differs
