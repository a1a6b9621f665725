"""A robot that announces itself by Homie and to Home Assistant, as Valetudo does.

The messages follow Valetudo 2026.02.0 (``backend/lib/mqtt``).
"""

import json
from collections.abc import Iterator, Mapping
from random import Random

import pytest
from tests.integrations.announced_parts import device_in, sighting
from tests.integrations.homie.formats.valetudo import STATUS, VALETUDO, robot

from homebot.conventions.description import DeviceAnnounced
from homebot.devices import Device
from homebot.discovery import DeviceIndex
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings

ROBOT = "valetudo/BigSlowDog"

ENTITIES: Mapping[str, Mapping[str, object]] = {
    "vacuum/vacuum": {
        "name": "Robot",
        "supported_features": ["status", "start", "stop", "pause", "return_home", "fan_speed", "locate"],
        "state_topic": f"{ROBOT}/hass/BigSlowDog_vacuum/state",
        "command_topic": f"{ROBOT}/hass/BigSlowDog_vacuum/command",
        "payload_start": "START",
        "payload_return_to_base": "HOME",
        "payload_locate": "LOCATE",
        "fan_speed_list": ["low", "medium", "high"],
        "set_fan_speed_topic": f"{ROBOT}/FanSpeedControlCapability/preset/set",
    },
    "sensor/battery_level": {
        "name": "Battery level",
        "state_topic": f"{ROBOT}/BatteryStateAttribute/level",
        "unit_of_measurement": "%",
        "device_class": "battery",
        "entity_category": "diagnostic",
    },
    "number/SpeakerVolumeControlCapability": {
        "name": "Speaker volume",
        "state_topic": f"{ROBOT}/SpeakerVolumeControlCapability/value",
        "command_topic": f"{ROBOT}/SpeakerVolumeControlCapability/value/set",
        "min": 0,
        "max": 100,
        "entity_category": "config",
    },
    "binary_sensor/AttachmentStateAttribute_mop": {
        "name": "Mop attachment",
        "state_topic": f"{ROBOT}/AttachmentStateAttribute/mop",
        "payload_on": "true",
        "payload_off": "false",
        "entity_category": "diagnostic",
    },
}


def by_homie() -> DeviceAnnounced:
    return robot(ROBOT, {**VALETUDO, "StatusStateAttribute": STATUS}, "valetudo")


def by_discovery(**device: object) -> Iterator[DeviceAnnounced]:
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    for place, fields in ENTITIES.items():
        component, _, name = place.partition("/")
        config = {
            **fields,
            "unique_id": f"BigSlowDog_{name}",
            "availability_topic": f"{ROBOT}/$state",
            "device": {"identifiers": ["BigSlowDog"], "name": "Rocky", **device},
        }
        topic = f"homeassistant/{component}/BigSlowDog/BigSlowDog_{name}/config"
        heard = convention.read_message(topic, json.dumps(config).encode(), retained=True)
        yield from (one for one in heard if isinstance(one, DeviceAnnounced))


def devices(*announcements: DeviceAnnounced) -> tuple[Device, ...]:
    index = DeviceIndex(forget_after=1000.0)
    for one in announcements:
        index.observe(sighting(one))
    return index.devices()


@pytest.mark.parametrize("seed", range(20))
def test_a_robot_that_announces_itself_twice_is_one_robot_without_conflicts(seed: int) -> None:
    order = [by_homie(), *by_discovery()]
    Random(seed).shuffle(order)  # noqa: S311 - no secret
    (device,) = devices(*order)
    assert device.conflicts == ()
    assert "same id:valetudo/BigSlowDog in " in device.evidence[0]
    ways = {tuple(sorted(way.convention for way in one.routes)): set[str]() for one in device.parts}
    for one in device.parts:
        ways[tuple(sorted(way.convention for way in one.routes))].add(one.part.service_type)
    assert ways == {
        ("homeassistant", "homie"): {"robotic_vacuum_cleaner", "x_battery", "x_setting", "x_binary_sensor"},
        ("homie",): {"x_sensor", "x_setting", "x_binary_sensor"},
    }
    (cleaner,) = [one for one in device.parts if one.part.service_type == "robotic_vacuum_cleaner"]
    assert {one.name for one in cleaner.part.capabilities} == {"vacuum", "fan_mode", "locate"}


def test_another_device_with_its_name_is_another_device() -> None:
    """Its topics alone, or its name alone, do not identify it."""
    own = by_homie()
    assert len(devices(own, *by_discovery(identifiers=["BigSlow"]))) == 2
    assert len(devices(own, *by_discovery(identifiers=["valetudo"]))) == 2
    elsewhere = HomeAssistantDiscovery(HomeAssistantSettings())
    config = {"state_topic": "zones/BigSlowDog/state", "unique_id": "u", "device": {"identifiers": ["BigSlowDog"]}}
    other = device_in(
        elsewhere.read_message("homeassistant/sensor/u/config", json.dumps(config).encode(), retained=True)
    )
    assert len(devices(own, other)) == 2


def test_a_device_that_speaks_partly_elsewhere_is_not_known_by_the_topic() -> None:
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    config = {
        "command_topic": "gate/open",
        "state_topic": f"{ROBOT}/KeyLockCapability/enabled",
        "unique_id": "u",
        "device": {"identifiers": ["BigSlowDog"]},
    }
    other = device_in(
        convention.read_message("homeassistant/switch/u/config", json.dumps(config).encode(), retained=True)
    )
    assert len(devices(by_homie(), other)) == 2


def test_a_device_that_moves_to_other_topics_is_a_device_of_its_own_again() -> None:
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    index = DeviceIndex(forget_after=1000.0)
    index.observe(sighting(by_homie()))
    counts = []
    for base in (ROBOT, "elsewhere", ROBOT):
        config = {"state_topic": f"{base}/x", "unique_id": "u", "device": {"identifiers": ["BigSlowDog"]}}
        other = device_in(
            convention.read_message("homeassistant/sensor/u/config", json.dumps(config).encode(), retained=True)
        )
        index.observe(sighting(other))
        counts.append(len(index))
    assert counts == [1, 2, 1]
