"""Parts against Home Assistant with the same messages.

``controls.jsonl``, of what is mostly commanded, and ``parts.jsonl``, of the rest, have a config of a real publisher per
line, with the answers of Home Assistant core 2025.4.4, whose MQTT integration was run on these messages, in the words
of our vocabulary:

- ``service_type``: where its class has a Matter device type;
- ``says``: topic, payload, and what is known afterwards;
- ``told``: after all that, capability, value, transition in seconds if it is no sensor's, and what is published (topic,
  payload, QoS, retain), or null where Home Assistant publishes nothing;
- ``refused``: Home Assistant does not take the config.

In some things we differ on purpose: a text that is JSON null is unknown and not the text ``None``; an unknown preset
is unknown and not ``none``; a number is reported in the unit of the vocabulary, not in that of a user; a cover that
stopped is ``stopped``; and a lock that jammed before is not still jammed when its state is unknown.
"""

import json
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from tests.integrations.announced_parts import homeassistant_parts

from homebot.conventions.description import DescribedPart, Publication
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.mqtt.topics import topic_matches

Answer: TypeAlias = dict[str, Any]

ANSWERS: list[Answer] = [
    {"id": f"{name}-{number}", "tolerance": tolerance, **json.loads(line)}
    for name, tolerance in (("parts", 0.06), ("controls", 0.5))  # it shows tenths of degrees, and whole percents
    for number, line in enumerate(Path(__file__).with_name(f"{name}.jsonl").read_text().splitlines(), 1)
]
KINDS: dict[str, type] = {"bool": bool, "number": float, "text": str, "numbers": tuple}


def name(answer: Answer) -> str:
    return f"{answer['component']}-{answer['id']}"


def described(answer: Answer) -> DescribedPart:
    return homeassistant_parts(answer["component"], answer["config"])[0]


def same(ours: PlainValue, theirs: PlainValue | list[float], tolerance: float) -> bool:
    if isinstance(theirs, bool | str | None):
        return ours == theirs
    return ours == pytest.approx(tuple(theirs) if isinstance(theirs, list) else theirs, abs=tolerance)


@pytest.mark.parametrize("answer", [one for one in ANSWERS if "refused" not in one], ids=name)
def test_a_part_is_described_read_and_commanded_as_by_home_assistant(answer: Answer) -> None:
    described_part = described(answer)
    part = described_part.part
    assert part.service_type == answer.get("service_type", part.service_type)
    assert part.service_type in DEVICE_TYPES
    assert part.capabilities
    assert {one.name for one in part.capabilities} <= CAPABILITIES.keys()
    check_messages(described_part, answer)
    check_commands(described_part, answer)


def check_messages(part: DescribedPart, answer: Answer) -> None:
    known: dict[str, PlainValue] = {}
    for topic, payload, expected in answer["says"]:
        found = part.codec.read(topic, payload.encode(), retained=False)
        known.update(found)
        assert any(topic_matches(spoken, topic) for spoken in part.codec.topics())
        assert all(value is None or type(value) is KINDS[CAPABILITIES[key].kind] for key, value in found.items()), found
        assert all(same(known.get(key), value, answer["tolerance"]) for key, value in expected.items()), (
            known,
            expected,
        )


def check_commands(part: DescribedPart, answer: Answer) -> None:
    """Those after the messages."""
    for capability, value, *transition, published in answer["told"]:
        wanted = tuple(value) if isinstance(value, list) else value
        seconds = transition[0] if transition else 0.0
        if published is None:
            with pytest.raises(RefusedError):
                part.codec.write(capability, wanted, transition=seconds)
            continue
        expected = tuple(Publication(topic, text.encode(), qos, retain) for topic, text, qos, retain in published)
        assert part.codec.write(capability, wanted, transition=seconds) == expected


@pytest.mark.parametrize("answer", [one for one in ANSWERS if "refused" in one], ids=name)
def test_a_config_that_home_assistant_refuses_is_refused(answer: Answer) -> None:
    with pytest.raises(WireError, match=answer["component"]):
        described(answer)
