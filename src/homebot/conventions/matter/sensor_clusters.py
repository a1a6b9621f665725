"""The clusters that only report: measurements, conditions, alarms and batteries. Pure.

Source: Matter 1.4 Application Clusters, chapter 2 (measurement and sensing); Core Specification, 11.7 (Power Source).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Final, TypeAlias

from homebot.conventions.matter.endpoint import MatterAbility, MatterEndpoint
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.support.numbers import finite_number

__all__ = ["BATTERY", "sensor_abilities"]

_Convert: TypeAlias = Callable[[float], float | None]

BATTERY: Final = "battery"
"""The part of an endpoint that is its battery."""

BOOLEAN_STATE, POWER_SOURCE, PRESSURE, ENERGY = 69, 47, 1027, 145
_EVE: Final = 0x130AFC01
"""The cluster of Eve's plugs, older than that of the specification; the server reads it in turns."""

_CONTACT, _FREEZE, _LEAK, _RAIN = 0x0015, 0x0041, 0x0043, 0x0044


def _scaled(factor: float, least: float = -1e12, most: float = 1e12) -> _Convert:
    return lambda raw: round(raw / factor, 6) if least <= raw <= most else None


def _lux(raw: float) -> float | None:
    if raw == 0:
        return 0.0  # too dark to be measured
    return round(10 ** ((raw - 1) / 10_000), 2) if 0 < raw <= 65_534 else None


_MEASURED: Final[Mapping[tuple[int, int], tuple[str, _Convert]]] = {
    (1024, 0): ("illuminance", _lux),
    (1026, 0): ("temperature", _scaled(100, -27_315, 32_767)),
    (1028, 0): ("flow", _scaled(10, 0, 65_534)),
    (1029, 0): ("humidity", _scaled(100, 0, 10_000)),
    (1072, 1): ("soil_moisture", _scaled(1, 0, 100)),
    (144, 4): ("voltage", _scaled(1000)),
    (144, 5): ("current", _scaled(1000)),
    (144, 11): ("voltage", _scaled(1000)),  # of alternating current, where there is no other
    (144, 12): ("current", _scaled(1000)),
    (144, 8): ("power", _scaled(1000)),
    (144, 14): ("frequency", _scaled(1000)),
    (_EVE, 0x130A0008): ("voltage", _scaled(1)),
    (_EVE, 0x130A0009): ("current", _scaled(1)),
    (_EVE, 0x130A000A): ("power", _scaled(1)),
    (_EVE, 0x130A000B): ("energy", _scaled(1)),
    (91, 0): ("air_quality_index", lambda raw: raw if 1 <= raw <= 6 else None),
}
"""Numbers by cluster and attribute."""

ZIGBEE_METER: Final = 0x0B04
_MULTIPLIED: Final = {
    "voltage": (0x505, 0x600, 0x601),
    "current": (0x508, 0x602, 0x603),
    "power": (0x50B, 0x604, 0x605),
}
"""Of the cluster that Matter took over from Zigbee before it had its own: the attributes of value, multiplier and
divisor."""

_PER_MILLION: Final = {0: 1.0, 1: 1e-3, 2: 1e-6}
_MICROGRAMS: Final = {3: 1000.0, 4: 1.0, 5: 1e-3}
_CONCENTRATIONS: Final[Mapping[int, tuple[str, Mapping[int, float]]]] = {
    1036: ("carbon_monoxide", _PER_MILLION),
    1037: ("carbon_dioxide", _PER_MILLION),
    1066: ("pm25", _MICROGRAMS),
    1068: ("pm1", _MICROGRAMS),
    1069: ("pm10", _MICROGRAMS),
    1070: ("volatile_organic_compounds", _MICROGRAMS),
}
"""By cluster: the measured quantity, and the factors of the units that can be converted."""

_PLAIN: Final = {1043: "nitrogen_dioxide", 1045: "ozone", 1067: "formaldehyde", 1071: "radon"}
"""Clusters without a capability in the vocabulary: the measurements of parts beside the air's quality."""

