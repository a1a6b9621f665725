"""Settings of policies are written as they are read, for a recording."""

import json

import pytest

from homebot.config import parse_settings
from homebot.control import ControlSettings
from homebot.recording.secrets import public_settings

GUARD = {"absent_after": 20, "commands": ["turn off lights in hall", "close"], "doors": {"bath": ["Bath door"]}}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "table",
    [
        {},
        {"presence_guard": True, "rate_limit": False, "always_ask": False, "approvals": False},
        {"presence_guard": GUARD, "rate_limit": {"changes": 5}, "time_zone": "Europe/Vienna"},
        {"quiet_hours": [{"start": "22:00", "end": "07:00:30", "commands": ["use siren"]}]},
        {"interlocks": [{"commands": ["heat", 'turn on name="Fan"'], "while": "open contact", "where": "home"}]},
        {"witnesses": {"light in hall": "Hall lux", "plug": ""}, "timeout": 12.5, "retries": 0},
    ],
)
def test_what_is_recorded_of_them_says_the_same(table: dict[str, object]) -> None:
    settings = parse_settings(ControlSettings, table, "homebot.toml", "control")
    written = json.loads(json.dumps(public_settings(settings)))
    assert parse_settings(ControlSettings, written, "a recording", "control") == settings
