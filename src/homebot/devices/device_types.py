"""The service types of the vocabulary: Matter's device types, and other words that people use for them.

Source: Matter 1.6 device library. Types that are not in Matter begin with ``x_``.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class DeviceType(NamedTuple):
    """The type of a part.

    Attributes:
        matter: Numbers of the corresponding Matter device types; empty if Matter has none.
        words: Other words that find it, in the singular.
    """

    name: str
    matter: tuple[int, ...] = ()
    words: tuple[str, ...] = ()


_TYPES = (
    DeviceType("closure", (0x0230,), ("opener", "gate", "garage door", "door", "window", "damper")),
    DeviceType("door_lock", (0x000A,), ("lock",)),
    DeviceType("x_lift", (), ("lift", "elevator", "stair lift", "stairlift")),
    DeviceType("light", (0x0100, 0x0101, 0x010C, 0x010D), ("lamp", "bulb", "luminaire", "lighting")),
    DeviceType(
        "window_covering",
        (0x0202,),
        ("cover", "covering", "blind", "shade", "shutter", "curtain", "awning", "roller", "window"),
    ),
    DeviceType("thermostat", (0x0301,), ("climate", "heating", "radiator", "radiator valve", "trv")),
    DeviceType("room_air_conditioner", (0x0072, 0x0309), ("air conditioner", "ac", "climate", "heat pump")),
    DeviceType("fan", (0x002B, 0x002D, 0x007A), ("air purifier", "extractor hood", "ventilator")),
    DeviceType("water_valve", (0x0042,), ("valve",)),
    DeviceType("robotic_vacuum_cleaner", (0x0074,), ("vacuum", "vacuum cleaner", "robot vacuum")),
    DeviceType("water_heater", (0x050F,), ("boiler",)),
    DeviceType("pump", (0x0303,)),
    DeviceType("x_humidifier", (), ("humidifier", "dehumidifier")),
    DeviceType("x_lawn_mower", (), ("mower", "lawn mower")),
    DeviceType("x_alarm_panel", (), ("alarm", "alarm panel")),
    DeviceType("camera", (0x0142,)),
    DeviceType("siren", (0x0146,), ("chime", "alarm siren")),
    DeviceType("plug", (0x010A, 0x010B), ("outlet", "socket", "smart plug")),
    DeviceType("switch", (0x010F, 0x0110), ("relay",)),
    DeviceType("contact_sensor", (0x0015,), ("contact", "opening sensor", "door", "window", "garage door")),
    DeviceType("occupancy_sensor", (0x0107,), ("motion", "occupancy", "presence", "motion sensor", "presence sensor")),
    DeviceType("smoke_co_alarm", (0x0076,), ("smoke", "smoke alarm", "smoke detector", "co alarm")),
    DeviceType("water_leak_detector", (0x0043,), ("leak", "water leak", "flood", "leak sensor")),
    DeviceType("rain_sensor", (0x0044,), ("rain",)),
    DeviceType("water_freeze_detector", (0x0041,), ("freeze",)),
    DeviceType("air_quality_sensor", (0x002C,), ("air quality",)),
    DeviceType("soil_sensor", (0x0045,), ("soil",)),
    DeviceType("temperature_sensor", (0x0302,), ("temperature", "thermometer")),
    DeviceType("humidity_sensor", (0x0307,), ("humidity", "hygrometer")),
    DeviceType("light_sensor", (0x0106,), ("illuminance", "light level", "lux")),
    DeviceType("pressure_sensor", (0x0305,), ("pressure", "barometer")),
    DeviceType("flow_sensor", (0x0306,), ("flow",)),
    DeviceType("generic_switch", (0x000F, 0x0148), ("button", "remote", "doorbell")),
    DeviceType("electrical_meter", (0x0514, 0x0510), ("power meter", "energy meter", "meter")),
    DeviceType("speaker", (0x0022,), ("loudspeaker",)),
    DeviceType("video_player", (0x0028,), ("tv", "television")),
    DeviceType("x_scene", (), ("scene",)),
    DeviceType("x_robot", (), ("robot",)),
    DeviceType("x_person", (), ("person", "people")),
    DeviceType("x_household", (), ("household", "family")),
    DeviceType("x_tracker", (), ("tracker", "device tracker")),
    DeviceType("x_tag", (), ("tag", "nfc tag", "rfid tag")),
    DeviceType("x_tag_reader", (), ("tag reader", "nfc reader", "rfid reader")),
    DeviceType("x_battery", (), ("battery",)),
    DeviceType("x_sensor", (), ("sensor",)),
    DeviceType("x_binary_sensor", (), ("binary sensor",)),
    DeviceType("x_setting", (), ("setting", "select", "number", "text")),
    DeviceType("x_update", (), ("update", "firmware")),
    DeviceType("x_unknown", (), ("unknown",)),
)

DEVICE_TYPES: Mapping[str, DeviceType] = MappingProxyType({row.name: row for row in _TYPES})
"""Every device type by name, in the order in which the type of a part becomes that of its device.

A garage door may have a lamp, and an air conditioner a thermometer and switches for its functions.
"""

CAN_HURT = frozenset(
    {
        "closure",
        "door_lock",
        "pump",
        "room_air_conditioner",
        "thermostat",
        "water_heater",
        "water_valve",
        "x_alarm_panel",
        "x_lawn_mower",
        "x_lift",
        "x_robot",
    }
)
"""Types of devices that open, flood, heat or hurt if a command is wrong or not obeyed."""


def spoken_type(name: str) -> str:
    """Return a type as people say it, for sentences: ``an alarm panel``."""
    spoken = name.removeprefix("x_").replace("_", " ")
    return f"{'an' if spoken[:1] in 'aeiou' else 'a'} {spoken}"


def wanted_types(word: str) -> frozenset[str]:
    """Return the device types that *word* may mean: ``light``, ``lights`` and ``lamp`` mean one, ``window`` three.

    Case and number do not matter, and ``_`` and ``-`` are blanks. Empty for a word without a type.
    """
    spelled = " ".join(word.casefold().replace("_", " ").replace("-", " ").split())
    for form in (spelled, *_singulars(spelled)):
        if form in _BY_WORD:
            return _BY_WORD[form]
    return frozenset()


def _singulars(word: str) -> tuple[str, ...]:
    endings = (("ies", "y"), ("es", ""), ("s", ""))
    return tuple(word.removesuffix(plural) + singular for plural, singular in endings if word.endswith(plural))


def _index() -> Mapping[str, frozenset[str]]:
    names_by_word: dict[str, set[str]] = {}
    for row in _TYPES:
        for word in (row.name.removeprefix("x_").replace("_", " "), row.name.replace("_", " "), *row.words):
            names_by_word.setdefault(word, set()).add(row.name)
    return MappingProxyType({word: frozenset(names) for word, names in names_by_word.items()})


_BY_WORD = _index()
