"""States that only repeat the command, as far as a config declares them."""

from __future__ import annotations

import json

import pytest

from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.homeassistant import HomeAssistantDiscovery, HomeAssistantSettings

TOPICS = {"state_topic": "lamp/state", "command_topic": "lamp/set"}
BRIGHTNESS = {"brightness_state_topic": "lamp/level", "brightness_command_topic": "lamp/set_level"}


@pytest.mark.parametrize(
    ("config", "echoed"),
    [
        (TOPICS, set()),
        ({**TOPICS, "optimistic": False}, set()),
        ({**TOPICS, "optimistic": True}, {"on_off"}),
        ({**TOPICS, "opt": "true"}, {"on_off"}),
        ({"state_topic": "lamp", "command_topic": "lamp"}, {"on_off"}),
        ({"command_topic": "lamp/set", "optimistic": True}, set()),  # what is not readable is never a report
        ({**TOPICS, **BRIGHTNESS, "optimistic": True}, {"on_off", "level"}),
    ],
)
def test_what_is_optimistic_or_reported_where_it_is_commanded_is_an_echo(
    config: dict[str, object], echoed: set[str]
) -> None:
    payload = json.dumps({"unique_id": "lamp", **config}).encode()
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    (announced,) = convention.read_message("homeassistant/light/lamp/config", payload, retained=True)
    assert isinstance(announced, DeviceAnnounced)
    (described,) = announced.parts
    assert {one.name for one in described.part.capabilities if one.echoed} == echoed
