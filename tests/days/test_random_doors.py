"""Doors of random days: the oracle judges what the presence guard and interlocks make of contacts, faulty ones too."""

from dataclasses import replace

import pytest
from tests.days.closed_rooms import closed_room_refusals
from tests.days.living import LivedDay, live
from tests.days.oracle import unseen, unseen_open, violations
from tests.days.random_app import RANDOM_APP
from tests.days.random_day import RandomDay, Table

from homebot.testing import Day
from homebot.testing.day_event import DayEvent

pytestmark = pytest.mark.rooms("homeassistant")

START = 5.5 * 3600.0
OFF_AT = 3480.0
OFF = {"at": OFF_AT, "device": "lamp", "capability": "on_off", "value": False}
"""At 06:28. Anna comes at 06:00, reads, and last moved at 06:20: longer ago than the guard waits."""

DOOR = {"hall": ["door"]}
HEAT = {"at": 600.0, "device": "heating", "capability": "heating_setpoint", "value": 25.0}
INTERLOCKS = [{"commands": ["heat thermostats"], "while": "open contact sensor", "where": "room"}]


def house(**faults: Table) -> Table:
    """The tables of a hall with one door, and Anna, who may leave it at 06:25; with the faults of its devices."""
    kinds = {"lamp": "lamp", "motion": "motion", "heating": "thermostat"}
    devices = {name: {"kind": kind, "room": "hall", "faults": faults.get(name, {})} for name, kind in kinds.items()}
    devices["door"] = {"kind": "contact", "room": "hall", "door": "outside", "faults": faults.get("door", {})}
    return {
        "house": {"dialect": "homeassistant"},
        "rooms": {"hall": {"window": 1.0, "doors": ["outside"]}},
        "devices": devices,
        "people": {"anna": {"asleep": False, "day": [{"at": "06:00", "room": "hall", "still": 600.0}]}},
    }


def random_day(tables: Table, order: Table, *happenings: DayEvent, doors: Table | None = None) -> RandomDay:
    """An hour in which an app gives *order*, and the guard knows *doors*."""
    control = {
        "time_zone": "UTC",
        "presence_guard": {"absent_after": 300.0} | ({} if doors is None else {"doors": doors}),
        "quiet_hours": [],
        "interlocks": INTERLOCKS,
        "rate_limit": {"changes": 4, "seconds": 10.0},
    }
    apps = {"everything": {"class": RANDOM_APP, "orders": [order]}}
    return RandomDay(Day(tables, happenings, START, 3600.0), control, apps, (), seed=0)


def lived_through(
    tables: Table, order: Table, *happenings: DayEvent, doors: Table | None = None
) -> tuple[RandomDay, LivedDay]:
    """The same, lived."""
    day = random_day(tables, order, *happenings, doors=doors)
    return day, live(day)


def leaving(tables: Table) -> Table:
    """The same, but that Anna goes out at 06:05, before she moves again."""
    day = [*tables["people"]["anna"]["day"], {"at": "06:05", "room": "outside"}]
    return {**tables, "people": {"anna": {"asleep": False, "day": day}}}


def test_no_lamp_goes_off_over_somebody_who_reads_behind_closed_doors() -> None:
    day, lived = lived_through(house(), OFF, doors=DOOR)
    assert violations(day, lived) == []
    assert lived.commands == []
    (refusal,) = closed_room_refusals(day, lived)
    assert (refusal.room, refusal.awake, refusal.is_sound, refusal.is_wrong) == ("hall", 1, True, False)


def test_without_the_table_of_doors_nobody_can_know_of_somebody_who_reads() -> None:
    day, lived = lived_through(house(), OFF)
    assert violations(day, lived) == []
    assert [one.device for one in unseen(lived)] == ["lamp"]
    assert closed_room_refusals(day, lived) == []


