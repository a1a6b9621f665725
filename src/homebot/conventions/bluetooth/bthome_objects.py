"""The objects of BTHome v2, and the models of Shelly BLU, some of which give an object another meaning. Tables, pure.

Source: https://bthome.io/format, tables of sensors, binary sensors, events, device information and miscellaneous data;
Shelly BLU, Common, table of models; BluTRV and Ecowitt WS90, tables of BTHome objects.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, NamedTuple


@dataclass(frozen=True, slots=True)
class BTHomeObject:
    """The meaning of one object id.

    Attributes:
        name: The property, for example ``temperature``; several ids may have the same.
        capability: Its capability in the vocabulary; empty for objects that are no value of a part.
        size: Bytes of its data; 0 if the first byte of the data is their number.
        factor: By which the number is multiplied, as text, so that no digit is lost: ``0.01``.
        unit: The unit of the product, where the vocabulary has none for the capability.
        is_diagnostic: Whether it is an observation of the device itself.
        is_inverted: Whether true is false in the vocabulary.
    """

    name: str
    capability: str
    size: int = 1
    signed: bool = False
    factor: str = "1"
    unit: str = ""
    is_diagnostic: bool = False
    is_inverted: bool = False


PACKET_ID = 0x00
BUTTON = 0x3A
COMMAND = 0x3B
DIMMER = 0x3C
TIMESTAMP = 0x50
TEXT = 0x53
RAW = 0x54
DEVICE_TYPE = 0xF0
FIRMWARE_4 = 0xF1
FIRMWARE_3 = 0xF2

BUTTON_PRESSES: Mapping[int, str] = {
    0x01: "single",
    0x02: "double",
    0x03: "triple",
    0x04: "long",
    0x05: "long_double",
    0x06: "long_triple",
    0x80: "hold",
    0x81: "release",
}
"""Reports of a button, in the words of the vocabulary; 0 is none."""

DIMMER_TURNS: Mapping[int, str] = {0x01: "rotate_left", 0x02: "rotate_right"}
COMMANDS: Mapping[int, str] = {0x00: "off", 0x01: "on", 0x02: "toggle", 0x03: "step_up", 0x04: "step_down"}


def _number(name: str, capability: str, size: int, factor: str = "1", *, signed: bool = False) -> BTHomeObject:
    return BTHomeObject(name, capability, size, signed, factor)


def _measured(name: str, size: int, factor: str = "1", unit: str = "", *, signed: bool = False) -> BTHomeObject:
    return BTHomeObject(name, "measurement", size, signed, factor, unit)


def _flag(name: str, capability: str, *, is_inverted: bool = False) -> BTHomeObject:
    return BTHomeObject(name, capability, is_inverted=is_inverted)


BTHOME_OBJECTS: Mapping[int, BTHomeObject] = {
    PACKET_ID: BTHomeObject("packet_id", ""),
    0x01: BTHomeObject("battery", "battery", is_diagnostic=True),
    0x02: _number("temperature", "temperature", 2, "0.01", signed=True),
    0x03: _number("humidity", "humidity", 2, "0.01"),
    0x04: _number("pressure", "pressure", 3, "0.01"),
    0x05: _number("illuminance", "illuminance", 3, "0.01"),
    0x06: _measured("mass", 2, "0.01", "kg"),
    0x07: _measured("mass_lb", 2, "0.01", "lb"),
    0x08: _number("dew_point", "temperature", 2, "0.01", signed=True),
    0x09: _measured("count", 1),
    0x0A: _number("energy", "energy", 3, "0.001"),
    0x0B: _number("power", "power", 3, "0.01"),
    0x0C: _number("voltage", "voltage", 2, "0.001"),
    0x0D: _number("pm25", "pm25", 2),
    0x0E: _number("pm10", "pm10", 2),
    0x0F: _flag("generic", "state"),
    0x10: _flag("power_detected", "power_detected"),
    0x11: _flag("opening", "contact"),
    0x12: _number("co2", "carbon_dioxide", 2),
    0x13: _number("tvoc", "volatile_organic_compounds", 2),
    0x14: _number("moisture", "soil_moisture", 2, "0.01"),
    0x15: BTHomeObject("battery_low", "battery_low", is_diagnostic=True),
    0x16: BTHomeObject("battery_charging", "battery_charging", is_diagnostic=True),
    0x17: _flag("carbon_monoxide", "carbon_monoxide_alarm"),
    0x18: _flag("cold", "freeze"),
    0x19: _flag("connectivity", "connectivity"),
    0x1A: _flag("door", "contact"),
    0x1B: _flag("garage_door", "contact"),
    0x1C: _flag("gas_detected", "gas"),
    0x1D: _flag("heat", "heat"),
    0x1E: _flag("light", "light_detected"),
    0x1F: _flag("lock", "unlocked"),
    0x20: _flag("water_leak", "water_leak"),
    0x21: _flag("motion", "occupancy"),
    0x22: _flag("moving", "moving"),
    0x23: _flag("occupancy", "occupancy"),
    0x24: _flag("plug", "plugged_in"),
    0x25: _flag("presence", "occupancy"),
    0x26: _flag("problem", "problem"),
    0x27: _flag("running", "running"),
    0x28: _flag("safety", "safety", is_inverted=True),  # 1 is safe
    0x29: _flag("smoke", "smoke"),
    0x2A: _flag("sound", "sound"),
    0x2B: _flag("tamper", "tamper"),
    0x2C: _flag("vibration", "vibration"),
    0x2D: _flag("window", "contact"),
    0x2E: _number("humidity", "humidity", 1),
    0x2F: _number("moisture", "soil_moisture", 1),
    BUTTON: BTHomeObject("button", "press"),
    COMMAND: BTHomeObject("command", "press", size=0),
    DIMMER: BTHomeObject("dimmer", "press", size=2),
    0x3D: _measured("count", 2),
    0x3E: _measured("count", 4),
    0x3F: _measured("rotation", 2, "0.1", "°", signed=True),
    0x40: _measured("distance_mm", 2, "1", "mm"),
    0x41: _measured("distance", 2, "0.1", "m"),
    0x42: _measured("duration", 3, "0.001", "s"),
    0x43: _number("current", "current", 2, "0.001"),
    0x44: _measured("speed", 2, "0.01", "m/s"),
    0x45: _number("temperature", "temperature", 2, "0.1", signed=True),
    0x46: _measured("uv_index", 1, "0.1"),
    0x47: _measured("volume", 2, "0.1", "L"),
    0x48: _measured("volume_ml", 2, "1", "mL"),
    0x49: _number("volume_flow_rate", "flow", 2, "0.001"),
    0x4A: _number("voltage", "voltage", 2, "0.1"),
    0x4B: _measured("gas", 3, "0.001", "m³"),
    0x4C: _measured("gas", 4, "0.001", "m³"),
    0x4D: _number("energy", "energy", 4, "0.001"),
    0x4E: _measured("volume", 4, "0.001", "L"),
    0x4F: _measured("water", 4, "0.001", "L"),
    TIMESTAMP: BTHomeObject("timestamp", "value", size=4, is_diagnostic=True),
    0x51: _measured("acceleration", 2, "0.001", "m/s²"),
    0x52: _measured("gyroscope", 2, "0.001", "°/s"),
    TEXT: BTHomeObject("text", "value", size=0),
    RAW: BTHomeObject("raw", "raw", size=0, is_diagnostic=True),
    0x55: _measured("volume_storage", 4, "0.001", "L"),
    0x56: _measured("conductivity", 2, "1", "µS/cm"),
    0x57: _number("temperature", "temperature", 1, signed=True),
    0x58: _number("temperature", "temperature", 1, "0.35", signed=True),
    0x59: _measured("count", 1, signed=True),
    0x5A: _measured("count", 2, signed=True),
    0x5B: _measured("count", 4, signed=True),
    0x5C: _number("power", "power", 4, "0.01", signed=True),
    0x5D: _number("current", "current", 2, "0.001", signed=True),
    0x5E: _measured("direction", 2, "0.01", "°"),
    0x5F: _measured("precipitation", 2, "0.1", "mm"),
    0x60: BTHomeObject("channel", "measurement", is_diagnostic=True),
    0x61: _measured("rotational_speed", 2, "1", "rpm"),
    0x62: _measured("speed", 4, "0.000001", "m/s", signed=True),
    0x63: _measured("acceleration", 4, "0.000001", "m/s²", signed=True),
    0x64: _measured("light_level", 1),
    0x65: BTHomeObject("settings_revision", "measurement", is_diagnostic=True),
    DEVICE_TYPE: BTHomeObject("device_type", "", size=2),
    FIRMWARE_4: BTHomeObject("firmware", "", size=4),
    FIRMWARE_3: BTHomeObject("firmware", "", size=3),
}
"""Every object id of BTHome v2."""


class BluModel(NamedTuple):
    """A model.

    Attributes:
        code: The name that it advertises.
        keys: Number of its buttons.
        has_wheel: Whether it can be turned.
        objects: Its objects with another meaning, by their usual part.
    """

    code: str
    name: str
    keys: int = 1
    has_wheel: bool = False
    objects: Mapping[str, BTHomeObject] = MappingProxyType({})

    def name_at(self, address: str) -> str:
        """Return the name of a device with that *address* that has no other."""
        return f"{self.name} {address[-5:].replace(':', '').upper()}"

    @property
    def facts(self) -> dict[str, str]:
        """Facts of its devices; none for an unknown model."""
        return {"manufacturer": "Shelly", "model": self.name, "model_id": self.code} if self.code else {}


_VALVE: Final = {
    "temperature": BTHomeObject("target_temperature", "heating_setpoint"),
    "temperature_2": BTHOME_OBJECTS[0x02],
    "temperature_3": BTHomeObject("external_temperature", "temperature"),
}
_WEATHER: Final = {"water_leak": BTHomeObject("rain", "state")}

MODELS: Final[Mapping[int, BluModel]] = {
    1: BluModel("SBBT-002C", "BLU Button1"),
    2: BluModel("SBDW-002C", "BLU Door/Window", keys=0),
    3: BluModel("SBHT-003C", "BLU H&T"),
    4: BluModel("SBDI-003E", "BLU Distance"),
    5: BluModel("SBMO-003Z", "BLU Motion"),
    6: BluModel("SBBT-004CEU", "BLU Wall Switch 4", keys=4),
    7: BluModel("SBBT-004CUS", "BLU RC Button 4", keys=4),
    8: BluModel("SBTR-001AEU", "BLU TRV", keys=0, objects=_VALVE),
    9: BluModel("SBRC-005B", "BLU Remote", keys=2, has_wheel=True),
    11: BluModel("SBWS-90CM", "Ecowitt WS90", keys=0, objects=_WEATHER),
    12: BluModel("SBHT-103C", "BLU H&T Display ZB"),
    17: BluModel("SBHT-203C", "BLU H&T ZB"),
    19: BluModel("SBMO-103Z", "BLU Motion ZB"),
    20: BluModel("SBDW-103C", "BLU Door/Window ZB", keys=0),
    21: BluModel("SBBT-104CEU", "BLU Wall Switch 4 ZB", keys=4),
    22: BluModel("SBBT-104CUS", "BLU RC Button 4 ZB", keys=4),
    23: BluModel("SBBT-102C", "BLU Button Tough 1 ZB"),
}
"""By the number of the model in its broadcasts."""

_OTHER: Final = BluModel("", "Bluetooth device")
_BY_CODE: Final = {model.code: model for model in MODELS.values()}


def model_called(code: str) -> BluModel:
    """Return the model that advertises the name *code*; one without a code if it is unknown."""
    return _BY_CODE.get(code, _OTHER)


TAGS: Mapping[str, str] = {"door": "door", "window": "window", "garage_door": "garage_door", "presence": "presence"}
"""Tags of parts, by the name of their object."""
