"""Attacks by a list of devices or a state are refused or bounded; the fuzzer damages real lists."""

import json
from pathlib import Path
from typing import Any

import pytest
from tests.integrations.announced_parts import announced

from homebot.conventions.description import DeviceAnnounced
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings

pytestmark = pytest.mark.slow

MODELS = Path(__file__).with_name("models.jsonl").read_text(encoding="utf-8")
ENTRY: dict[str, Any] = json.loads(MODELS.splitlines()[0])["entry"]


def found(entry: dict[str, Any]) -> DeviceAnnounced:
    convention = Zigbee2Mqtt(Zigbee2MqttSettings())
    (device,) = announced(convention, ("zigbee2mqtt/bridge/devices", [entry]))
    return device


def test_a_device_with_ten_thousand_exposes_has_a_bounded_number_of_parts() -> None:
    many = [{"type": "numeric", "name": f"n{n}", "property": f"n{n}", "access": 1} for n in range(10_000)]
    lamps = [{"type": "light", "endpoint": f"l{n}", "features": many} for n in range(3)]
    entry = {**ENTRY, "definition": {"exposes": [*lamps, *many]}}
    assert len(found(entry).parts) == 500


def test_names_are_cut_to_a_line() -> None:
    device = found({**ENTRY, "friendly_name": "<b>\x1b[31m" + "n" * 400})
    assert (device.name[:8], len(device.name)) == ("<b> [31m", 120)


def test_a_long_state_is_not_looked_at() -> None:
    part = found(ENTRY).parts[0]
    assert part.codec.read(part.codec.topics()[0], b'{"state":"ON"}' + b" " * 300_000, retained=False) == {}


@pytest.mark.parametrize("name", [["x"], {}, 1])
def test_an_endpoint_whose_name_is_no_text_has_none(name: object) -> None:
    unnamed, other = (found({**ENTRY, "endpoints": {"1": fields}}).parts for fields in ({}, {"name": name}))
    assert [one.part for one in other] == [one.part for one in unnamed]
