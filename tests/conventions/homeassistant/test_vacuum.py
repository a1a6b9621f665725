from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.appliances import build_vacuum
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.devices.text.commands import decode_command
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

VALETUDO = {
    "command_topic": "valetudo/robot/BasicControlCapability/operation/set",
    "fan_speed_list": ["low", "max"],
    "payload_start": "START",
    "payload_pause": "PAUSE",
    "payload_stop": "STOP",
    "payload_return_to_base": "HOME",
    "payload_locate": "PERFORM",
    "set_fan_speed_topic": "valetudo/robot/FanSpeedControlCapability/preset/set",
    "state_topic": "valetudo/robot/hass/hass_state",
    "supported_features": ["start", "pause", "stop", "return_home", "battery", "status", "locate", "fan_speed"],
}
BARE = {"command_topic": "v/set", "state_topic": "v"}


def vacuum(fields: Mapping[str, object]) -> DescribedPart:
    return build_vacuum(DiscoveryConfig("vacuum", "node_1", fields))


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (
            b'{"state": "cleaning", "battery_level": 80, "fan_speed": "max"}',
            {"vacuum": "cleaning", "battery": 80.0, "fan_mode": "max"},
        ),
        (b'{"state": "docked"}', {"vacuum": "docked"}),
        (b'{"state": null}', {"vacuum": None}),
        (b'{"state": "flying", "battery_level": 120}', {"battery": 100.0}),
        (b'{"state": ["cleaning"], "fan_speed": 3, "battery_level": "full"}', {}),
        (b"cleaning", {}),
        (b"", {}),
    ],
)
def test_one_message_tells_all(said: bytes, expected: Mapping[str, PlainValue]) -> None:
    assert vacuum(VALETUDO).codec.read("valetudo/robot/hass/hass_state", said, retained=True) == expected


@pytest.mark.parametrize(
    ("capability", "value", "topic", "payload"),
    [
        ("vacuum", "cleaning", "command_topic", b"START"),
        ("vacuum", "paused", "command_topic", b"PAUSE"),
        ("vacuum", "idle", "command_topic", b"STOP"),
        ("vacuum", "returning", "command_topic", b"HOME"),
        ("locate", True, "command_topic", b"PERFORM"),
        ("fan_mode", "low", "set_fan_speed_topic", b"low"),
    ],
)
def test_it_is_told_as_home_assistant_does(capability: str, value: PlainValue, topic: str, payload: bytes) -> None:
    (publication,) = vacuum(VALETUDO).codec.write(capability, value)
    assert (publication.topic, publication.payload) == (VALETUDO[topic], payload)


@pytest.mark.parametrize(
    ("fields", "capability", "value"),
    [
        (VALETUDO, "vacuum", "spot"),
        (VALETUDO, "vacuum", "docked"),
        (VALETUDO, "fan_mode", "medium"),
        (VALETUDO, "locate", False),
        (BARE, "vacuum", "paused"),
        (BARE, "locate", True),
        (BARE, "fan_mode", "low"),
        ({"state_topic": "v"}, "vacuum", "cleaning"),
    ],
)
def test_what_it_does_not_support_is_refused(fields: Mapping[str, object], capability: str, value: PlainValue) -> None:
    with pytest.raises(RefusedError):
        vacuum(fields).codec.write(capability, value)


def test_a_vacuum_that_names_no_features_has_the_usual_ones() -> None:
    codec = vacuum(BARE).codec
    told = [codec.write("vacuum", word)[0].payload for word in ("cleaning", "idle", "returning", "spot")]
    assert told == [b"start", b"stop", b"return_to_base", b"clean_spot"]


def test_a_vacuum_that_says_it_has_no_features_has_none() -> None:
    part = vacuum({**BARE, "supported_features": []})
    assert [(one.name, one.settable) for one in part.part.capabilities] == [("vacuum", False)]


@pytest.mark.parametrize(("fields", "words"), [(VALETUDO, ["cleaning", "idle", "returning"]), (BARE, ["spot"])])
def test_it_names_the_words_that_it_takes(fields: Mapping[str, object], words: list[str]) -> None:
    part = vacuum(fields).part
    for word in words:
        assert decode_command(word, part) == ("vacuum", word)
    with pytest.raises(RefusedError, match="cleaning"):
        decode_command("docked", part)
