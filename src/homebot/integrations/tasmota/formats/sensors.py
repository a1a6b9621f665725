"""Sensors of a Tasmota device: each leaf of its ``sensors`` message, and the capabilities for their names. Pure.

Source: hatasmota 0.10.2, ``sensor.py``; Home Assistant core 2025.4, ``components/tasmota/sensor.py``;
tasmota.github.io/docs, JSON status responses and Smart Meter Interface, for the names in use; ioBroker.sonoff 3.3;
evcc, Tasmota template, for the phases of a meter.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

from homebot.conventions.description import DescribedPart
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, as_fields, clean_text, is_unknown, text_of
from homebot.conventions.probe_errors import DS18X20_GONE, DS18X20_RESET, read_probe
from homebot.conventions.units import Quantity, quantity
from homebot.conventions.unreadable import unreadable
from homebot.integrations.tasmota.formats.config import TasmotaConfig, sensor_values
from homebot.support.numbers import finite_number


def _quantity_of(path: tuple[str | int, ...], sensors: Mapping[str, object]) -> Quantity:
    """Return the quantity at *path*; a plain measurement if its name is unknown.

    Args:
        path: Sensor, name, and perhaps an index or an inner name.
        sensors: The device's message, with the units of temperature and pressure.
    """
    sensor, name = str(path[0]), str(path[1])
    inner = path[2] if len(path) > _MIN_WORD_CHARACTERS else None
    if name == "Energy" and sensor in _OTHER_ENERGY:
        return _PLAIN
    if isinstance(inner, str) and inner in _KNOWN:
        name = inner
    elif sensor == "ANALOG" and name[-1:].isdigit():
        name = name[:-1]
    if name in _WITH_UNITS:
        key, known = _WITH_UNITS[name]
        unit = sensors.get(key)
        return known.get(unit, _PLAIN) if isinstance(unit, str) else _PLAIN
    return _KNOWN.get(name, _PLAIN)


_MIN_WORD_CHARACTERS = 2
_OTHER_ENERGY = frozenset({"AS3935", "LD2410"})
"""Sensors of the energy of lightning or of a radar's echo."""

_PLAIN = Quantity("x_sensor", "measurement")


def _plain(unit: str) -> Quantity:
    return Quantity("x_sensor", "measurement", unit)


_ENERGIES = ("Energy", "ImportActive", "Total", "TotalTariff", "Total_in")
_RETURNED = ("ExportActive", "ExportActiveTotal", "ExportTariff", "Total_out")
_OF_A_DAY = ("Today", "TodaySumExport", "TodaySumImport", "Yesterday")
"""Energies that ``Total`` counts as well: the sum of all meters would be twice the energy."""

_KNOWN: Mapping[str, Quantity] = {
    **dict.fromkeys(_ENERGIES, quantity("energy")),
    **dict.fromkeys(_RETURNED, quantity("energy_returned")),
    **dict.fromkeys(_OF_A_DAY, _plain("kWh")),
    **dict.fromkeys(("ActivePower", "Power", "PowerTotal", "Power_curr"), quantity("power")),
    **dict.fromkeys(("Current", "CurrentNeutral"), quantity("current")),
    **{f"{name}_l{phase}": quantity(name) for name in ("current", "power", "voltage") for phase in (1, 2, 3)},
    "Voltage": quantity("voltage"),
    "Frequency": quantity("frequency"),
    **dict.fromkeys(("Ambient", "Illuminance"), quantity("illuminance")),
    "Battery": quantity("battery"),
    "CarbonDioxide": quantity("carbon_dioxide"),
    "Humidity": quantity("humidity"),
    "Moisture": quantity("soil_moisture"),
    "PM1": quantity("pm1"),
    "PM10": quantity("pm10"),
    "PM2.5": quantity("pm25"),
    "ApparentPower": _plain("VA"),
    "CCT": _plain("K"),
    **dict.fromkeys(("CF1", "CF10", "CF2.5"), _plain("µg/m³")),
    "Distance": _plain("cm"),
    "eCO2": _plain("ppm"),
    **dict.fromkeys(("ExportReactive", "ImportReactive"), _plain("kvarh")),
    "PhaseAngle": _plain("°"),
    "ReactivePower": _plain("var"),
    "TVOC": _plain("ppb"),
    "Weight": _plain("kg"),
}
_TEMPERATURES: Mapping[str, Quantity] = {unit: quantity("temperature", f"°{unit}") for unit in ("C", "F")}
_PRESSURES: Mapping[str, Quantity] = {unit: quantity("pressure", unit) for unit in ("hPa", "mmHg", "inHg")}
_SPEEDS: Mapping[str, Quantity] = {unit: _plain(unit) for unit in ("m/s", "km/h", "kn", "mph", "ft/s", "yd/s")}

