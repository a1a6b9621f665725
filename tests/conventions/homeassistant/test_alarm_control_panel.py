from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart, TakesCode
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.locks import build_alarm_control_panel
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError, WrongCodeError

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
    return build_alarm_control_panel(DiscoveryConfig("alarm_control_panel", "node_1", fields))


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


def told(fields: Mapping[str, object], word: str, code: str) -> list[bytes]:
    codec = alarm(fields).codec
    assert isinstance(codec, TakesCode)
    return [one.payload for one in codec.write_with_code("alarm", word, code)]


SENT = {**RING, "command_template": '{"action": "{{ action }}", "code": "{{ code }}"}'}


@pytest.mark.parametrize(
    ("fields", "word", "code", "payload"),
    [
        (CODED, "disarmed", "1234", b"DISARM"),
        (CODED, "armed_away", "", b"ARM_AWAY"),
        (CODED, "armed_away", "77", b"ARM_AWAY"),
        ({**SENT, "code": "1234"}, "disarmed", "1234", b'{"action": "DISARM", "code": "1234"}'),
        ({**SENT, "code": "REMOTE_CODE"}, "armed_home", "77", b'{"action": "ARM_HOME", "code": "77"}'),
        ({**SENT, "code": "REMOTE_CODE_TEXT"}, "triggered", "ab", b'{"action": "TRIGGER", "code": "ab"}'),
        (SENT, "disarmed", "5", b'{"action": "DISARM", "code": "5"}'),
        ({**SENT, "code": "1", "code_disarm_required": False}, "disarmed", "", b'{"action": "DISARM", "code": "None"}'),
        (
            {**SENT, "code": "1", "code_trigger_required": False},
            "triggered",
            "9",
            b'{"action": "TRIGGER", "code": "9"}',
        ),
    ],
)
def test_a_code_is_taken_as_home_assistant_does(
    fields: Mapping[str, object], word: str, code: str, payload: bytes
) -> None:
    assert told(fields, word, code) == [payload]


@pytest.mark.parametrize(
    ("fields", "word", "code"),
    [
        (CODED, "disarmed", ""),
        (CODED, "disarmed", "4321"),
        (CODED, "triggered", "12345"),
        ({**RING, "code": "REMOTE_CODE"}, "disarmed", ""),
        ({**RING, "code": "REMOTE_CODE_TEXT"}, "armed_home", ""),
        ({**RING, "code": "1"}, "armed_night", "2"),
        ({**RING, "code": "\u00e4"}, "armed_night", "\u00fc"),
    ],
)
def test_a_wrong_code_is_refused_and_shown_nowhere(fields: Mapping[str, object], word: str, code: str) -> None:
    with pytest.raises(WrongCodeError, match=r"(it needs a code|the code is wrong)$") as refused:
        told(fields, word, code)
    assert not code or code not in str(refused.value)


def test_a_template_that_fails_with_a_code_does_not_show_it() -> None:
    fields = {**RING, "command_template": "{{ code + 1 }}"}
    with pytest.raises(RefusedError) as refused:
        told(fields, "disarmed", "73550173")
    chain = f"{refused.value} {refused.value.__cause__} {refused.value.__context__}"
    assert "73550173" not in chain


@pytest.mark.parametrize("missing", ["command_topic", "state_topic"])
def test_an_alarm_that_misses_a_topic_is_refused(missing: str) -> None:
    with pytest.raises(WireError, match=missing):
        alarm({key: value for key, value in RING.items() if key != missing})
