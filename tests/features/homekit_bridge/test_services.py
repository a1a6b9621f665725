"""Values of parts as characteristics of HomeKit, and what is written as settings."""

import pytest
from tests.recorded_house import device, part

from homebot.devices.device import DevicePart
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.features.homekit_bridge.services import PartService, PartValues, services_of


def with_part(kind: str, *capabilities: Capability) -> DevicePart:
    return DevicePart(id="", part=Part(id="", service_type=kind, capabilities=capabilities), routes=())


def settable(name: str, bounds: tuple[float, ...] = (), options: tuple[str, ...] = ()) -> Capability:
    return Capability(name=name, settable=True, bounds=bounds, options=options)


LAMP = with_part("light", *map(settable, ("on_off", "level", "color")), settable("color_temperature", (2000.0, 6500.0)))
BLIND = with_part("window_covering", *map(settable, ("position", "movement", "tilt")))
RADIATOR = with_part(
    "thermostat",
    settable("heating_setpoint", (5.0, 30.0)),
    settable("thermostat_mode", options=("off", "heat", "eco")),
    Capability(name="local_temperature"),
)
COOLER = with_part(
    "room_air_conditioner",
    settable("heating_setpoint", (10.0, 30.0)),
    settable("cooling_setpoint", (16.0, 32.0)),
    settable("thermostat_mode", options=("off", "heat", "cool", "heat_cool")),
)


def only(one: DevicePart) -> PartService:
    (found,) = services_of(device("It", one), (one,))
    return found


def values(one: DevicePart, now: dict[str, PlainValue], **wanted: PlainValue) -> PartValues:
    return PartValues({capability.name: capability for capability in one.part.capabilities}, now, wanted)


def read(one: DevicePart, now: dict[str, PlainValue], **wanted: PlainValue) -> dict[str, object]:
    service = only(one)
    shown = service.kind.read(values(one, now, **wanted))
    return {name: shown[name] for name in service.characteristics()}


def write(one: DevicePart, now: dict[str, PlainValue], **written: float) -> dict[str, PlainValue]:
    service = only(one)
    assert service.kind.write is not None
    return service.kind.write(written, values(one, now))


def test_a_lamp_has_what_it_reports_and_only_that() -> None:
    now: dict[str, PlainValue] = {"on_off": True, "level": 40.0, "color_temperature": 4000.0, "color": (120.0, 80.0)}
    assert read(LAMP, now) == {
        "On": True,
        "Brightness": 40.0,
        "ColorTemperature": 250,
        "Hue": 120.0,
        "Saturation": 80.0,
    }
    assert set(read(LAMP, {}).values()) == {None}
    assert read(part("light", "level"), {"level": 0.0}) == {"On": False, "Brightness": 0.0}
    assert only(LAMP).characteristics()["ColorTemperature"] == {"minValue": 154, "maxValue": 500}


@pytest.mark.parametrize(
    ("written", "settings"),
    [
        ({"On": 1}, {"on_off": True}),
        ({"On": 0}, {"on_off": False}),
        ({"On": 1, "Brightness": 30}, {"level": 30.0}),
        ({"Brightness": 0}, {"on_off": False}),
        ({"Hue": 10, "Saturation": 90}, {"on_off": True, "color": (10.0, 90.0)}),
        ({"Hue": 10, "Brightness": 5}, {"color": (10.0, 50.0), "level": 5.0}),
        ({"ColorTemperature": 500}, {"on_off": True, "color_temperature": 2000.0}),
        ({"ColorTemperature": 154}, {"on_off": True, "color_temperature": 6493.506493506494}),
    ],
)
def test_what_is_written_to_a_lamp_is_one_command(written: dict[str, float], settings: dict[str, PlainValue]) -> None:
    assert write(LAMP, {"on_off": False, "color": (200.0, 50.0)}, **written) == settings
    assert write(part("light", "level"), {"level": 0.0}, On=1) == {"level": 100.0}


