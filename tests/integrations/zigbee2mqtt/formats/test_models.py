"""Real models against Home Assistant with the same devices.

``models.jsonl`` has a device per line, as ``bridge/devices`` of Zigbee2MQTT 2.14.1 lists it (without descriptions):

- ``types``: what Home Assistant core 2025.4.4 takes it for, by Zigbee2MQTT's own discovery messages, in our words
  (left out for two thermostats without modes, for which it assumes those of an air conditioner, and for a garage door,
  which it takes for a switch that is on and off and which moves at both);
- ``says``: messages one after the other, and what Home Assistant then knows, by part and capability (it has no
  class for produced energy, nor for a fault);
- ``told``: part, capability, value and transition, and which properties Home Assistant sets for that.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from tests.conventions.home_assistant_answers import check_commands, check_messages
from tests.integrations.announced_parts import device_in

from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings

Model: TypeAlias = dict[str, Any]

LINES = Path(__file__).with_name("models.jsonl").read_text(encoding="utf-8").splitlines()
MODELS: list[Model] = [json.loads(line) for line in LINES]
MAIN_TYPES = {"light", "switch", "window_covering", "door_lock", "fan", "thermostat", "room_air_conditioner"}


def name(model: Model) -> str:
    return f"{model['entry']['definition']['vendor']}-{model['entry']['definition']['model']}"


def described(model: Model) -> DeviceAnnounced:
    payload = json.dumps([model["entry"]]).encode()
    return device_in(
        Zigbee2Mqtt(Zigbee2MqttSettings()).read_message("zigbee2mqtt/bridge/devices", payload, retained=True)
    )


@pytest.mark.parametrize("model", MODELS, ids=name)
def test_a_device_is_described_read_and_commanded_as_by_home_assistant(model: Model) -> None:
    parts = described(model).parts
    if model["types"]:
        check_types(parts, set(model["types"]))
    topic = f"zigbee2mqtt/{model['entry']['friendly_name']}"
    check_messages({one.part.id: one for one in parts}, [(topic, *said) for said in model["says"]])
    orders = [(*order[:-1], f"{topic}/set", order[-1]) for order in model["told"]]
    check_commands({one.part.id: one for one in described(model).parts}, orders)


def check_types(parts: Sequence[DescribedPart], types: set[str]) -> None:
    found = {one.part.service_type for one in parts if not one.part.category} & MAIN_TYPES
    settings = {one.part.id for one in parts if one.part.service_type == "x_setting"}
    assert found <= types
    missing = types - found
    assert not missing or (missing == {"switch"} and settings)  # a binary that can be set is a setting to us