@pytest.mark.parametrize("fault", [{}, {"late": {"delay": 2.0}}, {"silent": {"since": START + 2000.0}}, {"stuck": {}}])
def test_the_oracle_sees_a_guard_that_does_not_know_of_closed_doors(fault: Table) -> None:
    """The contacts told that somebody stayed, and the guard, which was told of no doors, passed it over."""
    day = random_day(house(door=fault), OFF, doors=DOOR)
    lived = live(day, control={**day.control, "presence_guard": {"absent_after": 300.0}})
    assert [one.policy for one in violations(day, lived)] == ["presence_guard"]


@pytest.mark.parametrize(
    "fault", [{"unplugged": {"since": START + 2000.0}}, {"flapper": {"every": 60.0}}, {"late": {"delay": 3000.0}}]
)
def test_contacts_that_are_gone_or_told_of_an_open_door_show_nothing(fault: Table) -> None:
    day, lived = lived_through(house(door=fault), OFF, doors=DOOR)
    assert violations(day, lived) == []
    assert [one.device for one in unseen(lived)] + [one.room for one in closed_room_refusals(day, lived)] in (
        ["lamp"],
        ["hall"],
    )


def test_somebody_who_left_leaves_an_empty_room() -> None:
    day, lived = lived_through(leaving(house()), OFF, doors=DOOR)
    assert closed_room_refusals(day, lived) == []
    assert [one.awake for one in lived.commands] == [0]


def test_a_stuck_contact_keeps_a_room_occupied_and_the_oracle_knows_that_nobody_is_there() -> None:
    """It may be so with a fault; without one it would be a wrong reason."""
    day, lived = lived_through(leaving(house(door={"stuck": {}})), OFF, doors=DOOR)
    assert violations(day, lived) == []
    (refusal,) = closed_room_refusals(day, lived)
    assert (refusal.there, refusal.is_sound) == (0, False)
    healthy = replace(day, day=replace(day.day, house=leaving(house())))
    assert [one.policy for one in violations(healthy, lived)] == ["closed_room"]


WINDOW = DayEvent(START + 100.0, "press", "door", "open")


@pytest.mark.parametrize("fault", [{}, {"late": {"delay": 60.0}}, {"unplugged": {"since": START + 200.0}}])
def test_nothing_heats_while_a_contact_tells_of_an_open_door_or_is_gone(fault: Table) -> None:
    day, lived = lived_through(house(door=fault), HEAT, WINDOW)
    assert violations(day, lived) == []
    assert lived.commands == []


@pytest.mark.parametrize("fault", [{"stuck": {}}, {"late": {"delay": 1000.0}}, {"silent": {"since": START + 50.0}}])
def test_an_open_door_of_which_no_contact_tells_is_counted_apart(fault: Table) -> None:
    day, lived = lived_through(house(door=fault), HEAT, WINDOW)
    assert violations(day, lived) == []
    assert [(one.device, one.is_ever_told_open) for one in unseen_open(lived)] == [("heating", False)]


def test_a_lower_set_point_is_no_heat_while_a_door_is_open() -> None:
    """A random day found that the oracle took 25 °C for heat, whatever it was before."""
    tables = house()
    tables["devices"]["heating"]["target"] = 30.0
    day, lived = lived_through(tables, HEAT, WINDOW)
    assert violations(day, lived) == []
    assert [(one.device, one.target, one.is_told_open) for one in lived.commands] == [("heating", 30.0, True)]


def test_a_hand_that_changes_nothing_cannot_be_told_from_a_report_that_is_repeated() -> None:
    """A random day found it: a lamp that is on is switched on, reports it again, and the light service turns it off."""
    tables = house(lamp={"deaf": {}})
    tables["devices"]["lamp"]["is_on"] = True
    again = DayEvent(START + OFF_AT, "press", "lamp", "on")
    day = replace(random_day(tables, OFF, again), apps={"light_service": {}})
    lived = live(day)
    assert violations(day, lived) == []
    assert START + OFF_AT in [one.at for one in unseen(lived)]