def test_a_blind_has_a_target_until_it_is_there_and_can_be_stopped_and_tilted() -> None:
    now: dict[str, PlainValue] = {"position": 20.0, "movement": "opening", "tilt": 100.0}
    shown = read(BLIND, now, position=60.0)
    assert [shown[name] for name in ("CurrentPosition", "TargetPosition", "PositionState")] == [20.0, 60.0, 1]
    assert (shown["CurrentHorizontalTiltAngle"], shown["TargetHorizontalTiltAngle"]) == (0, 0)
    assert read(BLIND, {"position": 20.0, "movement": "stopped"})["TargetPosition"] == 20.0
    assert write(BLIND, now, TargetPosition=70) == {"position": 70.0}
    assert write(BLIND, now, HoldPosition=1) == {"movement": "stopped"}
    assert write(BLIND, now, TargetHorizontalTiltAngle=90) == {"tilt": 0.0}
    only_moves = part("window_covering", "movement")
    assert (write(only_moves, {}, TargetPosition=100), write(only_moves, {}, TargetPosition=0)) == (
        {"movement": "open"},
        {"movement": "closed"},
    )


def test_a_thermostat_has_the_modes_that_homekit_knows_and_the_setpoint_of_its_mode() -> None:
    now: dict[str, PlainValue] = {"heating_setpoint": 21.0, "local_temperature": 19.0, "thermostat_mode": "heat"}
    shown = read(RADIATOR, now)
    assert (shown["TargetHeatingCoolingState"], shown["CurrentHeatingCoolingState"]) == (1, 1)
    assert (shown["CurrentTemperature"], shown["TargetTemperature"]) == (19.0, 21.0)
    assert read(RADIATOR, {**now, "thermostat_mode": "eco"})["TargetHeatingCoolingState"] is None
    assert [*only(RADIATOR).characteristics()["TargetHeatingCoolingState"]["ValidValues"].values()] == [0, 1]  # type: ignore[attr-defined]
    assert write(RADIATOR, now, TargetTemperature=20, TargetHeatingCoolingState=1) == {
        "thermostat_mode": "heat",
        "heating_setpoint": 20.0,
    }
    assert write(COOLER, {"thermostat_mode": "heat"}, TargetHeatingCoolingState=2, TargetTemperature=24) == {
        "thermostat_mode": "cool",
        "cooling_setpoint": 24.0,
    }
    assert write(COOLER, {"thermostat_mode": "heat_cool"}, CoolingThresholdTemperature=26) == {"cooling_setpoint": 26.0}
    assert write(part("thermostat", "heating_setpoint"), {}, TargetHeatingCoolingState=1) == {}


def test_locks_and_garage_doors_say_where_they_are_and_where_they_go() -> None:
    lock, garage = part("door_lock", "lock"), part("closure", "movement")
    assert read(lock, {"lock": "unlocked"}, lock="locked") == {"LockCurrentState": 0, "LockTargetState": 1}
    assert read(lock, {"lock": "jammed"})["LockCurrentState"] == 2
    assert write(lock, {}, LockTargetState=0) == {"lock": "unlocked"}
    assert read(garage, {"movement": "closing"}) == {
        "CurrentDoorState": 3,
        "TargetDoorState": 1,
        "ObstructionDetected": False,
    }
    assert (write(garage, {}, TargetDoorState=0), write(garage, {}, TargetDoorState=1)) == (
        {"movement": "open"},
        {"movement": "closed"},
    )


def test_a_sensor_has_a_service_for_each_value_and_its_battery() -> None:
    sensor = part("occupancy_sensor", "occupancy", "temperature", "illuminance", "battery", "signal_strength")
    now: dict[str, PlainValue] = {"occupancy": True, "temperature": 20.5, "illuminance": 0.0, "battery": 15.0}
    found = {
        service.kind.name: service.kind.read(PartValues(service.capabilities, now, {}))
        for service in services_of(device("It", sensor), (sensor,))
    }
    assert found == {
        "MotionSensor": {"MotionDetected": True},
        "TemperatureSensor": {"CurrentTemperature": 20.5},
        "LightSensor": {"CurrentAmbientLightLevel": 0.0001},
        "BatteryService": {"BatteryLevel": 15.0, "StatusLowBattery": 1, "ChargingState": 2},
    }
    assert [*services_of(device("It", sensor), ())] == []
