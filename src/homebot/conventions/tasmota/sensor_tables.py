"""Names of Tasmota's sensor values, and our capabilities for them: tables. Pure.

Source: hatasmota 0.10.2, ``sensor.py``; Home Assistant core 2025.4, ``components/tasmota/sensor.py``.
"""

from __future__ import annotations

from collections.abc import Mapping

from homebot.conventions.units import Conversion, Quantity, conversion_of

__all__ = ["quantity_of"]


def quantity_of(path: tuple[str | int, ...], sensors: Mapping[str, object]) -> Quantity:
    """Return what the value at *path* is; a plain measurement where its name is not known.

    Args:
        path: Sensor, name, and at times an index or an inner name.
        sensors: The device's message, which also tells the units of temperature and pressure.
    """
    sensor, name = str(path[0]), str(path[1])
    inner = path[2] if len(path) > _SHORTEST else None
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


_SHORTEST = 2
_OTHER_ENERGY = frozenset({"AS3935", "LD2410"})
"""Sensors whose energy is that of lightning or of a radar's echo."""

_AIR = "air_quality_sensor"
_PLAIN = Quantity("x_sensor", "measurement")
_ENERGY = Quantity("electrical_meter", "energy")
_CURRENT = Quantity("electrical_meter", "current")
_POWER = Quantity("electrical_meter", "power")
_LIGHT = Quantity("light_sensor", "illuminance")


def _converted(service_type: str, capability: str, unit: str) -> Quantity:
    return Quantity(service_type, capability, "", conversion_of(capability, unit) or Conversion())


def _plain(unit: str) -> Quantity:
    return Quantity("x_sensor", "measurement", unit)


_KNOWN: Mapping[str, Quantity] = {
    "ActivePower": _POWER,
    "Ambient": _LIGHT,
    "ApparentPower": _plain("VA"),
    "Battery": Quantity("x_battery", "battery"),
    "CarbonDioxide": Quantity(_AIR, "carbon_dioxide"),
    "CCT": _plain("K"),
    "CF1": _plain("µg/m³"),
    "CF10": _plain("µg/m³"),
    "CF2.5": _plain("µg/m³"),
    "Current": _CURRENT,
    "CurrentNeutral": _CURRENT,
    "Distance": _plain("cm"),
    "eCO2": _plain("ppm"),
    "Energy": _ENERGY,
    "ExportActive": _ENERGY,
    "ExportReactive": _plain("kvarh"),
    "ExportTariff": _ENERGY,
    "Frequency": Quantity("electrical_meter", "frequency"),
    "Humidity": Quantity("humidity_sensor", "humidity"),
    "Illuminance": _LIGHT,
    "ImportActive": _ENERGY,
    "ImportReactive": _plain("kvarh"),
    "Moisture": Quantity("soil_sensor", "soil_moisture"),
    "PhaseAngle": _plain("°"),
    "PM1": Quantity(_AIR, "pm1"),
    "PM10": Quantity(_AIR, "pm10"),
    "PM2.5": Quantity(_AIR, "pm25"),
    "Power": _POWER,
    "ReactivePower": _plain("var"),
    "Today": _ENERGY,
    "Total": _ENERGY,
    "TotalTariff": _ENERGY,
    "TVOC": _plain("ppb"),
    "Voltage": Quantity("electrical_meter", "voltage"),
    "Weight": _plain("kg"),
    "Yesterday": _ENERGY,
}

_TEMPERATURES: Mapping[str, Quantity] = {
    "C": Quantity("temperature_sensor", "temperature"),
    "F": _converted("temperature_sensor", "temperature", "°F"),
}
_PRESSURES: Mapping[str, Quantity] = {
    "hPa": Quantity("pressure_sensor", "pressure"),
    "mmHg": _converted("pressure_sensor", "pressure", "mmHg"),
}
_SPEEDS: Mapping[str, Quantity] = {unit: _plain(unit) for unit in ("m/s", "km/h", "kn", "mph", "ft/s", "yd/s")}

_WITH_UNITS: Mapping[str, tuple[str, Mapping[str, Quantity]]] = {
    "DewPoint": ("TempUnit", _TEMPERATURES),
    "Temperature": ("TempUnit", _TEMPERATURES),
    "Pressure": ("PressureUnit", _PRESSURES),
    "SeaPressure": ("PressureUnit", _PRESSURES),
    "Speed": ("SpeedUnit", _SPEEDS),
}
"""Names whose unit stands beside them in the message, under which key, and what they are then."""
