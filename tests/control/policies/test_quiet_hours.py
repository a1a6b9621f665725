"""Quiet hours, in the local time of the home."""

from __future__ import annotations

from datetime import time
from zoneinfo import ZoneInfo

import pytest
from tests.control.policies.houses import START, make_command, make_device, make_facts

from homebot.config import parse_settings
from homebot.control import ControlSettings
from homebot.control.policies import Policies
from homebot.control.policies.quiet_hours import is_within
from homebot.errors import ConfigError

TABLE: dict[str, object] = {
    "quiet_hours": [{"start": "22:00", "end": "07:00", "commands": ["start vacuum", "use sirens"]}]
}
VACUUM = make_device("robby", "robotic_vacuum_cleaner", settable=("vacuum",))
NIGHT = START + 15 * 3600  # 23:00 UTC


def policies(table: dict[str, object] = TABLE) -> Policies:
    return Policies(parse_settings(ControlSettings, table, "homebot.toml", "control"))


def test_a_vacuum_does_not_start_at_night() -> None:
    verdict = policies().judge(make_command(VACUUM, {"vacuum": "cleaning"}), make_facts(now=NIGHT))[-1]
    assert (verdict.policy, verdict.allowed) == ("quiet_hours", False)
    assert verdict.reason == "it is 23:00, and quiet from 22:00 to 07:00"
    assert verdict.facts[0].value == "23:00"


def test_it_may_be_stopped_at_night_and_started_by_day() -> None:
    assert policies().judge(make_command(VACUUM, {"vacuum": "returning"}), make_facts(now=NIGHT))[-1].allowed
    assert policies().judge(make_command(VACUUM, {"vacuum": "cleaning"}), make_facts())[-1].allowed


def test_a_person_may_start_it() -> None:
    wish = make_command(VACUUM, {"vacuum": "cleaning"}, "client:phone")
    assert policies().judge(wish, make_facts(now=NIGHT))[-1].allowed


def test_the_time_is_that_of_the_home() -> None:
    facts = make_facts(now=START, zone=ZoneInfo("Asia/Tokyo"))  # 17:00
    assert policies().judge(make_command(VACUUM, {"vacuum": "cleaning"}), facts)[-1].allowed
    late = make_facts(now=START + 6 * 3600, zone=ZoneInfo("Asia/Tokyo"))  # 23:00
    assert not policies().judge(make_command(VACUUM, {"vacuum": "cleaning"}), late)[-1].allowed


@pytest.mark.parametrize(
    ("now", "is_quiet"), [("21:59", False), ("22:00", True), ("00:00", True), ("06:59", True), ("07:00", False)]
)
def test_hours_go_over_midnight(now: str, *, is_quiet: bool) -> None:
    assert is_within(time.fromisoformat(now), time(22), time(7)) is is_quiet


def test_an_unknown_time_zone_is_an_error() -> None:
    with pytest.raises(ConfigError, match="'Mars/Crater' is no time zone"):
        parse_settings(ControlSettings, {"time_zone": "Mars/Crater"}, "homebot.toml", "control")
