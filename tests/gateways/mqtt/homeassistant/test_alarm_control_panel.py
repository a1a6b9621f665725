from collections.abc import Mapping

import pytest

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.mqtt.description import DescribedPart
from homebot.gateways.mqtt.homeassistant.alarm_control_panel import build_alarm_control_panel
from homebot.gateways.mqtt.homeassistant.config import Config

RING = {"command_topic": "ring/alarm/command", "state_topic": "ring/alarm/state"}
OWN = {
    **RING,
    "command_template": '{"action": "{{ action }}", "code": "{{ code }}"}',
    "payload_arm_away": "LEAVE",
    "value_template": "{{ value_json.state }}",
    "supported_features": ["arm_away"],
}
CODED = {**RING, "code": "1234", "code_arm_required": False}


def alarm(fields: Mapping[str, object]) -> DescribedPart:
    return build_alarm_control_panel(Config("alarm_control_panel", "node_1", fields))


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (b"disarmed", {"alarm": "disarmed"}),
        (b"armed_night", {"alarm": "armed_night"}),
        (b"triggered", {"alarm": "triggered"}),
        (b"pending", {"alarm": "pending"}),
        (b"None", {"alarm": None}),
        (b"ARMED_AWAY", {}),
        (b"", {}),
    ],
)
def test_its_state_is_one_of_the_known(said: bytes, expected: Mapping[str, PlainValue]) -> None:
    assert alarm(RING).codec.read("ring/alarm/state", said, retained=True) == expected


@pytest.mark.parametrize(
    ("fields", "word", "payload"),
    [
        (RING, "armed_home", b"ARM_HOME"),
        (RING, "armed_custom_bypass", b"ARM_CUSTOM_BYPASS"),
        (RING, "disarmed", b"DISARM"),
        (RING, "triggered", b"TRIGGER"),
        (OWN, "armed_away", b'{"action": "LEAVE", "code": "None"}'),
        (CODED, "armed_away", b"ARM_AWAY"),
    ],
)
def test_it_is_told_as_home_assistant_does(fields: Mapping[str, object], word: str, payload: bytes) -> None:
    assert [one.payload for one in alarm(fields).codec.write("alarm", word)] == [payload]


@pytest.mark.parametrize(
    ("fields", "word", "why"),
    [
        (CODED, "disarmed", "code"),
        (CODED, "triggered", "code"),
        (OWN, "armed_home", "disarmed, armed_away"),
        (RING, "pending", "it takes"),
    ],
)
def test_what_it_cannot_be_told_is_refused_with_the_reason(fields: Mapping[str, object], word: str, why: str) -> None:
    with pytest.raises(RefusedError, match=why):
        alarm(fields).codec.write("alarm", word)


def test_its_code_is_in_no_description_and_no_refusal() -> None:
    part = alarm(CODED)
    with pytest.raises(RefusedError) as refused:
        part.codec.write("alarm", "disarmed")
    assert "1234" not in f"{part.part} {refused.value}"


@pytest.mark.parametrize("missing", ["command_topic", "state_topic"])
def test_an_alarm_that_misses_a_topic_is_refused(missing: str) -> None:
    with pytest.raises(WireError, match=missing):
        alarm({key: value for key, value in RING.items() if key != missing})
