import json
from collections.abc import Callable

import pytest
from tests.conventions.shelly.rpc_documents import ANSWERS, ID

from homebot.conventions.description import AnnouncementEvent
from homebot.conventions.shelly import Shelly, ShellySettings

Say = Callable[..., tuple[AnnouncementEvent, ...]]


@pytest.fixture
def shelly() -> Shelly:
    return Shelly(ShellySettings())


@pytest.fixture
def say(shelly: Shelly) -> Say:
    """Says a message to the convention; what is no text is spelled in JSON."""

    def say(topic: str, payload: object, *, retained: bool = False) -> tuple[AnnouncementEvent, ...]:
        text = payload if isinstance(payload, str) else json.dumps(payload)
        return shelly.read_message(topic, text.encode(), retained=retained)

    return say


@pytest.fixture
def gateway(say: Say) -> Say:
    """A gateway that was asked and answered all but the last question."""
    for result in (
        {"id": ID, "mac": "A8032ABE54DC", "gen": 3, "app": "BluGwG3"},
        {"sys": {"device": {"name": "Gateway"}}},
        {"sys": {"mac": "A8032ABE54DC"}, "wifi": {}},
    ):
        say(ANSWERS, {"id": 1, "src": ID, "result": result})
    return say
