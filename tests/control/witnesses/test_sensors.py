"""The sensors of a home, and which of them may see what a command does."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from tests.control.policies.houses import make_command, make_device

from homebot.control.witnesses.sensors import WitnessSensors, reading_of
from homebot.devices import Device
from homebot.devices.query import Query, parse_query
from homebot.devices.value import PlainValue

ON: Mapping[str, PlainValue] = {"on_off": True}
OPEN: Mapping[str, PlainValue] = {"movement": "open"}


def lamp(room: str = "Hall", *reads: str) -> Device:
    return with_reads(make_device("lamp", "light", room=room, settable=("on_off",)), *reads)


def lux(key: str = "lux", room: str = "Hall", *reads: str) -> Device:
    return with_reads(make_device(key, "light_sensor", room=room, values={"illuminance": 5.0}), *reads)


def with_reads(device: Device, *reads: str) -> Device:
    (only,) = device.parts
    part = only.model_copy(update={"part": only.part.model_copy(update={"reads": reads})})
    return device.model_copy(update={"parts": (part,)})


def sensors(*devices: Device, named: tuple[tuple[Query, str], ...] = ()) -> WitnessSensors:
    found = WitnessSensors(named)
    for one in devices:
        found.put(one, 1.0)
    return found


def seers(found: WitnessSensors, device: Device, settings: Mapping[str, PlainValue] = ON) -> list[str]:
    return [one.device.id for one in found.candidates(make_command(device, settings))]


def test_sensors_of_the_room_come_first_then_those_without_a_room_then_meters_of_the_house() -> None:
    meter = make_device("meter", "electrical_meter", room="Attic", values={"power": 5.0})
    found = sensors(meter, lux("b", room=""), lux("z"), lux("attic", room="Attic"))
    assert seers(found, lamp()) == ["z", "b", "meter"]


def test_a_device_without_a_room_is_seen_by_sensors_without_one() -> None:
    assert seers(sensors(lux("b", room=""), lux("z")), lamp(room="")) == ["b"]


def test_four_sensors_are_compared_those_of_the_room_first() -> None:
    found = sensors(*(lux(f"s{number}", room="" if number < 3 else "hall") for number in range(6)))
    assert seers(found, lamp()) == ["s3", "s4", "s5", "s0"]


def test_only_sensors_of_what_the_command_does_are_asked() -> None:
    contact = make_device("contact", "contact_sensor", room="Hall", values={"contact": True})
    assert seers(sensors(contact, lux()), lamp(), OPEN) == ["contact"]
    assert seers(sensors(contact, lux()), lamp(), {"thermostat_mode": "heat"}) == []


def test_a_sensor_of_the_device_itself_or_of_the_same_topic_is_no_witness() -> None:
    own = make_device("lamp", "light", room="Hall", settable=("on_off",), values={"power": 5.0})
    assert seers(sensors(own), own) == []
    assert seers(sensors(lux("lux", "Hall", "home/lamp")), lamp("Hall", "home/lamp")) == []
    assert seers(sensors(lux("lux", "Hall", "home/lux")), lamp("Hall", "home/lamp")) == ["lux"]


def test_what_can_be_set_is_no_sensor() -> None:
    valve = make_device("valve", "water_valve", room="Hall", settable=("flow",))
    assert sensors(valve).ids == set()


def test_a_meter_that_switches_is_no_meter_of_the_house() -> None:
    plug = make_device("plug", "electrical_meter", room="Attic", settable=("on_off",), values={"power": 5.0})
    assert seers(sensors(plug), lamp()) == []


@pytest.mark.parametrize(("name", "expected"), [("attic", ["attic"]), ("ATTIC", ["attic"]), ("", []), ("gone", [])])
def test_the_sensor_that_the_owner_names_is_the_only_one(name: str, expected: list[str]) -> None:
    named = ((parse_query("light in hall"), name.lower()),)
    assert seers(sensors(lux("attic", room="Attic"), lux(), named=named), lamp()) == expected


def test_what_a_sensor_reported_live_before_it_was_followed_is_its_first_reading() -> None:
    (sensor,) = sensors(lux()).candidates(make_command(lamp(), ON))
    assert (sensor.history.count, sensor.history.begins, sensor.history.value_at(1)) == (1, 1.0, 5.0)


def test_what_the_broker_had_kept_of_a_sensor_is_no_reading() -> None:
    retained = make_device("lux", "light_sensor", room="Hall", values={"illuminance": 5.0}, is_live=False)
    (sensor,) = sensors(retained).candidates(make_command(lamp(), ON))
    assert sensor.history.count == 0


def test_a_sensor_that_is_described_anew_keeps_its_readings_and_moves_to_its_room() -> None:
    found = sensors(lux())
    (sensor,) = found.candidates(make_command(lamp(), ON))
    sensor.history.note(7.0, 2.0)
    found.put(lux(room="Attic"), 3.0)
    assert seers(found, lamp("Hall")) == []
    (moved,) = found.candidates(make_command(lamp("Attic"), ON))
    assert moved is sensor
    assert moved.history.count == 2


def test_a_sensor_that_is_removed_is_asked_no_more() -> None:
    found = sensors(lux())
    found.remove("lux")
    assert (found.ids, found["lux", "", "illuminance"], seers(found, lamp())) == (set(), None, [])


def test_how_finely_a_sensor_reported_is_remembered_before_it_is_there() -> None:
    found = sensors()
    for number in range(1001):
        found.remember((f"lux{number}", "", "illuminance"), [(0.0, 5.0, 2.0)], [5.0])
    found.put(lux("lux1000"), 1.0)
    found.put(lux("lux0"), 1.0)  # the one that was remembered first is forgotten
    known = {one.device.id: one.history.resolution.levels for one in found.candidates(make_command(lamp(), ON))}
    assert known == {"lux1000": (5.0, 5.0), "lux0": (5.0,)}


def test_how_finely_a_sensor_reported_is_added_to_what_it_reported_since() -> None:
    found = sensors(lux())
    found.remember(("lux", "", "illuminance"), [(0.0, 5.0, 2.0)], [3.0])
    (sensor,) = found.candidates(make_command(lamp(), ON))
    assert (sensor.history.resolution.levels, sensor.history.count) == ((3.0, 5.0), 1)


@pytest.mark.parametrize(
    ("value", "expected"), [(True, 1.0), (False, 0.0), (4.5, 4.5), ("bright", None), (None, None), ((1.0, 2.0), None)]
)
def test_a_reading_is_a_number_or_none(value: PlainValue, expected: float | None) -> None:
    assert reading_of(value) == expected
