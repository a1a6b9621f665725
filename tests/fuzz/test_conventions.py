"""Damaged announcements and messages of each convention of MQTT: refused in our words, or understood."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.fuzz.conftest import Fuzz, fuzz_convention, rows_of

from homebot.conventions.convention import Convention
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.homie.formats import Homie, HomieSettings
from homebot.integrations.shelly.formats import Shelly, ShellySettings
from homebot.integrations.tasmota.formats import TasmotaDiscovery, TasmotaSettings
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings

CONVENTIONS: dict[str, Callable[[], Convention]] = {
    "homeassistant": lambda: HomeAssistantDiscovery(HomeAssistantSettings()),
    "homie": lambda: Homie(HomieSettings()),
    "shelly": lambda: Shelly(ShellySettings()),
    "tasmota": lambda: TasmotaDiscovery(TasmotaSettings()),
    "zigbee2mqtt": lambda: Zigbee2Mqtt(Zigbee2MqttSettings()),
}


COMPONENTS = Path(__file__).parents[1] / "integrations" / "homeassistant" / "formats" / "components.jsonl"


def components() -> list[dict[str, Any]]:
    """Every component of Home Assistant's configs, beside those of real devices."""
    lines = [json.loads(line) for line in COMPONENTS.read_text().splitlines()]
    steps = [
        [step["read"] for one in line.get("tests", {}).values() for step in one if "read" in step] for line in lines
    ]
    return [
        {"messages": [[f"homeassistant/{line['component']}/x/config", json.dumps(line["config"])]], "says": says}
        for line, says in zip(lines, steps, strict=True)
    ]


@pytest.mark.parametrize("name", CONVENTIONS)
def test_damaged_devices_are_refused_or_read(fuzz: Fuzz, name: str) -> None:
    fuzz_convention(fuzz, name, CONVENTIONS[name], [*rows_of(name), *(components() if name == "homeassistant" else ())])
