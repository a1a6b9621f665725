"""Sensors, climate, settings and the rest against Home Assistant with the same messages.

``parts.jsonl`` has a config of a real publisher per line, with the answers of Home Assistant core 2025.4.4, whose MQTT
integration was run on these messages, in the words of our vocabulary:

- ``service_type``: where its class has a Matter device type;
- ``says``: topic, payload, and what is known afterwards;
- ``told``: capability, value, and what is published (topic, payload, QoS, retain).

In three things we differ on purpose: a text that is JSON null is unknown and not the text ``None``; an unknown preset
is unknown and not ``none``; and a number is reported in the unit of the vocabulary, not in that of a user.
"""

import json
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication
from homebot.conventions.homeassistant import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.value import PlainValue
from homebot.mqtt.topics import topic_matches

Answer: TypeAlias = dict[str, Any]

LINES = Path(__file__).with_name("parts.jsonl").read_text().splitlines()
ANSWERS: list[Answer] = [json.loads(line) for line in LINES]


def name(answer: Answer) -> str:
    return f"{answer['component']}-{ANSWERS.index(answer) + 1}"


def described(answer: Answer) -> DescribedPart:
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    topic = f"homeassistant/{answer['component']}/device/config"
    (device,) = convention.read_message(topic, json.dumps(answer["config"]).encode(), retained=True)
    assert isinstance(device, DeviceAnnounced)
    return device.parts[0]


def same(ours: PlainValue, theirs: PlainValue) -> bool:
    """Home Assistant shows a tenth of a degree."""
    if isinstance(theirs, float | int) and not isinstance(theirs, bool):
        return ours == pytest.approx(theirs, abs=0.06)
    return ours == theirs


@pytest.mark.parametrize("answer", [one for one in ANSWERS if "service_type" in one], ids=name)
def test_a_part_has_the_type_of_home_assistant(answer: Answer) -> None:
    assert described(answer).part.service_type == answer["service_type"]


@pytest.mark.parametrize("answer", ANSWERS, ids=name)
def test_a_part_is_described_in_words_of_the_vocabulary(answer: Answer) -> None:
    part = described(answer).part
    assert part.service_type in DEVICE_TYPES
    assert part.capabilities
    assert {one.name for one in part.capabilities} <= CAPABILITIES.keys()


@pytest.mark.parametrize("answer", [one for one in ANSWERS if one["says"]], ids=name)
def test_messages_are_read_as_by_home_assistant(answer: Answer) -> None:
    codec = described(answer).codec
    known: dict[str, PlainValue] = {}
    for topic, payload, expected in answer["says"]:
        assert any(topic_matches(spoken, topic) for spoken in codec.topics())
        known.update(codec.read(topic, payload.encode(), retained=False))
        assert all(same(known.get(key), value) for key, value in expected.items()), (payload, known, expected)


@pytest.mark.parametrize("answer", [one for one in ANSWERS if one["says"]], ids=name)
def test_values_are_of_the_kind_in_the_vocabulary(answer: Answer) -> None:
    codec = described(answer).codec
    kinds = {"bool": bool, "number": float, "text": str}
    for topic, payload, _ in answer["says"]:
        for capability, value in codec.read(topic, payload.encode(), retained=False).items():
            assert value is None or type(value) is kinds[CAPABILITIES[capability].kind], (capability, value)


@pytest.mark.parametrize("answer", [one for one in ANSWERS if one["told"]], ids=name)
def test_commands_are_those_of_home_assistant(answer: Answer) -> None:
    codec = described(answer).codec
    for capability, value, published in answer["told"]:
        expected = tuple(Publication(topic, text.encode(), qos, retain) for topic, text, qos, retain in published)
        assert codec.write(capability, value) == expected
