"""Real models, announced by ``bridge/devices`` and by Home Assistant discovery at once, as in every house with both.

``both_announcements.jsonl`` has a model per line; ``real_devices.md`` says how the messages were made:

- ``entry``: the model in ``bridge/devices``;
- ``device``: the device block of each of its discovery messages;
- ``discovery``: the rest of each, by component and object id.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from pathlib import Path
from random import Random
from typing import Any, TypeAlias

import pytest
from tests.discovery.announcements import contents
from tests.integrations.announced_parts import sighting
from tests.sizes import size

from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication
from homebot.devices import Device, DevicePart, Sighting
from homebot.devices.always_ask import always_asks
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.discovery import DeviceIndex
from homebot.errors import RefusedError
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings

pytestmark = pytest.mark.slow

Row: TypeAlias = dict[str, Any]
Place: TypeAlias = tuple[str, str]
"""Key of an announcement, and the id of the part there."""

FIXTURE = Path(__file__).with_name("both_announcements.jsonl")
ROWS: list[Row] = [json.loads(line) for line in FIXTURE.read_text(encoding="utf-8").splitlines()]
ORDERS = size(3, 20)
LOADS = {"switch", "plug", "light", "fan", "siren", "window_covering", "door_lock", "valve", "water_valve"}
DUAL = {"on_off", "push"}
"""Capabilities of one property in both: Zigbee2MQTT announces a button for some that are on and off."""


def name(row: Row) -> str:
    return f"{row['entry']['definition']['vendor']}-{row['entry']['definition']['model']}"


@dataclass(frozen=True)
class Model:
    """One model as both conventions describe it."""

    topic: str
    sightings: tuple[Sighting, ...]
    parts: Mapping[Place, DescribedPart]
    properties: Mapping[Place, frozenset[str]]

    @cached_property
    def whole(self) -> Device:
        """The device of all sightings."""
        return self.device(self.sightings)

    @cached_property
    def orders(self) -> dict[Place, dict[tuple[str, PlainValue], dict[str, object]]]:
        """The commands of each part, as :func:`commands` finds them."""
        return {place: commands(self.topic, part) for place, part in self.parts.items()}

    def device(self, order: Sequence[Sighting]) -> Device:
        """The only device that these sightings are, one after the other."""
        index = DeviceIndex(forget_after=1000.0)
        for one in order:
            index.observe(one)
        (device,) = index.devices()
        assert device.conflicts == ()
        return device

    def used(self, part: DevicePart) -> frozenset[str]:
        """The properties that are used by one of the ways to *part*."""
        return frozenset[str]().union(*(self.properties[way.key, way.part] for way in part.routes))


def described(row: Row) -> Iterator[DeviceAnnounced]:
    own = Zigbee2Mqtt(Zigbee2MqttSettings())
    yield from found(own.read_message("zigbee2mqtt/bridge/devices", json.dumps([row["entry"]]).encode(), retained=True))
    foreign = HomeAssistantDiscovery(HomeAssistantSettings())
    for place, config in row["discovery"].items():
        payload = json.dumps({**config, "device": row["device"]}).encode()
        yield from found(foreign.read_message(f"homeassistant/{place}/config", payload, retained=True))


def found(heard: Sequence[object]) -> list[DeviceAnnounced]:
    return [one for one in heard if isinstance(one, DeviceAnnounced)]


@pytest.fixture(scope="module", params=ROWS, ids=name)
def model(request: pytest.FixtureRequest) -> Model:
    row: Row = request.param
    announcements = list(described(row))
    parts = {(f"{one.convention}:{one.key}", part.part.id): part for one in announcements for part in one.parts}
    topic = f"zigbee2mqtt/{row['entry']['friendly_name']}"
    probes = list(probes_of(row["entry"]["definition"]["exposes"]))
    return Model(
        topic,
        tuple(map(sighting, announcements)),
        parts,
        {place: used_by(topic, part, probes) for place, part in parts.items()},
    )


def probes_of(exposes: list[Row]) -> Iterator[tuple[str, object]]:
    """For each property some messages that have nothing else."""
    for one in exposes:
        if one["type"] != "composite" and "features" in one:
            yield from probes_of(one["features"])
        elif one["type"] == "binary":
            yield from ((one["property"], one.get(key)) for key in ("value_on", "value_off"))
        elif one["type"] == "numeric":
            yield from ((one["property"], value) for value in (one.get("value_min", 1), one.get("value_max", 5), 20))
        elif one["type"] == "enum":
            yield from ((one["property"], value) for value in one["values"][:4])
        elif one["type"] == "composite":
            yield one["property"], {"x": 0.3, "y": 0.3, "hue": 120, "saturation": 50, "h": 120, "s": 50}
        else:
            yield one["property"], "hello"
    yield "update", {"state": "available", "installed_version": 1, "latest_version": 2}


def used_by(topic: str, part: DescribedPart, probes: list[tuple[str, object]]) -> frozenset[str]:
    """The properties that a part tells of or is told."""
    mode = {"color_mode": "xy"}
    nothing = part.codec.read(topic, json.dumps(mode).encode(), retained=False)
    read = {
        key
        for key, value in probes
        if any(
            told not in (None, "") and told != nothing.get(capability)
            for capability, told in part.codec.read(
                topic, json.dumps({key: value, **mode}).encode(), retained=False
            ).items()
        )
    }
    return frozenset(read).union(*commands(topic, part).values())


def commands(topic: str, part: DescribedPart) -> dict[tuple[str, PlainValue], dict[str, object]]:
    """Return the properties that Zigbee2MQTT sets, with their values, by capability and value."""
    orders = {}
    for capability in part.part.capabilities:
        for value in values_of(capability) if capability.settable else ():
            try:
                publications = part.codec.write(capability.name, value)
            except RefusedError:
                continue
            if publications:
                orders[capability.name, value] = properties(topic, publications)
    return orders


def values_of(capability: Capability) -> Sequence[PlainValue]:
    if capability.options:
        return capability.options
    if capability.bounds:
        return (*capability.bounds, sum(capability.bounds) / 2)
    return VALUES.get(capability.name, (True, False, 20.0, 50.0, "hello"))


VALUES: Mapping[str, Sequence[PlainValue]] = {
    "color": ((120.0, 50.0),),
    "color_temperature": (3000.0,),
    "lock": ("locked", "unlocked"),
    "movement": ("open", "closed", "stopped"),
}


def properties(topic: str, publications: tuple[Publication, ...]) -> dict[str, object]:
    """Every spelling of one command gives the same: ``state_l1`` is ``state`` on ``…/l1/set``, and 1 is ``"1"``."""
    told: dict[str, object] = {}
    for one in publications:
        before, _, behind = f"{one.topic}/".removeprefix(topic).partition("/set/")
        endpoint, attribute = before.strip("/"), behind.strip("/")
        try:
            value = json.loads(one.payload)
        except ValueError:
            value = one.payload.decode()
        message = {attribute: value} if attribute else value if isinstance(value, dict) else {"state": value}
        for key, item in message.items():
            is_spelled = not endpoint or key == endpoint or key.endswith(f"_{endpoint}")
            told[key if is_spelled else f"{key}_{endpoint}"] = spelled(item)
    return told


def spelled(value: object) -> object:
    if isinstance(value, dict):
        return {key: spelled(item) for key, item in value.items() if key not in ("hue", "saturation", "x", "y")}
    if value is None:
        return "null"
    return f"{value:g}" if isinstance(value, int | float) and not isinstance(value, bool) else value


def test_the_models_of_all_other_fixtures_are_here() -> None:
    assert len(ROWS) >= 190


def every_order_of_arrival_has_one_result(model: Model) -> None:
    wanted = contents(model.whole)
    order, dice = list(model.sightings), Random(1)  # noqa: S311 - the same orders in every run
    for _ in range(ORDERS):
        dice.shuffle(order)
        assert contents(model.device(order)) == wanted


def no_part_is_made_of_two_that_use_nothing_in_common(model: Model) -> None:
    for one in model.whole.parts:
        for first, second in combinations(one.routes, 2):
            mine, theirs = model.properties[first.key, first.part], model.properties[second.key, second.part]
            assert (mine & theirs) or not (mine | theirs), (first, second)


def a_part_can_do_what_one_of_its_sides_can_and_nothing_else(model: Model) -> None:
    for one in model.whole.parts:
        sides = [model.parts[way.key, way.part].part.capabilities for way in one.routes]
        for capability in one.part.capabilities:
            of_sides = [other for side in sides for other in side if other.name == capability.name]
            assert capability.readable == any(other.readable for other in of_sides)
            assert capability.settable == any(other.settable for other in of_sides)
            assert set(capability.options) <= {option for other in of_sides for option in other.options}


def a_command_means_the_same_by_every_way(model: Model) -> None:
    for one in model.whole.parts:
        for first, second in combinations(one.routes, 2):
            mine, theirs = (model.orders[way.key, way.part] for way in (first, second))
            for order in mine.keys() & theirs.keys():
                assert mine[order] == theirs[order], (order, first, second)


def every_setting_is_there_once_and_none_is_found_as_a_load(model: Model) -> None:
    """A lamp may have its effects as well."""
    parts = model.whole.parts
    used = {one.id: model.used(one) for one in parts}
    settings = [one for one in parts if one.part.category == "config" and one.part.service_type == "x_setting"]
    for one, other in combinations(parts, 2):
        can = {capability.name for part in (one, other) for capability in part.part.capabilities}
        if used[one.id] and used[one.id] == used[other.id] and (one in settings or other in settings):
            assert can >= DUAL, (one.id, other.id)
    of_settings = frozenset[str]().union(*(used[one.id] for one in settings))
    loads = [one for one in parts if one.part.service_type in LOADS and not one.part.category]
    assert not [one.id for one in loads if used[one.id] and used[one.id] <= of_settings]


@pytest.mark.no_cover
def test_a_model_that_is_announced_twice_is_one_device_without_contradiction(model: Model) -> None:
    every_order_of_arrival_has_one_result(model)
    no_part_is_made_of_two_that_use_nothing_in_common(model)
    a_part_can_do_what_one_of_its_sides_can_and_nothing_else(model)
    a_command_means_the_same_by_every_way(model)
    every_setting_is_there_once_and_none_is_found_as_a_load(model)


def test_a_garage_door_opener_asks_whichever_announcement_comes_first() -> None:
    """Home Assistant has a switch, homebot the movement of the door; only one of them may know the model."""
    trigger = {"type": "binary", "name": "trigger", "property": "trigger", "access": 3}
    contact = {"type": "binary", "name": "garage_door_contact", "property": "garage_door_contact", "access": 1}
    definition = {"vendor": "Tuya", "model": "GDO", "description": "Garage door opener", "exposes": []}
    exposes = [{**trigger, "value_on": True, "value_off": False}, {**contact, "value_on": False, "value_off": True}]
    relay = {
        "name": "Trigger",
        "command_topic": "zigbee2mqtt/dev/set/trigger",
        "state_topic": "zigbee2mqtt/dev",
        "value_template": "{{ value_json.trigger }}",
        "unique_id": "0x00158d00000000ff_switch_trigger_zigbee2mqtt",
    }
    entry = {"ieee_address": "0x00158d00000000ff", "type": "Router", "friendly_name": "dev"}
    row = {
        "entry": {**entry, "definition": {**definition, "exposes": exposes}},
        "device": {"identifiers": ["zigbee2mqtt_0x00158d00000000ff"], "name": "dev", "model": "Garage door opener"},
        "discovery": {"switch/0x00158d00000000ff/switch_trigger": relay},
    }
    own, foreign = map(sighting, described(row))
    for order in ([own], [foreign], [own, foreign], [foreign, own]):
        index = DeviceIndex(forget_after=1000.0)
        for one in order:
            index.observe(one)
        (device,) = index.devices()
        assert all(always_asks(device, part) for part in device.parts)
