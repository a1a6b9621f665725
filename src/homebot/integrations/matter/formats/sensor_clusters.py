"""The clusters that only report: measurements, conditions, alarms, batteries and buttons; and Identify. Pure.

Source: Matter 1.4 Application Clusters, 1.2 (Identify), 1.13 (Switch), chapter 2 (measurement and sensing); Core
Specification, 11.7 (Power Source).
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Final

from homebot.conventions.payload import as_fields
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.integrations.matter.formats.cluster_row import (
    ClusterRow,
    any_bit,
    choice,
    choice_row,
    cluster_row,
    flag,
    number,
    number_writer,
    one_of,
)
from homebot.integrations.matter.formats.endpoint import (
    ClusterInvocation,
    MatterEndpoint,
    MatterOrders,
    field_of,
)
from homebot.support.numbers import finite_number, whole_number

BATTERY: Final = "battery"
"""The part of an endpoint that is its battery."""

POWER_SOURCE, BOOLEAN_STATE, ALARM, AIR_QUALITY, ELECTRICAL, ENERGY = 47, 69, 92, 91, 144, 145
LIGHT, TEMPERATURE, PRESSURE, FLOW, HUMIDITY, OCCUPANCY, SOIL = 1024, 1026, 1027, 1028, 1029, 1030, 1072
ZIGBEE_METER: Final = 0x0B04
EVE: Final = 0x130AFC01
"""The cluster of Eve, with what the specification did not have yet, or has not; the server reads it in turns."""

_OF_MAKERS: Final[Mapping[int, Mapping[int, tuple[str, float]]]] = {
    EVE: {
        0x130A0008: ("voltage", 1),
        0x130A0009: ("current", 1),
        0x130A000A: ("power", 1),
        0x130A000B: ("energy", 1),
        0x130A0014: ("pressure", 1),
    },
    0x125DFC11: {  # Neo
        0x125D0021: ("energy", 1000),
        0x125D0022: ("current", 1000),
        0x125D0023: ("power", 10),
        0x125D0024: ("voltage", 10),
    },
    0x130DFC02: {0: ("energy", 1e6), 0x0400: ("power", 1000)},  # Third Reality
}
"""Clusters of makers: the capability of each attribute, with the divisor of its numbers; as Home Assistant core 2025.11
reads them."""

_FILTERS: Final = {113: "dust_filter", 114: "carbon_filter"}

_BOOLEAN_STATES: Final = {0x0043: "water_leak", 0x0044: "rain", 0x0041: "freeze", 0x0015: "contact"}
"""By device type: the meaning of Boolean State; a contact is true while it is closed."""

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

PLAIN: Final = {1043: "nitrogen_dioxide", 1045: "ozone", 1067: "formaldehyde", 1071: "radon"}
"""Clusters without a capability in the vocabulary: the measurements of parts beside the air's quality."""

_UNITS: Final = ("ppm", "ppb", "ppt", "mg/m³", "µg/m³", "ng/m³", "1/m³", "Bq/m³")
_CONCENTRATION, _UNIT = 0, 8
_ORGANIC: Final = 1070
_SCALED_PRESSURE, _SCALE = 16, 20
_HOLD, _HOLD_LIMITS = 3, 4
SENSITIVITY, _MAX_LEVELS = 128, 10
_HAS_BATTERY: Final = 1 << 1
_CHARGING: Final = {1: True, 2: False, 3: False}
_FAULT, _END_OF_SERVICE, _EXPIRED = 6, 7, 1


def _read_lux(_at: MatterEndpoint, raw: object) -> PlainValue:
    value = finite_number(raw)
    if value == 0:
        return 0.0  # too dark to be measured
    return round(10 ** ((value - 1) / 10_000), 2) if value is not None and 0 < value <= 65_534 else None


def _read_energy(_at: MatterEndpoint, raw: object) -> PlainValue:
    milliwatt_hours = finite_number(field_of(as_fields(raw), 0, "energy"))
    return None if milliwatt_hours is None else round(milliwatt_hours / 1e6, 6)


