"""What is known of a home when a sensor is asked about a command."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from tests.control.policies.houses import START, make_command, make_device

from homebot.control.witnesses.activity import RecentActivity
from homebot.control.witnesses.command_watch import CommandWatch, watch_of
from homebot.control.witnesses.home_state import HomeState
from homebot.control.witnesses.sensors import Sensor, WitnessSensors
from homebot.devices import Device, Freshness, Reachability, State
from homebot.devices.value import PlainValue, Value
from homebot.messages import Time

BEGAN, NOW = 1000.0, 1010.0
SETTLE = 10.0
LUX = "lux", "", "illuminance"


def lux(room: str = "Hall", freshness: Freshness = "fresh") -> Device:
    return make_device("lux", "light_sensor", room=room, values={"illuminance": 5.0}, freshness=freshness)


LAMP = make_device("lamp", "light", room="Hall", settable=("on_off",), values={"on_off": False})
OTHER = make_device("other", "light", room="Hall", settable=("on_off",))
ATTIC = make_device("other", "light", room="Attic", settable=("on_off",))
NOWHERE = make_device("other", "light", settable=("on_off",))


def watched(sensor: Device | None = None) -> tuple[CommandWatch, Sensor]:
    """Turn the lamp on at :data:`BEGAN`, beside a sensor that has been followed for long."""
    found = WitnessSensors(())
    found.put(sensor or lux(), 100.0)
    command = make_command(LAMP, {"on_off": True})
    watch = watch_of(command, found.candidates(command), None, BEGAN, lambda: None)
    assert watch is not None
    return watch, next(iter(watch.marks))


def home(*devices: Device, changes: Mapping[float, str] | None = None, wall: float = START) -> HomeState:
    """Return a home in which the devices with these ids changed at these times."""
    activity = RecentActivity()
    for at, name in (changes or {}).items():
        activity.note((name, ""), at)
    return HomeState(activity, {one.id: one for one in devices}, NOW, wall)


def test_a_home_in_which_nothing_was_switched_is_quiet_for_as_long_as_counts() -> None:
    watch, sensor = watched()
    assert home(LAMP).quiet_since(watch, sensor, SETTLE) == BEGAN - 60.0


def test_what_was_switched_near_the_sensor_has_to_settle() -> None:
    watch, sensor = watched()
    assert home(LAMP, OTHER, changes={970.0: "other"}).quiet_since(watch, sensor, SETTLE) == 980.0


def test_a_sensor_is_known_to_be_quiet_from_its_first_reading_on() -> None:
    found = WitnessSensors(())
    found.put(lux(), 990.0)
    command = make_command(LAMP, {"on_off": True})
    watch = watch_of(command, found.candidates(command), None, BEGAN, lambda: None)
    assert watch is not None
    assert home(LAMP).quiet_since(watch, next(iter(watch.marks)), SETTLE) == 990.0


@pytest.mark.parametrize(
    ("other", "is_disturbed"), [(OTHER, True), (ATTIC, False), (NOWHERE, True), (None, True)], ids=str
)
def test_what_is_switched_in_the_room_or_nobody_knows_where_disturbs(other: Device | None, is_disturbed: bool) -> None:  # noqa: FBT001 - from the table
    watch, sensor = watched()
    known = [LAMP] if other is None else [LAMP, other]
    assert home(*known, changes={1003.0: "other"}).is_disturbed(watch, sensor) is is_disturbed


def test_a_sensor_without_a_room_is_disturbed_by_every_device() -> None:
    watch, sensor = watched(lux(room=""))
    assert home(LAMP, ATTIC, changes={1003.0: "other"}).is_disturbed(watch, sensor)


def test_what_the_commanded_part_does_itself_does_not_disturb() -> None:
    watch, sensor = watched()
    assert not home(LAMP, changes={1001.0: "lamp", 1003.0: "lamp"}).is_disturbed(watch, sensor)


def test_what_was_switched_before_the_command_does_not_disturb() -> None:
    watch, sensor = watched()
    assert not home(LAMP, OTHER, changes={999.0: "other"}).is_disturbed(watch, sensor)


def test_a_command_that_is_on_its_way_to_another_lamp_disturbs() -> None:
    watch, sensor = watched()
    at = home(LAMP, OTHER)
    at.activity.begin("2", ("other", ""))
    assert at.is_disturbed(watch, sensor)


def test_a_home_of_which_changes_were_forgotten_is_disturbed() -> None:
    watch, sensor = watched()
    at = home(LAMP, ATTIC)
    for number in range(600):
        at.activity.note(("other", ""), 1001.0 + number / 100)
    assert at.is_disturbed(watch, sensor)


def test_a_contact_that_changes_is_the_sensor_and_disturbs_nobody_but_others() -> None:
    contact = make_device("contact", "contact_sensor", room="Hall", values={"contact": False})
    blind = make_device("blind", "window_covering", room="Hall", settable=("movement",), values={"movement": "closed"})
    found = WitnessSensors(())
    found.put(contact, 100.0)
    command = make_command(blind, {"movement": "open"})
    watch = watch_of(command, found.candidates(command), None, BEGAN, lambda: None)
    assert watch is not None
    assert not home(blind, contact, changes={1003.0: "contact"}).is_disturbed(watch, next(iter(watch.marks)))
    other, sensor = watched()
    assert home(LAMP, contact, changes={1003.0: "contact"}).is_disturbed(other, sensor)


@pytest.mark.parametrize(("told", "is_alive"), [(5.0, True), (10.0, True), (11.0, False), (-3.0, False)])
def test_a_sensor_is_alive_if_it_reported_since(told: float, is_alive: bool) -> None:  # noqa: FBT001 - from the table
    """The times of its reports are those of the computer's clock, which may be set."""
    assert home(lux(), wall=START + told).is_alive(LUX, NOW - 10.0) is is_alive


def test_of_a_sensor_with_several_values_a_message_that_reports_none_is_no_report() -> None:
    old, new = Time.from_seconds(START), Time.from_seconds(START + 60.0)
    battery = State(part="", capability="battery", value=Value.of(80.0), since=old, told_at=old, live=True)
    one = lux().model_copy(update={"last_seen": new})
    several = one.model_copy(update={"states": (*one.states, battery)})
    assert home(one, wall=START + 62.0).is_alive(LUX, NOW - 10.0)
    assert not home(several, wall=START + 62.0).is_alive(LUX, NOW - 10.0)


def test_a_value_that_the_broker_had_kept_is_no_sign_of_life() -> None:
    values: Mapping[str, PlainValue] = {"illuminance": 5.0, "battery": 80.0}
    kept = make_device("lux", "light_sensor", values=values, is_live=False)
    assert not home(kept, wall=START + 5.0).is_alive(LUX, NOW - 10.0)


@pytest.mark.parametrize(
    "device",
    [
        lux(freshness="stale"),
        lux(freshness="unconfirmed"),
        lux().model_copy(update={"reachable": Reachability(state="no")}),
        lux().model_copy(update={"offline_parts": ("",)}),
        None,
    ],
    ids=["stale", "unconfirmed", "unreachable", "a part that is offline", "gone"],
)
def test_a_sensor_that_is_away_is_neither_reachable_nor_alive(device: Device | None) -> None:
    at = home(*([] if device is None else [device]), wall=START + 5.0)
    assert (at.is_reachable(LUX), at.is_alive(LUX, NOW - 10.0)) == (False, False)