_WITH_UNITS: Mapping[str, tuple[str, Mapping[str, Quantity]]] = {
    "DewPoint": ("TempUnit", _TEMPERATURES),
    "Temperature": ("TempUnit", _TEMPERATURES),
    "Pressure": ("PressureUnit", _PRESSURES),
    "SeaPressure": ("PressureUnit", _PRESSURES),
    "Speed": ("SpeedUnit", _SPEEDS),
}
"""By name: the key of its unit in the message, and the quantities by unit."""


MAX_SENSORS = 200
"""Most leaves of one device that become sensors."""

Path: TypeAlias = tuple[str | int, ...]


@dataclass(frozen=True, slots=True)
class Leaf:
    """One measured value, by its path in the message.

    Attributes:
        is_number: Whether it is announced as a number.
        is_internal: Whether it is the temperature of the device itself, not of the room.
        probe: The address of its probe on a bus, by which it is found in messages; empty for none.
    """

    path: Path
    quantity: Quantity
    is_number: bool
    is_internal: bool = False
    probe: str = ""


def read_leaves(message: Mapping[str, object], probes: dict[str, str]) -> tuple[Leaf, ...]:
    """Return the leaves of the ``sensors`` message; empty for another version. Long names are ignored.

    Args:
        probes: The names of probes on a bus by address, which keep those of their first message: Tasmota numbers them
            anew when one is added. New ones are added to it.
    """
    sensors = message.get("sn")
    if message.get("ver") != 1 or not isinstance(sensors, dict):
        return ()
    leaves: list[Leaf] = []
    for path, value, probe in _leaves(sensors, probes):
        if len(leaves) == MAX_SENSORS:
            break
        if any(len(step) > _MAX_KEY for step in path if isinstance(step, str)):
            continue
        quantity, sensor = _quantity_of(path, sensors), str(path[0])
        # A chip of the device, or the thermometer that protects a plug or a relay: the analog input beside a meter.
        is_inside = sensor.startswith(_CHIPS) or (sensor == "ANALOG" and "ENERGY" in sensors)
        is_internal = quantity.capability == "temperature" and is_inside
        leaves.append(Leaf(path, quantity, finite_number(value) is not None, is_internal, probe))
    return tuple(leaves)


def _rank(leaf: Leaf) -> int:
    """Return the place of *leaf* among the sensors: what is now, counters, the rest."""
    return 2 if leaf.quantity.capability == "measurement" else int("energy" in leaf.quantity.capability)


