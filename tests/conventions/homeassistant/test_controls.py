"""Lamps, switches, covers, valves, locks, fans and sirens against Home Assistant with the same messages.

``controls.jsonl`` has a config per line, with the answers of Home Assistant core 2025.4.4, whose MQTT integration was
run on these messages, in the words of our vocabulary:

- ``says``: topic, payload, and what is known afterwards;
- ``told``: after all that, capability, value, transition in seconds, and what is published (topic, payload, QoS,
  retain), or null where Home Assistant publishes nothing;
- ``refused``: Home Assistant does not take the config.

In two things we differ on purpose: a cover that stopped is ``stopped``, and a lock that jammed before is not still
jammed when its state is unknown.
"""

import json
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication
from homebot.conventions.homeassistant import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

Answer: TypeAlias = dict[str, Any]

LINES = Path(__file__).with_name("controls.jsonl").read_text().splitlines()
ANSWERS: list[Answer] = [json.loads(line) for line in LINES]
TAKEN = [one for one in ANSWERS if "refused" not in one]
REFUSED = [one for one in ANSWERS if "refused" in one]


def name(answer: Answer) -> str:
    return f"{answer['component']}-{ANSWERS.index(answer) + 1}"


def described(answer: Answer) -> DescribedPart:
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    topic = f"homeassistant/{answer['component']}/device/config"
    (device,) = convention.read_message(topic, json.dumps(answer["config"]).encode(), retained=True)
    assert isinstance(device, DeviceAnnounced)
    return device.parts[0]


def same(ours: PlainValue, theirs: PlainValue | list[float]) -> bool:
    """Home Assistant shows whole percents and rounded hues."""
    if isinstance(ours, tuple) and isinstance(theirs, list):
        return ours == pytest.approx(theirs, abs=0.5)
    return ours == (theirs if isinstance(theirs, bool | str | None) else pytest.approx(theirs, abs=0.5))


@pytest.mark.parametrize("answer", TAKEN, ids=name)
def test_a_part_has_the_type_of_home_assistant(answer: Answer) -> None:
    assert described(answer).part.service_type == answer["service_type"]


@pytest.mark.parametrize("answer", [one for one in TAKEN if one["says"]], ids=name)
def test_messages_are_read_as_by_home_assistant(answer: Answer) -> None:
    part = described(answer)
    readable = {one.name for one in part.part.capabilities if one.readable}
    known: dict[str, PlainValue] = {}
    for topic, payload, expected in answer["says"]:
        known.update(part.codec.read(topic, payload.encode(), retained=False))
        told = {key: value for key, value in expected.items() if key in readable}
        assert all(same(known.get(key), value) for key, value in told.items()), (payload, known, told)


@pytest.mark.parametrize("answer", TAKEN, ids=name)
def test_commands_are_those_of_home_assistant(answer: Answer) -> None:
    codec = described(answer).codec
    for topic, payload, _ in answer["says"]:
        codec.read(topic, payload.encode(), retained=False)
    for capability, value, transition, published in answer["told"]:
        wanted = tuple(value) if isinstance(value, list) else value
        if published is None:
            with pytest.raises(RefusedError):
                codec.write(capability, wanted, transition=transition)
            continue
        expected = tuple(Publication(topic, text.encode(), qos, retain) for topic, text, qos, retain in published)
        assert codec.write(capability, wanted, transition=transition) == expected


@pytest.mark.parametrize("answer", REFUSED, ids=name)
def test_a_config_that_home_assistant_refuses_is_refused(answer: Answer) -> None:
    with pytest.raises(WireError, match=answer["component"]):
        described(answer)
