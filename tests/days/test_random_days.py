"""Random days of random houses with random apps: no policy is ever violated, and every command has its chain.

``DAYS`` in the environment is their number; ``make days`` lives 1,000 whole ones and prints a table.

Its devices are those of ``homebot.integrations.homeassistant``.
"""

import os
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from tests.days.living import LivedDay, live
from tests.days.oracle import broken_chains, is_unseen, unseen, violations
from tests.days.random_app import RANDOM_APP
from tests.days.random_day import RandomDay, random_days
from tests.thesis_light_service import THESIS_LIGHT_SERVICE

from homebot.devices.trigger import Trigger
from homebot.testing import Day
from homebot.testing.day_event import DayEvent

DAYS = int(os.environ.get("DAYS", "4"))

COMING_HOME = Day.parse("""
[day]
start = "05:30"
length = "1h"

[house]
dialect = "homeassistant"

[rooms.hall]
window = 0.0
doors = ["outside"]

[devices.lamp]
kind = "lamp"
room = "hall"

[devices.motion]
kind = "motion"
room = "hall"

[people.anna]
asleep = false
day = [{ at = "06:00", room = "hall" }]
""")
CONTROL = {
    "time_zone": "UTC",
    "presence_guard": {"absent_after": 300.0},
    "quiet_hours": [],
    "rate_limit": {"changes": 1, "seconds": 10.0},
}


@pytest.mark.no_cover
@settings(max_examples=DAYS, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(random_days(max_length="2h"))
def test_no_policy_is_violated_and_every_command_has_its_chain(day: RandomDay) -> None:
    lived = live(day)
    assert violations(day, lived) == []
    assert broken_chains(lived) == []


def coming_home(app: str, *, has_policies: bool) -> tuple[RandomDay, LivedDay]:
    """Somebody comes home in the dark and turns on the light."""
    day = RandomDay(COMING_HOME, CONTROL, {}, (), seed=0)
    return day, live(day, app, has_policies=has_policies)


@pytest.mark.parametrize("app", [THESIS_LIGHT_SERVICE, "light_service"])
def test_without_policies_the_light_service_turns_lamps_off_over_people_and_the_oracle_sees_it(app: str) -> None:
    day, lived = coming_home(app, has_policies=False)
    assert any(one.policy == "presence_guard" for one in violations(day, lived))


@pytest.mark.parametrize("app", [THESIS_LIGHT_SERVICE, "light_service"])
def test_the_presence_guard_keeps_the_light_on(app: str) -> None:
    day, lived = coming_home(app, has_policies=True)
    assert violations(day, lived) == []
    assert [one.results[0].policy for one in lived.entries if one.results] != []
    assert lived.commands == []


OFF = {"at": 3000.0, "device": "lamp", "capability": "on_off", "value": False}
"""Anna has been there since 06:00, and the day begins at 05:30."""


def off_over_anna(fault: dict[str, object]) -> tuple[RandomDay, LivedDay]:
    """An app turns off the lamp over Anna, who may be seen by a sensor with *fault*; somebody walked past it before."""
    house = {**COMING_HOME.house}
    house["devices"] = {
        "lamp": {"kind": "lamp", "room": "hall"},
        "motion": {"kind": "motion", "room": "hall", "faults": fault},
    }
    walk = DayEvent(COMING_HOME.start + 10.0, "press", "motion", "motion")
    apps = {"everything": {"class": RANDOM_APP, "orders": [OFF]}}
    day = RandomDay(Day(house, (walk,), COMING_HOME.start, COMING_HOME.length), CONTROL, apps, (), seed=0)
    return day, live(day)


@pytest.mark.parametrize(
    "fault",
    [{}, {"stuck": {}}, {"silent": {"since": 0.0}}, {"flapper": {"every": 60.0}}, {"unplugged": {"since": 20_400.0}}],
)
def test_no_lamp_goes_off_over_somebody_whom_a_sensor_may_have_missed(fault: dict[str, object]) -> None:
    """One that has never detected anybody, or has no link, may have."""
    day, lived = off_over_anna(fault)
    assert violations(day, lived) == []
    assert unseen(lived) == []
    assert [one.results[0].policy for one in lived.entries if one.results] == ["presence_guard"]


@pytest.mark.parametrize("fault", [{"silent": {"since": 21_000.0}}, {"late": {"delay": 1500.0}}])
def test_what_no_sensor_tells_is_counted_apart(fault: dict[str, object]) -> None:
    """It worked, and says nothing of Anna: nobody can know, so that it is no violation."""
    day, lived = off_over_anna(fault)
    assert violations(day, lived) == []
    assert [one.device for one in unseen(lived)] == ["lamp"]


def test_a_hand_in_the_very_moment_is_known_to_who_answers_it_alone() -> None:
    """A random day found it: to an app that acts by the time, the report of the lamp was still on its way."""
    _, lived = off_over_anna({"silent": {"since": 21_000.0}})
    (command,) = (replace(one, is_switched=True) for one in lived.commands)
    assert is_unseen(command, lived)
    caused = [one.model_copy(update={"trigger": Trigger(kind="report", device=one.device)}) for one in lived.entries]
    assert not is_unseen(command, replace(lived, entries=caused))


def test_the_oracle_sees_a_strobe() -> None:
    orders = [
        {"at": 600.0 + number, "device": "lamp", "capability": "on_off", "value": number % 2 == 0}
        for number in range(6)
    ]
    apps = {"everything": {"class": RANDOM_APP, "orders": orders}}
    day = RandomDay(COMING_HOME, {**CONTROL, "presence_guard": False, "rate_limit": False}, apps, (), seed=0)
    judged = replace(day, control=CONTROL)
    assert any(one.policy == "rate_limit" for one in violations(judged, live(day)))


def test_a_command_right_after_a_text_does_not_overtake_it() -> None:
    """A random day found it: the lamp ended as the older one wanted it."""
    text = {"at": 600.0, "device": "lamp", "capability": "level", "value": 0.0, "text": "0"}
    level = {"at": 600.0, "device": "lamp", "capability": "level", "value": 40.0}
    thesis = Day({**COMING_HOME.house, "house": {"dialect": "thesis"}}, start=COMING_HOME.start, length=3600.0)
    apps = {"everything": {"class": RANDOM_APP, "orders": [text, level]}}
    lived = live(RandomDay(thesis, {"rate_limit": False}, apps, ((597.0, "lamp", "on_off", False),), seed=0))
    given = [one.command for one in lived.entries if one.kind in {"sent", "published"}]
    assert [one.id for one in lived.commands] == given
    assert [one.command for one in lived.commands] == ["off", "0", "0.4"]


def test_the_oracle_sees_what_is_missing_in_a_chain() -> None:
    _, lived = coming_home("light_service", has_policies=False)
    assert broken_chains(lived) == []
    for kind in ("requested", "acknowledged", "outcome"):
        rest = [one for one in lived.entries if one.kind != kind]
        assert broken_chains(replace(lived, entries=rest)) != []
    assert broken_chains(replace(lived, reports={1})) != []