def _read_fault(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    is_faulty = endpoint.flag(ALARM, _FAULT)
    return None if is_faulty is None else is_faulty or endpoint.whole(ALARM, _END_OF_SERVICE) == _EXPIRED


def _read_multiplied(multiplier: int, divisor: int, endpoint: MatterEndpoint, raw: object) -> PlainValue:
    value = finite_number(raw)
    by, through = endpoint.number(ZIGBEE_METER, multiplier), endpoint.number(ZIGBEE_METER, divisor)
    if value is None or not -32_767 <= value <= 65_534:
        return None
    return round(value * (by or 1) / (through or 1), 6)


def _read_pressure(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    scaled = endpoint.number(PRESSURE, _SCALED_PRESSURE, -32_767, 32_767)
    scale = endpoint.number(PRESSURE, _SCALE, -127, 127)
    if scaled is not None and scale is not None:
        return round(scaled / 10**scale / 100, 4) if scale >= -20 else None
    return endpoint.number(PRESSURE, 0, -32_767, 32_767)  # tenths of kilopascals: hectopascals


def _hold_bounds(endpoint: MatterEndpoint) -> tuple[float, float]:
    limits = as_fields(endpoint.value(OCCUPANCY, _HOLD_LIMITS))
    least, most = (finite_number(field_of(limits, *field)) for field in enumerate(("holdTimeMin", "holdTimeMax")))
    return (least, most) if least is not None and most is not None and least < most else (0.0, 65_535.0)


def _levels(endpoint: MatterEndpoint) -> dict[int, str]:
    return {level: str(level + 1) for level in range(min(endpoint.whole(SENSITIVITY, 1) or 0, _MAX_LEVELS))}


def _unit_of(cluster: int, endpoint: MatterEndpoint) -> int:
    unit = endpoint.whole(cluster, _UNIT)
    return -1 if unit is None else unit


def _concentration(cluster: int, name: str, factors: Mapping[int, float]) -> ClusterRow:
    """Return the row of a concentration in a unit that one of the *factors* converts."""

    def read(endpoint: MatterEndpoint, raw: object) -> PlainValue:
        factor = factors.get(_unit_of(cluster, endpoint))
        return None if factor is None else number(1 / factor, 0)(endpoint, raw)

    return cluster_row(
        cluster, _CONCENTRATION, name, read, when=lambda endpoint: _unit_of(cluster, endpoint) in factors
    )


def _is_boolean_state(name: str, endpoint: MatterEndpoint) -> bool:
    types = endpoint.device_types
    return name == next((meaning for kind, meaning in _BOOLEAN_STATES.items() if kind in types), "state")


def _measurement(cluster: int, units: range, part: str = "") -> ClusterRow:
    """Return the row of a concentration in its own unit, if that is one of the first *units*."""
    return cluster_row(
        cluster,
        _CONCENTRATION,
        "measurement",
        number(1, 0),
        when=lambda endpoint: _unit_of(cluster, endpoint) in units,
        unit=lambda endpoint: _UNITS[_unit_of(cluster, endpoint)],
        part=part,
    )


IDENTIFY, SWITCH = 3, 59

_POSITIONS: Final = 0
_LATCHES, _REPORTS_RELEASE, _REPORTS_LONG, _COUNTS = 1 << 0, 1 << 2, 1 << 3, 1 << 4
_LATCHED, _PRESSED, _LONG, _SHORT_RELEASE, _LONG_RELEASE, _COUNTED = 0, 1, 2, 3, 4, 6
_COUNT_NAMES: Final[Mapping[int | None, str]] = dict(
    enumerate(("single", "double", "triple", "quadruple", *(f"{count} times" for count in range(5, 21))), 1)
)
_POSITION_NAMES: Final[Mapping[int | None, str]] = {position: f"position {position}" for position in range(20)}
_LONG_NAMES: Final = {_LONG: "long", _LONG_RELEASE: "long_release"}
_IDENTIFY_SECONDS: Final = 10


def press_of(endpoint: MatterEndpoint, event: int, data: object) -> str | None:
    """Return the press that an event of the cluster Switch is; None if it is none, or a part of one.

    A switch that counts presses reports them once all are over, others when it is released, or has no release.
    """
    features, fields = endpoint.features(SWITCH), as_fields(data)
    if event == _COUNTED and features & _COUNTS:
        return _COUNT_NAMES.get(whole_number(field_of(fields, 1, "totalNumberOfPressesCounted")))
    if event == _LATCHED and features & _LATCHES:
        return _POSITION_NAMES.get(whole_number(field_of(fields, 0, "newPosition")))
    if event in _LONG_NAMES and features & _REPORTS_LONG:
        return _LONG_NAMES[event]
    if features & (_COUNTS | _LATCHES):
        return None
    return "single" if event == (_SHORT_RELEASE if features & _REPORTS_RELEASE else _PRESSED) else None


def _presses(endpoint: MatterEndpoint) -> tuple[str, ...]:
    features = endpoint.features(SWITCH)
    if features & _LATCHES:
        return tuple(_POSITION_NAMES.values())[: max(endpoint.whole(SWITCH, _POSITIONS) or 2, 2)]
    most = max(endpoint.whole(SWITCH, 2) or 2, 2) if features & _COUNTS else 1
    return (*tuple(_COUNT_NAMES.values())[:most], *(_LONG_NAMES.values() if features & _REPORTS_LONG else ()))


def _write_locate(_at: MatterEndpoint, command: Command) -> MatterOrders:
    seconds = _IDENTIFY_SECONDS if command.value.flag else 0
    return (ClusterInvocation(IDENTIFY, "Identify", {"identifyTime": seconds}),)


SENSOR_ROWS: Final = (
    cluster_row(LIGHT, 0, "illuminance", _read_lux),
    cluster_row(TEMPERATURE, 0, "temperature", number(100, -27_315, 32_767)),
    cluster_row(FLOW, 0, "flow", number(10, 0, 65_534)),
    cluster_row(HUMIDITY, 0, "humidity", number(100, 0, 10_000)),
    cluster_row(SOIL, 1, "soil_moisture", number(1, 0, 100)),
    cluster_row(ELECTRICAL, 4, "voltage", number(1000)),
    cluster_row(ELECTRICAL, 5, "current", number(1000)),
    cluster_row(ELECTRICAL, 11, "voltage", number(1000)),  # of alternating current, if there is no other
    cluster_row(ELECTRICAL, 12, "current", number(1000)),
    cluster_row(ELECTRICAL, 8, "power", number(1000)),
    cluster_row(ELECTRICAL, 14, "frequency", number(1000)),
    *(
        cluster_row(cluster, attribute, name, number(divisor))
        for cluster, attributes in _OF_MAKERS.items()
        for attribute, (name, divisor) in attributes.items()
    ),
    cluster_row(EVE, 0x130A0018, "measurement", number(1, 0, 100), unit="%"),  # how far the valve of a radiator is open
    cluster_row(AIR_QUALITY, 0, "air_quality_index", number(1, 1, 6)),
    # Of the cluster that Matter took over from Zigbee: attributes of value, multiplier and divisor.
    cluster_row(ZIGBEE_METER, 0x505, "voltage", partial(_read_multiplied, 0x600, 0x601)),
    cluster_row(ZIGBEE_METER, 0x508, "current", partial(_read_multiplied, 0x602, 0x603)),
    cluster_row(ZIGBEE_METER, 0x50B, "power", partial(_read_multiplied, 0x604, 0x605)),
    cluster_row(PRESSURE, 0, "pressure", _read_pressure),
    *(_concentration(cluster, name, factors) for cluster, (name, factors) in _CONCENTRATIONS.items()),
    _measurement(_ORGANIC, range(3)),  # parts of a mixture of gases, which no factor makes micrograms
    *(_measurement(cluster, range(len(_UNITS)), name) for cluster, name in PLAIN.items()),
    cluster_row(ENERGY, 1, "energy", _read_energy),
    cluster_row(ENERGY, 2, "energy_returned", _read_energy),
    *(
        cluster_row(BOOLEAN_STATE, 0, name, flag(means=name != "contact"), when=partial(_is_boolean_state, name))
        for name in (*_BOOLEAN_STATES.values(), "state")
    ),
    replace(choice_row(SENSITIVITY, 0, _levels), part="sensitivity"),
    cluster_row(OCCUPANCY, 0, "occupancy", any_bit(1)),
    cluster_row(
        OCCUPANCY,
        _HOLD,
        "number",
        number(1, 0, 65_535),
        number_writer(OCCUPANCY, _HOLD),
        bounds=_hold_bounds,
        unit="s",
        part="hold_time",
    ),
    cluster_row(ALARM, 1, "smoke", one_of(1, 2)),
    cluster_row(ALARM, 2, "carbon_monoxide_alarm", one_of(1, 2)),
    cluster_row(ALARM, _FAULT, "problem", _read_fault),
    *(
        row
        for cluster, name in _FILTERS.items()
        for row in (
            cluster_row(cluster, 0, "measurement", number(1, 0, 100), unit="%", part=name),
            cluster_row(cluster, 2, "problem", one_of(1, 2), part=name),  # it is to be changed soon, or now
        )
    ),
    cluster_row(POWER_SOURCE, 12, "battery", number(2, 0, 200), None, _HAS_BATTERY, part=BATTERY),
    cluster_row(POWER_SOURCE, 14, "battery_low", one_of(1, 2), None, _HAS_BATTERY, part=BATTERY),
    cluster_row(POWER_SOURCE, 26, "battery_charging", choice(_CHARGING), None, _HAS_BATTERY, part=BATTERY),
    cluster_row(SWITCH, _POSITIONS, "press", options=_presses),
    cluster_row(IDENTIFY, 0, "locate", write=_write_locate, when=lambda endpoint: endpoint.whole(IDENTIFY, 1)),
)
