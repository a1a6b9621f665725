import pytest
from tests.integrations.announced_parts import Say, spoken_to
from tests.integrations.shelly.formats.rpc_documents import ANSWERS, ID

from homebot.integrations.shelly.formats import Shelly, ShellySettings


@pytest.fixture
def shelly() -> Shelly:
    return Shelly(ShellySettings())


@pytest.fixture
def say(shelly: Shelly) -> Say:
    return spoken_to(shelly, is_retained=False)


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
