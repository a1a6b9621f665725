"""Real products against what Home Assistant makes of the same devices.

``devices.jsonl`` has a device per line, as the firmware announces it, with the answers of Home Assistant core 2025.4.4
and hatasmota 0.10.0, which were run on these messages, in the words of our vocabulary:

- ``types``: what Home Assistant takes it for;
- ``says``: topic, payload, and what is then known, by part and capability;
- ``told``: after the messages ``before``: part, capability, value, transition, and what is published.
"""

import json
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from tests.conventions.home_assistant_answers import check_commands, check_messages
from tests.integrations.announced_parts import device_in

from homebot.conventions.description import DeviceAnnounced
from homebot.integrations.tasmota.formats import TasmotaDiscovery, TasmotaSettings

Device: TypeAlias = dict[str, Any]

LINES = Path(__file__).with_name("devices.jsonl").read_text(encoding="utf-8").splitlines()
DEVICES: list[Device] = [json.loads(line) for line in LINES]
CONFIG = "tasmota/discovery/2462AB000011/config"
SENSORS = "tasmota/discovery/2462AB000011/sensors"
UNTOLD_BY_HOME_ASSISTANT = {"generic_switch"}


def name(device: Device) -> str:
    return str(device["config"]["md"])


def described(device: Device) -> DeviceAnnounced:
    convention = TasmotaDiscovery(TasmotaSettings())
    topic = f"tasmota/discovery/{device['config']['mac']}"
    convention.read_message(f"{topic}/config", json.dumps(device["config"]).encode(), retained=True)
    convention.read_message(f"{topic}/sensors", json.dumps(device["sensors"]).encode(), retained=True)
    return device_in(convention.read_message(f"{topic}/config", json.dumps(device["config"]).encode(), retained=True))


@pytest.mark.parametrize("device", DEVICES, ids=name)
def test_a_device_is_described_read_and_commanded_as_by_home_assistant(device: Device) -> None:
    parts = described(device).parts
    found = {one.part.service_type for one in parts if not one.part.category}
    found = {one for one in found if not one.startswith("x_")} - UNTOLD_BY_HOME_ASSISTANT
    relays_of_fan = {"switch"} if device["config"]["if"] and device["config"]["rl"][1:] else set()
    assert found | relays_of_fan == set(device["types"])
    check_messages({one.part.id: one for one in parts}, device["says"])
    fresh = {one.part.id: one for one in described(device).parts}
    check_messages(fresh, [(topic, payload, {}) for topic, payload in device["before"]])
    check_commands(fresh, device["told"])


def test_names_are_cut_to_a_line() -> None:
    fields = {**DEVICES[0]["config"], "mac": "2462AB000011", "dn": "<b>\x1b[31m" + "n" * 200}
    found = device_in(
        TasmotaDiscovery(TasmotaSettings()).read_message(CONFIG, json.dumps(fields).encode(), retained=True)
    )
    assert (found.name[:8], len(found.name)) == ("<b> [31m", 120)