_UNITS: Final = ("ppm", "ppb", "ppt", "mg/m³", "µg/m³", "ng/m³", "1/m³", "Bq/m³")
_CONCENTRATION, _UNIT = 0, 8
_ORGANIC: Final = 1070
_PARTS: Final = {0: "ppm", 1: "ppb", 2: "ppt"}
"""Units of a mixture of gases that no factor makes micrograms: it is a plain measurement."""

_ALARMS: Final[Mapping[tuple[int, int], str]] = {(92, 1): "smoke", (92, 2): "carbon_monoxide_alarm"}
_FLAGS: Final[Mapping[tuple[int, int], str]] = {(92, 6): "problem"}
_BATTERY_PERCENT, _BATTERY_LEVEL, _BATTERY_CHARGE = 12, 14, 26
_HAS_BATTERY: Final = 1 << 1
_IMPORTED, _EXPORTED = 1, 2
_SCALED_PRESSURE, _SCALE = 16, 20


def sensor_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield the measurements and alarms of the endpoint."""
    for (cluster, attribute), (name, convert) in _MEASURED.items():
        if endpoint.has(cluster, attribute):
            yield MatterAbility(cluster, Capability(name=name), partial(_read_number, cluster, attribute, convert))
    for name, attributes in _MULTIPLIED.items():
        if endpoint.has(ZIGBEE_METER, attributes[0]):
            yield MatterAbility(ZIGBEE_METER, Capability(name=name), partial(_read_multiplied, *attributes))
    if endpoint.has(PRESSURE, 0):
        yield MatterAbility(PRESSURE, Capability(name="pressure"), _read_pressure)
    yield from _concentrations(endpoint)
    for name, attribute in (("energy", _IMPORTED), ("energy_returned", _EXPORTED)):
        if endpoint.has(ENERGY, attribute):
            yield MatterAbility(ENERGY, Capability(name=name), partial(_read_energy, attribute))
    yield from _conditions(endpoint)
    yield from _battery_abilities(endpoint)


def _concentrations(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    for cluster, (name, factors) in _CONCENTRATIONS.items():
        unit = endpoint.whole(cluster, _UNIT)
        if endpoint.has(cluster, _CONCENTRATION) and unit is not None and unit in factors:
            read = partial(_read_number, cluster, _CONCENTRATION, _scaled(1 / factors[unit], 0))
            yield MatterAbility(cluster, Capability(name=name), read)
    unit = endpoint.whole(_ORGANIC, _UNIT)
    if endpoint.has(_ORGANIC, _CONCENTRATION) and unit is not None and unit in _PARTS:
        read = partial(_read_number, _ORGANIC, _CONCENTRATION, _scaled(1, 0))
        yield MatterAbility(_ORGANIC, Capability(name="measurement", unit=_PARTS[unit]), read)
    for cluster, name in _PLAIN.items():
        unit = endpoint.whole(cluster, _UNIT)
        if endpoint.has(cluster, _CONCENTRATION) and unit is not None and 0 <= unit < len(_UNITS):
            read = partial(_read_number, cluster, _CONCENTRATION, _scaled(1, 0))
            yield MatterAbility(cluster, Capability(name="measurement", unit=_UNITS[unit]), read, beside=name)


def _conditions(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    if endpoint.has(BOOLEAN_STATE, 0):
        name, means = _boolean_state(endpoint)
        read = partial(_read_flag, BOOLEAN_STATE, 0, means=means)
        yield MatterAbility(BOOLEAN_STATE, Capability(name=name), read)
    if endpoint.has(1030, 0):
        yield MatterAbility(1030, Capability(name="occupancy"), _read_occupancy)
    for (cluster, attribute), name in _ALARMS.items():
        if endpoint.has(cluster, attribute):
            yield MatterAbility(cluster, Capability(name=name), partial(_read_alarm, cluster, attribute))
    for (cluster, attribute), name in _FLAGS.items():
        if endpoint.has(cluster, attribute):
            yield MatterAbility(cluster, Capability(name=name), partial(_read_flag, cluster, attribute))


def _battery_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    if not endpoint.features(POWER_SOURCE) & _HAS_BATTERY:
        return
    readers: dict[int, tuple[str, Callable[[MatterEndpoint], PlainValue]]] = {
        _BATTERY_PERCENT: ("battery", partial(_read_number, POWER_SOURCE, _BATTERY_PERCENT, _scaled(2, 0, 200))),
        _BATTERY_LEVEL: ("battery_low", _read_battery_low),
        _BATTERY_CHARGE: ("battery_charging", _read_charging),
    }
    for attribute, (name, read) in readers.items():
        if endpoint.has(POWER_SOURCE, attribute):
            yield MatterAbility(POWER_SOURCE, Capability(name=name), read, beside=BATTERY)


def _boolean_state(endpoint: MatterEndpoint) -> tuple[str, bool]:
    """Return the subject of an endpoint's state, and the value that means yes."""
    types = endpoint.device_types
    for number, found in ((_LEAK, "water_leak"), (_RAIN, "rain"), (_FREEZE, "freeze")):
        if number in types:
            return found, True
    return ("contact", False) if _CONTACT in types else ("state", True)  # a contact is true while it is closed


