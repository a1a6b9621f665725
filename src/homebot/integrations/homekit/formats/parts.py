"""Parts of an accessory: one for each service with a known function; the services that only report. Pure.

Source: HomeKit Accessory Protocol Specification R2, chapter 8 (services), among them 8.3 (Air Quality Sensor), 8.5
(Battery) and 8.37 (Stateless Programmable Switch); 9.62 (Name), 9.91 (Service Label Index).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from homebot.conventions.capability_row import described
from homebot.conventions.units import sensor_type
from homebot.devices.part import Capability, Category, Part
from homebot.integrations.homekit.formats.accessory import INFORMATION, Accessory, HapService
from homebot.integrations.homekit.formats.rows import ServiceRow, service_row
from homebot.integrations.homekit.formats.services import CLIMATE_ROWS, OPENING_ROWS, POWER_ROWS

AIR, MOTION, OCCUPANCY, CONTACT, LEAK, SMOKE = "8D", "85", "86", "80", "83", "87"
MONOXIDE, DIOXIDE, BATTERY, FILTER = "7F", "97", "96", "BA"
PRESS: Final = "73"
"""The characteristic Programmable Switch Event."""

PRESSES: Final = {0: "single", 1: "double", 2: "long"}
_SENSORS: Final = f"{AIR} {MOTION} {OCCUPANCY} {CONTACT} {LEAK} {SMOKE} {MONOXIDE} {DIOXIDE} 8A 82 84"

_HEATER, _COOL_TO = "BC", "D"
_HEATERS: Final = frozenset({"4A", _HEATER})

_SENSOR_ROWS: Final = (
    service_row("89 121", "press", PRESS, "", PRESSES),  # buttons and doorbells
    service_row(MOTION, "occupancy", "22"),
    service_row(OCCUPANCY, "occupancy", "71"),
    service_row(CONTACT, "contact", "6A"),  # 1 is "not detected": open
    service_row(LEAK, "water_leak", "70"),
    service_row(SMOKE, "smoke", "76"),
    service_row(MONOXIDE, "carbon_monoxide_alarm", "69"),
    service_row(f"{MONOXIDE} {AIR}", "carbon_monoxide", "90"),
    service_row(DIOXIDE, "safety", "92"),
    service_row(f"{DIOXIDE} {AIR}", "carbon_dioxide", "93"),
    # 1 is excellent, 5 is poor
    service_row(AIR, "air_quality_index", "95", read=lambda service: service.number("95") or None),
    service_row(AIR, "pm25", "C6"),
    service_row(AIR, "pm10", "C7"),
    service_row(AIR, "volatile_organic_compounds", "C8"),
    service_row("", "temperature", "11", when=lambda service: service.type not in _HEATERS),
    service_row("", "humidity", "10"),
    service_row("", "illuminance", "6B"),
    service_row(BATTERY, "battery", "68"),
    service_row(
        BATTERY, "battery_charging", "8F", read=lambda service: service.number("8F") == 1
    ),  # 2 is "not chargeable"
    service_row(f"{BATTERY} {_SENSORS}", "battery_low", "79"),
    service_row(f"{_SENSORS} 7E", "tamper", "7A"),
    service_row(f"{_SENSORS} D0 D7 CF 7E", "problem", "77"),
    service_row(FILTER, "measurement", "AB", unit="%"),  # of its life that is left
    service_row(FILTER, "problem", "AC"),
    service_row("", "measurement", "B3BBFABC-D78C-5B8D-948C-5DAC1EE2CDE5", unit="dB"),  # of Netatmo: noise
    service_row("", "measurement", "E863F12E-079E-48FF-8F27-9C2605A29F52", unit="%"),  # of Eve: how far a valve is open
    service_row(INFORMATION, "locate", "14", "14"),
)

_CHILD_LOCK: Final = service_row("", "on_off", "A7", "A7")
"""A part of its own, as a plug, a purifier or a heater with it can be turned on itself."""

_ROWS: Final = (*POWER_ROWS, *OPENING_ROWS, *CLIMATE_ROWS, *_SENSOR_ROWS)

_TYPES: Final[Mapping[str, str]] = {
    "light": "43",
    "plug": "47",
    "switch": "49",
    "fan": "40 B7 BB",
    "speaker": "113 228",
    "video_player": "D8",
    "door_lock": "45",
    "closure": "41 81 8B",
    "window_covering": "8C",
    "water_valve": "D0 D7 CF",
    "x_alarm_panel": "7E",
    "thermostat": "4A",
    "room_air_conditioner": "BC",
    "x_humidifier": "BD",
    "air_quality_sensor": "8D 97",
    "occupancy_sensor": "85 86",
    "contact_sensor": "80",
    "water_leak_detector": "83",
    "smoke_co_alarm": "87 7F",
    "temperature_sensor": "8A",
    "humidity_sensor": "82",
    "light_sensor": "84",
    "x_battery": "96",
    "x_sensor": "BA",
    "generic_switch": "89 121",
}
"""The types of services of each type of parts."""

_TAGS: Final = {"41": "garage", "81": "door", "8B": "window", MOTION: "motion", OCCUPANCY: "occupancy"}
_TYPE_OF: Final = {service: kind for kind, services in _TYPES.items() for service in services.split()}
_CATEGORIES: Final[Mapping[str, Category]] = {"x_battery": "diagnostic", "x_setting": "config"}
_TELEVISION, _SOURCE, _INPUT, _INPUT_ID = "D8", "E7", "D9", "E6"
_NAME, _CONFIGURED_NAME, _LABEL_INDEX = "23", "E3", "CB"


@dataclass(frozen=True, slots=True)
class HomekitPart:
    """A part of an accessory, with its service, and the rows of its capabilities by their names."""

    part: Part
    service: HapService
    rows: Mapping[str, ServiceRow]


def parts_of(accessory: Accessory) -> Iterator[HomekitPart]:
    """Yield the parts of an accessory; last that of its information, which a bridge does not need."""
    own_name = accessory.information.text(_NAME)
    rows, has_function = (*_ROWS, *_source_rows(accessory)), False
    for service in sorted(accessory.services.values(), key=lambda service: service.type == INFORMATION):
        rows_by_capability: dict[str, tuple[Capability, ServiceRow]] = {}
        for capability, row in described(rows, service):
            rows_by_capability.setdefault(capability.name, (capability, row))
        if rows_by_capability and (has_function or service.type != INFORMATION):
            has_function = True
            capabilities = tuple(capability for capability, _ in rows_by_capability.values())
            other = "x_setting" if capabilities[0].settable else sensor_type(capabilities[0].name)
            only_heats = service.type == _HEATER and _COOL_TO not in service.characteristics
            service_type = "thermostat" if only_heats else _TYPE_OF.get(service.type, other)
            name = service.text(_CONFIGURED_NAME) or service.text(_NAME)
            index = service.number(_LABEL_INDEX)
            if name in {"", own_name}:
                name = "" if index is None else f"{index:g}"
            part = Part(
                id=str(service.iid),
                name=name,
                service_type=service_type,
                tag=_TAGS.get(service.type, ""),
                category=_CATEGORIES.get(service_type, ""),
                capabilities=capabilities,
            )
            yield HomekitPart(part, service, {name: row for name, (_, row) in rows_by_capability.items()})
        lock = _CHILD_LOCK.describe(service)
        if lock is not None:
            part = Part(
                id=f"{service.iid}-lock",
                name="Child lock",
                service_type="x_setting",
                category="config",
                capabilities=(lock,),
            )
            yield HomekitPart(part, service, {"on_off": _CHILD_LOCK})


def _source_rows(accessory: Accessory) -> Iterator[ServiceRow]:
    """Yield the row of a television's sources, which are services beside it."""
    sources: dict[int, str] = {}
    for other in accessory.services.values():
        number, name = other.number(_INPUT_ID), other.text(_CONFIGURED_NAME) or other.text(_NAME)
        if other.type == _INPUT and number is not None and name:
            sources[int(number)] = f"{name} {number:.0f}" if name in sources.values() else name
    if sources:
        yield service_row(_TELEVISION, "option", _SOURCE, _SOURCE, sources)
