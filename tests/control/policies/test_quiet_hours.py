"""Quiet hours, in the local time of the home."""

from datetime import datetime, time
from zoneinfo import ZoneInfo

import pytest
from tests.control.policies.houses import START, make_command, make_device, make_facts

from homebot.config import parse_settings
from homebot.control import ControlSettings
from homebot.control.policy_engine import Policies
from homebot.errors import ConfigError
from homebot.words.times import TimeSpan

TABLE: dict[str, object] = {
    "quiet_hours": [{"start": "22:00", "end": "07:00", "commands": ["start vacuum", "use sirens"]}]
}
VACUUM = make_device("robby", "robotic_vacuum_cleaner", settable=("vacuum",))
NIGHT = START + 15 * 3600  # 23:00 UTC


def policies(table: dict[str, object] = TABLE) -> Policies:
    return Policies(parse_settings(ControlSettings, table, "homebot.toml", "control"))


def test_a_vacuum_does_not_start_at_night() -> None:
    verdict = policies().check(make_command(VACUUM, {"vacuum": "cleaning"}), make_facts(now=NIGHT))[-1]
    assert (verdict.policy, verdict.allowed) == ("quiet_hours", False)
    assert verdict.reason == "it is 23:00, and quiet from 22:00 to 07:00"
    assert verdict.facts[0].value == "23:00"


def test_it_may_be_stopped_at_night_and_started_by_day() -> None:
    assert policies().check(make_command(VACUUM, {"vacuum": "returning"}), make_facts(now=NIGHT))[-1].allowed
    assert policies().check(make_command(VACUUM, {"vacuum": "cleaning"}), make_facts())[-1].allowed


def test_a_person_may_start_it() -> None:
    wish = make_command(VACUUM, {"vacuum": "cleaning"}, "client:phone")
    assert policies().check(wish, make_facts(now=NIGHT))[-1].allowed


def test_the_time_is_that_of_the_home() -> None:
    facts = make_facts(now=START, zone=ZoneInfo("Asia/Tokyo"))  # 17:00
    assert policies().check(make_command(VACUUM, {"vacuum": "cleaning"}), facts)[-1].allowed
    late = make_facts(now=START + 6 * 3600, zone=ZoneInfo("Asia/Tokyo"))  # 23:00
    assert not policies().check(make_command(VACUUM, {"vacuum": "cleaning"}), late)[-1].allowed


@pytest.mark.parametrize(
    ("now", "is_quiet"), [("21:59", False), ("22:00", True), ("00:00", True), ("06:59", True), ("07:00", False)]
)
def test_hours_go_over_midnight(now: str, *, is_quiet: bool) -> None:
    assert TimeSpan(time(22), time(7)).has(time.fromisoformat(now)) is is_quiet


def test_an_unknown_time_zone_is_an_error() -> None:
    with pytest.raises(ConfigError, match="'Mars/Crater' is not a time zone"):
        parse_settings(ControlSettings, {"time_zone": "Mars/Crater"}, "homebot.toml", "control")


@pytest.mark.parametrize(
    ("start", "end", "key", "problem"),
    [
        ("22:00", "22:00", "end", "is 22:00, the same as start, so it would always be quiet"),
        ("22:00Z", "07:00", "start", "must be a local time such as 22:00"),
        ("22:00", "07:00+01:00", "end", "must be a local time such as 22:00"),
    ],
)
def test_hours_without_two_local_times_are_an_error(start: str, end: str, key: str, problem: str) -> None:
    hours = {"start": start, "end": end, "commands": ["start vacuum"]}
    with pytest.raises(ConfigError) as refused:
        policies({"quiet_hours": [hours]})
    assert refused.value.key == f"control.quiet_hours.0.{key}"
    assert problem in refused.value.reason


@pytest.mark.parametrize(
    ("now", "is_quiet"),
    [
        ("2026-10-24T19:59:00+00:00", False),  # 21:59 in Vienna, in summer
        ("2026-10-25T00:30:00+00:00", True),  # 02:30, an hour before it is so again
        ("2026-10-25T01:30:00+00:00", True),  # 02:30 again
        ("2026-10-25T05:59:00+00:00", True),  # 06:59, in winter
        ("2026-10-25T06:00:00+00:00", False),
        ("2026-03-29T04:59:00+00:00", True),  # 06:59, in summer again
        ("2026-03-29T05:00:00+00:00", False),
    ],
)
def test_hours_are_those_of_the_clock_on_the_wall_when_it_is_changed(now: str, *, is_quiet: bool) -> None:
    facts = make_facts(now=datetime.fromisoformat(now).timestamp(), zone=ZoneInfo("Europe/Vienna"))
    assert policies().check(make_command(VACUUM, {"vacuum": "cleaning"}), facts)[-1].allowed is not is_quiet