def _read_number(cluster: int, attribute: int, convert: _Convert, endpoint: MatterEndpoint) -> PlainValue:
    raw = endpoint.number(cluster, attribute)
    return None if raw is None else convert(raw)


def _read_multiplied(attribute: int, multiplier: int, divisor: int, endpoint: MatterEndpoint) -> PlainValue:
    raw = endpoint.number(ZIGBEE_METER, attribute)
    if raw is None or not -32_767 <= raw <= 65_534:
        return None
    by, through = endpoint.number(ZIGBEE_METER, multiplier), endpoint.number(ZIGBEE_METER, divisor)
    return round(raw * (by or 1) / (through or 1), 6)


def _read_flag(cluster: int, attribute: int, endpoint: MatterEndpoint, *, means: bool = True) -> PlainValue:
    value = endpoint.flag(cluster, attribute)
    return None if value is None else value is means


def _read_alarm(cluster: int, attribute: int, endpoint: MatterEndpoint) -> PlainValue:
    state = endpoint.whole(cluster, attribute)
    return None if state is None else state in {1, 2}


def _read_occupancy(endpoint: MatterEndpoint) -> PlainValue:
    bits = endpoint.whole(1030, 0)
    return None if bits is None else bool(bits & 1)


def _read_pressure(endpoint: MatterEndpoint) -> PlainValue:
    scaled, scale = endpoint.number(PRESSURE, _SCALED_PRESSURE), endpoint.number(PRESSURE, _SCALE)
    if scaled is not None and scale is not None and abs(scaled) <= 32_767 and abs(scale) <= 127:
        return round(scaled / 10**scale / 100, 4) if scale >= -20 else None
    kilopascal = endpoint.number(PRESSURE, 0)
    return kilopascal if kilopascal is not None and abs(kilopascal) <= 32_767 else None  # in tenths: hectopascal


def _read_energy(attribute: int, endpoint: MatterEndpoint) -> PlainValue:
    measured = endpoint.value(ENERGY, attribute)
    if not isinstance(measured, dict):
        return None
    milliwatt_hours = finite_number(measured.get("0", measured.get("energy")))
    return None if milliwatt_hours is None else round(milliwatt_hours / 1e6, 6)


def _read_battery_low(endpoint: MatterEndpoint) -> PlainValue:
    level = endpoint.whole(POWER_SOURCE, _BATTERY_LEVEL)
    return None if level is None else level in {1, 2}


def _read_charging(endpoint: MatterEndpoint) -> PlainValue:
    charge = endpoint.whole(POWER_SOURCE, _BATTERY_CHARGE)
    return None if charge is None or charge == 0 else charge == 1