def describe_sensors(config: TasmotaConfig, leaves: Iterable[Leaf]) -> Iterable[DescribedPart]:
    """Describe a part for each leaf, and one for the strength of the wireless signal."""
    for leaf in sorted(leaves, key=_rank):
        quantity = leaf.quantity
        is_number = leaf.is_number or quantity.capability != "measurement"
        part = JsonPart(
            clean_text("_".join(map(str, leaf.path)), _MAX_ID),
            quantity.service_type,
            name=clean_text(" ".join(map(str, leaf.path))),
            advertised=clean_text(str(leaf.path[-1 if isinstance(leaf.path[-1], str) else -2])),
            category="diagnostic" if leaf.is_internal or _DIAGNOSTIC.search(" ".join(map(str, leaf.path))) else "",
        )
        capability = quantity.capability if is_number else "value"
        for topic in config.sensors:
            part.read_from(topic, partial(_read, leaf, capability))
        part.add_capability(capability, unit=quantity.unit if is_number else "")
        part.add_state_request(*config.sensor_requests)
        yield part.build()
    signal = JsonPart("wifi", "x_sensor", name="Wi-Fi", advertised="Wifi", category="diagnostic")
    signal.read_from(config.telemetry, _read_signal)
    signal.add_capability("signal_strength")
    yield signal.build()


_DIAGNOSTIC = re.compile("^Shutter[0-9]| (Id|TotalStartTime)$")
"""Values of a shutter, which is a part itself, and facts of a sensor."""


_CHIPS = ("AXP", "BL09", "CSE77", "ESP32")
"""Beginnings of the names of processors, and of chips that measure power or charge a battery."""

_IGNORED = frozenset({"Time", "PN532", "RDM6300"})
"""No sensors, or readers of tags, which report events."""

_MAX_KEY = 100
_MAX_ID = 255
_MAX_VALUE = 255


def _leaves(sensors: Mapping[str, object], probes: dict[str, str]) -> Iterable[tuple[Path, object, str]]:
    for announced, sensor in sensors.items():
        if announced in _IGNORED or not isinstance(sensor, dict):
            continue
        probe = text_of(sensor.get("Id"), _MAX_KEY)
        name = announced
        if probe:
            by_address = f"{re.split('[-_]', announced)[0]}-{probe}"  # SetOption64 is the sign between
            if probe not in probes and len(probes) < MAX_SENSORS:
                probes[probe] = by_address if announced in probes.values() else announced
            name = probes.get(probe, by_address)
        for key, value in sensor.items():
            if isinstance(value, dict):
                yield from (((name, key, inner), inner_value, probe) for inner, inner_value in value.items())
            elif isinstance(value, list):
                yield from (((name, key, place), inner_value, probe) for place, inner_value in enumerate(value))
            else:
                yield (name, key), value, probe


def _read(leaf: Leaf, capability: str, message: JsonMessage) -> Readings:
    sensors = sensor_values(message)
    if leaf.probe:
        sensors = {
            str(leaf.path[0]): sensor for sensor in sensors.values() if as_fields(sensor).get("Id") == leaf.probe
        }
    path, value = _at(leaf.path, sensors)
    if not path:
        return NO_READINGS
    if value is None:
        return {capability: None}
    if capability == "value":
        return {capability: clean_text(str(value), _MAX_VALUE)} if isinstance(value, (str, int, float)) else NO_READINGS
    number = finite_number(value)
    if number is None:
        return {capability: None} if is_unknown(value) else unreadable(value, "a number")
    readings = {capability: leaf.quantity.value(number)}
    return read_probe(readings, DS18X20_RESET, DS18X20_GONE) if _DS18X20.match(str(leaf.path[0])) else readings


_DS18X20 = re.compile("DS18[BS]20|DS1822")  # arendst/Tasmota#2168, #5983; DallasTemperature.h, DEVICE_DISCONNECTED_C


def _at(path: Path, message: JsonMessage) -> tuple[bool, object]:
    """Return whether *path* exists, and its value.

    A meter announced with several phases may report only one, which is not a list then.
    """
    value: object = message
    for step in path:
        if isinstance(step, str):
            if not isinstance(value, dict) or step not in value:
                return False, None
            value = value[step]
        elif isinstance(value, list):
            if step >= len(value):
                return False, None
            value = value[step]
        elif step:
            return False, None
    return True, value


def _read_signal(message: JsonMessage) -> Readings:
    signal = finite_number(as_fields(message.get("Wifi")).get("Signal"))
    return NO_READINGS if signal is None else {"signal_strength": signal}
