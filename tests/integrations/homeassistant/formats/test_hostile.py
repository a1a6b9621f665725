"""Attacks by an announcement or a state are refused or bounded; the fuzzer damages real ones."""

import json

import pytest
from tests.integrations.announced_parts import announced, homeassistant_parts

from homebot.errors import RefusedError, WireError
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings

pytestmark = pytest.mark.slow

DEVICE = {"identifiers": ["i"], "name": "n"}


@pytest.mark.parametrize(
    "payload",
    [
        json.dumps({"cmps": {f"c{n}": {"p": "switch", "cmd_t": "a"} for n in range(10_000)}, "dev": DEVICE}).encode(),
        json.dumps({"command_topic": "a", "device": {"identifiers": [str(n) for n in range(10_000)]}}).encode(),
        json.dumps({"command_topic": "a/+/set"}).encode(),
        json.dumps({"command_topic": "a" * 70_000}).encode(),
    ],
    ids=range(4),
)
@pytest.mark.parametrize("topic", ["homeassistant/switch/x/config", "homeassistant/device/x/config"])
def test_an_attack_is_refused(topic: str, payload: bytes) -> None:
    with pytest.raises(WireError) as refused:
        HomeAssistantDiscovery(HomeAssistantSettings()).read_message(topic, payload, retained=False)
    assert len(str(refused.value)) < 400


def test_a_name_of_any_length_and_content_is_cut_to_a_line() -> None:
    fields = {"cmd_t": "a", "name": "<b>\x1b[31m" + "n" * 8_000, "dev": {"ids": "x", "name": "d\n" + "n" * 100_000}}
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    (found,) = announced(convention, ("homeassistant/switch/x/config", fields))
    assert (found.name[:4], len(found.name)) == ("d nn", 120)
    assert (found.parts[0].part.name[:8], len(found.parts[0].part.name)) == ("<b> [31m", 120)


def test_a_long_state_is_not_looked_at() -> None:
    (part,) = homeassistant_parts("switch", {"cmd_t": "a/set", "stat_t": "a"})
    assert part.codec.read("a", b"ON" + b" " * 300_000, retained=False) == {}


def test_a_valve_without_a_stop_has_a_payload_of_null() -> None:
    """Found by fuzzing: a payload that is null means that there is no such command."""
    (part,) = homeassistant_parts("valve", {"cmd_t": "v/set", "stat_t": "v", "payload_stop": None})
    (told,) = part.codec.write("valve", "open")
    assert told.payload == b"OPEN"
    with pytest.raises(RefusedError):
        part.codec.write("valve", "stopped")
