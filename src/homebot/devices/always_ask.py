"""Devices that a person has to allow by name: who commands them by mistake lets somebody in, floods or burns. Pure.

What may drive them is the owner's to approve.

A switch, plug or cover that drives such a device is known by its name, in English or another language, by that of its
model, where that has an English word for it, or by the tag ``always_ask``, which the owner may give to any device; so
is a button, scene or choice by its name, and the setting that says how hot a boiler or an oven becomes.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final

from homebot.devices.device import Device, DevicePart
from homebot.devices.names import OWNER
from homebot.folding import fold, words_of

__all__ = [
    "ALWAYS_ASK",
    "APPROVED",
    "always_asks",
    "is_approved",
    "is_arming",
    "is_declared",
    "is_opener",
    "waits_for_approval",
]

ALWAYS_ASK = frozenset({"closure", "door_lock", "water_heater", "water_valve", "x_alarm_panel"})
"""Device types of the class: garage doors and gates, locks, boilers, valves, alarm panels."""

APPROVED: Final = "approved"
"""The name of the fact by which the owner states that a device that can hurt may be driven."""

_CAPABILITIES = frozenset({"alarm", "contact", "lock", "valve", "water_heater_mode"})
_ARMED = frozenset({"Armed", "armed"})
_OVENS = frozenset({"cooker", "cooktop", "hob", "kiln", "oven", "stove"})
_HEATERS = frozenset({"boiler", "geyser", "sauna"})
_HOT_WATER = (("hot", "water"), ("immersion", "heater"), ("sauna", "heater"), ("water", "heater"))
_ENDINGS_OF_SETTINGS = _HEATERS | frozenset(
    {"deadbolt", "doorlock", "fireplace", "garagedoor", "gate", "gates", "valve", "valves"}
)
_ENDINGS = _ENDINGS_OF_SETTINGS | frozenset({"lock", "locks"})
_SCALDING = 100.0
"""Degrees Celsius that no room and no radiator has to have, but saunas, grills and kilns."""

_DEGREES = frozenset({"°C", "°F", "K"})
_RELAYS = frozenset({"plug", "switch", "window_covering", "x_unknown"})
_HARMLESS = frozenset({"light"})
_VALVES = frozenset({"irrigation", "valve", "valves"})
_MOVED_BY_OPENERS = frozenset({"door", "garage", "gate"})
_LETS_IN = frozenset({"disarm", "unlatch", "unlock"})
_RELEASES = frozenset({"buzzer", "release", "strike"})
_OPENED = frozenset({"door", "doors", "garage"})
_BUTTONS = frozenset({"generic_switch", "x_scene", "x_setting"})
_PRESSED = frozenset({"push", "scene"})
_CHOSEN = frozenset({"option", "state"})
_NO_DEED = frozenset({"identify", "restart", "update"})
_BESIDE_RELAYS = frozenset({*_RELAYS, "x_setting"})
_WHICH = frozenset(
    {"a", "b", "back", "channel", "control", "controller", "east", "front", "group", "left", "main", "motor", "north"}
    | {"of", "rear", "relay", "right", "south", "switch", "the", "to", "west"}
    | {"button", "close", "impulse", "open", "press", "pulse", "stop", "toggle", "trigger"}
)
_GERMAN = frozenset({"herd", "tor", "tore"})
_GERMAN_ENDS = (
    *("backofen", "boiler", "haustuer", "haustur", "schloss", "ventil", "wohnungstuer", "wohnungstur"),
    *("einfahrtor", "einfahrtstor", "garagentor", "garagentuer", "garagentur", "gartentor", "hoftor", "rolltor"),
    *("schiebetor", "torantrieb", "toroeffner", "toroffner", "tueroeffner", "turoffner", "zufahrtstor"),
)
"""The ends of German words, folded, with which one says what something drives: ``Türschloss``, ``Wasserventil``."""

_FRENCH = frozenset(
    {"chaudiere", "cuisiniere", "electrovanne", "gache", "gaziniere", "portail", "portails", "portillon", "serrure"}
    | {"vanne", "verrou"}
)
_ITALIAN = frozenset(
    {"caldaia", "cancelletto", "cancello", "elettrovalvola", "fornello", "forno", "portone", "scaldabagno", "serratura"}
    | {"valvola"}
)
_SPANISH = frozenset(
    {"caldera", "calentador", "cancela", "cerradura", "cerrojo", "electrovalvula", "horno", "porton", "valvula"}
)
_DUTCH = frozenset(
    {"deuropener", "deurslot", "fornuis", "garagedeur", "garagepoort", "gaskraan", "kookplaat", "oprijpoort", "poort"}
    | {"poortopener", "tuinpoort", "waterklep", "waterkraan"}
)
_WORDS = _GERMAN | _FRENCH | _ITALIAN | _SPANISH | _DUTCH
_PAIRS = (
    *(frozenset({"porte", "garage"}), frozenset({"porte", "entree"}), frozenset({"chauffe", "eau"})),
    *(frozenset({"porta", "garage"}), frozenset({"puerta", "garaje"}), frozenset({"puerta", "garage"})),
)
_BESIDE_THEM = (
    *("licht", "lampe", "leuchte", "beleuchtung", "klingel", "kontakt", "sensor", "melder", "kamera", "batterie"),
    *("lumiere", "eclairage", "sonnette", "capteur", "detecteur"),
    *("luce", "luci", "campanello", "sensore", "luz", "luces", "timbre", "lamp", "deurbel"),
)
"""The ends of words for what is beside a gate, and harms nobody."""

_CAMEL_CASE = re.compile(r"(?<=[a-z])(?=[A-Z])")
_BEFORE_PLACES = frozenset({"at", "for", "in", "of", "to"})
_TAG = fold("always_ask")


def always_asks(device: Device, part: DevicePart) -> bool:
    """Return whether *part* of *device* is of the class.

    So is every other part of a device with such a part, but for lights: a garage door often has a button beside its
    cover, and a lamp.
    """
    kind = part.part.service_type
    if kind in _BUTTONS:
        is_named = _is_named_button(device, part)
    else:
        is_named = kind in _RELAYS and _is_named(_ENDINGS, *_names(device, part))
    if is_named or is_declared(part) or _TAG in map(fold, device.tags):
        return True
    if kind in _BESIDE_RELAYS and (is_opener(device) or (kind in _RELAYS and _is_of_such_a_model(device))):
        return True
    return kind not in _HARMLESS and any(map(is_declared, device.parts))


def is_declared(part: DevicePart) -> bool:
    """Return whether the type of *part*, its announced type, or a capability that can be set says so."""
    told = part.part
    if told.service_type in ALWAYS_ASK or not _OVENS.isdisjoint(words_of(told.advertised)):
        return True
    for one in told.capabilities:
        if not one.settable:
            continue
        if one.name in _CAPABILITIES or (one.name == "on_off" and told.name in _ARMED):
            return True
        if one.name == "heating_setpoint" and one.bounds and one.bounds[-1] >= _SCALDING:
            return True
    return False


def is_arming(part: DevicePart) -> bool:
    """Return whether *part* is called ``Armed``, as what arms and disarms the alarm at a keypad."""
    return part.part.name in _ARMED


def is_approved(device: Device) -> bool:
    """Return whether the owner approved *device*; what it announces of itself does not count."""
    return any(one.name == APPROVED and one.convention == OWNER and not one.gateway for one in device.facts)


def is_opener(device: Device) -> bool:
    """Return whether the model of *device* says that it opens a door or gate: ``Garage door opener``.

    It may do so by something that is called a setting, and when that is turned off as well.
    """
    for fact in device.metadata:
        if fact.key == "model":
            words = words_of(fact.value)
            return "opener" in words and not _MOVED_BY_OPENERS.isdisjoint(words)
    return False


def waits_for_approval(device: Device) -> bool:
    """Return whether a part of *device* can hurt and the owner has not approved it."""
    for part in device.parts:  # a generator would cost each announcement more
        if always_asks(device, part):
            return not is_approved(device)
    return False


def _is_named_button(device: Device, part: DevicePart) -> bool:
    """Return whether the name of *part* says what is opened or heated by pressing it, by an option or by degrees.

    What only keeps a device in order, such as a restart, is not called what the device is; a lock among its settings
    is one for its keys.
    """
    told = part.part
    for one in told.capabilities:
        if not one.settable:
            continue
        if one.name == "number" and one.unit in _DEGREES:
            return _is_named(_HEATERS, *_names(device, part)) or _is_of_heat(told.name)
        if one.name in _PRESSED and not told.category and told.tag not in _NO_DEED:
            return _is_named(_ENDINGS, *_names(device, part))
        if one.name in _CHOSEN:
            names = (told.name,) if told.name else _names(device, part)
            return _is_named(_ENDINGS_OF_SETTINGS if told.category else _ENDINGS, *names)
    return False


def _names(device: Device, part: DevicePart) -> tuple[str, ...]:
    return device.name, *device.names, part.part.name or _CAMEL_CASE.sub(" ", part.id)


def _is_named(endings: frozenset[str], *names: str) -> bool:
    """Return whether one of *names* says what is driven: ``Oven``, ``Front gate``, ``Garage door left``."""
    for name in names:
        words = words_of(name)
        if words and (not _OVENS.isdisjoint(words) or _is_called(words, endings)):
            return True
    return False


@lru_cache(maxsize=1024)
def _is_called(words: tuple[str, ...], endings: frozenset[str]) -> bool:
    """Return whether *words* call something one of *endings*, a garage door or its opener.

    Words that only say which one it is, or where, change nothing: ``Gate motor 2``, ``valve_group_1``, ``Valve of the
    garden``, ``Door garage``.
    """
    place = next((number for number, word in enumerate(words) if word in _BEFORE_PLACES), len(words))
    whole, called = (_without_which(one) for one in (words, words[:place]))
    if {*whole[-2:]} == {"garage", "door"} or (whole[-1:] == ("opener",) and not _MOVED_BY_OPENERS.isdisjoint(whole)):
        return True
    if _opens(words, whole) or whole[-2:] in _HOT_WATER:
        return True
    if endings is not _HEATERS and _is_called_abroad(words):
        return True
    return any(one and one[-1] in endings and one[-2:] != ("child", "lock") for one in (whole, called))


def _is_called_abroad(words: tuple[str, ...]) -> bool:
    """Return whether *words* are for something of the class in another language: ``Garagentor``, ``Porte de garage``.

    Wherever the word stands, as to ask once too often does no harm; but a lamp, a bell or a sensor beside it is none.
    """
    if any(one.endswith(_BESIDE_THEM) for one in words):
        return False
    if not _WORDS.isdisjoint(words) or any(one.endswith(_GERMAN_ENDS) for one in words):
        return True
    return any(pair.issubset(words) for pair in _PAIRS)


@lru_cache(maxsize=1024)
def _is_of_heat(name: str) -> bool:
    """Return whether *name* has the word for what becomes hot: ``Boiler setpoint``, ``DHW setpoint``, ``Hot water``."""
    words = words_of(name)
    is_hot_water = any(one.rstrip("0123456789") == "dhw" for one in words)
    return is_hot_water or not _HEATERS.isdisjoint(words) or any(map(frozenset(words).issuperset, _HOT_WATER))


def _opens(words: tuple[str, ...], whole: tuple[str, ...]) -> bool:
    """Return whether *words*, *whole* without those that say which one, let in: ``Open door``, ``Door release``."""
    if words[0] in _LETS_IN or words[-1] in _LETS_IN:
        return True
    if whole[-1:] and whole[-1] in _RELEASES:
        return whole[-2:-1] in {("door",), ("gate",)}
    return "open" in words and whole[-1:] != () and whole[-1] in _OPENED


def _without_which(words: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(word for word in words if word not in _WHICH and not word.isdigit())


def _is_of_such_a_model(device: Device) -> bool:
    """Return whether the model says what a relay drives: ``Zigbee smart water valve``; a lock for its keys is none."""
    for fact in device.metadata:
        if fact.key == "model":
            words = words_of(fact.value)
            ends_so = bool(words) and words[-1] in _ENDINGS and words[-2:] != ("child", "lock")
            return ends_so or not _VALVES.isdisjoint(words)
    return False
