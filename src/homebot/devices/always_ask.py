"""Devices that a person has to allow by name: a wrong command opens a door, floods a room or starts a fire. Pure.

The owner approves the programs that may drive them.

A switch, plug or cover that drives such a device is recognised by its name in one of many languages, by its class or
icon, by its model, or by the tag ``always_ask``, which the owner may give to any device. Buttons, scenes and choices
are recognised by their names, texts and flags by names of things that open, temperatures by names of hot things; so are
the choices of an oven, such as its program. Switches and settings beside a garage door, or parts of an oven or a car,
ask unless their class is harmless. See :mod:`homebot.devices.words`, and
:mod:`homebot.devices.harmless` for the issuers to which this is not enough.
"""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

from homebot.devices.device import Device, DevicePart
from homebot.devices.device_types import spoken_type
from homebot.devices.identity import aliasing_bridge
from homebot.devices.part import Capability, Part
from homebot.devices.words import (
    ALL_THAT_ASK,
    BURNS_OR_FLOODS,
    COVERING,
    FIRE,
    GARAGE,
    HEAT,
    MACHINE,
    NO_LOCK,
    OPEN,
    OPENER,
    WINDOW,
    Groups,
    matching_words,
)
from homebot.support.folding import fold

_LOADS: Final[Mapping[str, str]] = MappingProxyType(
    {"closure": "entry", "door_lock": "lock", "water_heater": "heat", "water_valve": "water", "x_alarm_panel": "open"}
)
"""The group of :mod:`homebot.devices.words` for each device type of the class."""

ALWAYS_ASK: Final = frozenset(_LOADS)
"""Device types of the class: garage doors and gates, locks, boilers, valves, alarm panels."""

BREAKER: Final = "breaker"
"""The tag of a switch that is a circuit breaker of the house, as in a SPAN panel."""

APPROVED: Final = "approved"
"""The name of the fact with which the owner approves a dangerous device."""

PANEL: Final = "alarm_panel"
"""The name of the fact that a device hangs on an alarm panel; its value is the identifier of that."""

CHANGED: Final = "changed_since_approval"
"""The name of the fact that an approved announcement has changed; its value is the change."""

_CAPABILITIES = frozenset({"alarm", "contact", "lock", "valve", "water_heater_mode"})
_TELLING = _CAPABILITIES | {"heating_setpoint", "on_off", "option"}
_ARMED = frozenset({"Armed", "armed"})
_DISARMING = frozenset({"disarm", "disarmed"})
_SCALDING = 100.0
"""Degrees Celsius that no room or radiator needs, but saunas, grills and kilns do."""

_HOTTER_THAN_A_ROOM = 45.0
"""Degrees Celsius that a boiler exceeds but a room thermostat never does; an electric floor is set up to this."""

_DEGREES = frozenset({"°C", "°F", "K"})
_RELAYS = frozenset({"plug", "siren", "switch", "window_covering", "x_unknown"})
_AT_WINDOWS = frozenset({"awning", "blind", "curtain", "shade"})
CLAIMED_MODEL: Final = "claimed_model"
"""The name of the fact that an announcement that joined an approved device states this maker or model."""

MAKE: Final = frozenset({"manufacturer", "model"})
"""Rachio and RainMachine make nothing but irrigation, of which the switches have the names of places in the garden."""

_MODELS = MAKE | {CLAIMED_MODEL}
_BUTTONS = frozenset({"generic_switch", "x_scene", "x_setting"})
_IN_MACHINES = _BUTTONS | {"plug", "switch", "x_unknown"}
_PRESSED = frozenset({"push", "scene"})
_CHOSEN = frozenset({"option", "state"})
_OPENING = frozenset({"number", "on_off", "push", "text"})
"""Settings that open something if their name says so: ``unlock_door`` of a lock takes its password."""

_DOSES = frozenset({"number", "option", "text"})
"""Settings of a device without any other purpose that may be its valve, as the percentage of a QOTO QT-05M is."""

_VOLUMES = frozenset({"L", "mL", "gal", "m³", "L/min", "L/h", "mL/min", "gal/min", "m³/h"})
"""Units of numbers that pour something."""

_NO_DEED = frozenset({"identify", "outlet", "restart", "update"})
_TAG = fold("always_ask")


def always_asks(device: Device, part: DevicePart) -> bool:
    """Return whether *part* of *device* belongs to the always-ask class."""
    return bool(why_it_asks(device, part))


def why_it_asks(device: Device, part: DevicePart) -> str:
    """Return why *part* of *device* always asks, for people; empty if it does not.

    All other parts of such a device always ask too, except lights and other blinds with topics of their own: a garage
    door often has a button beside its cover, and a lamp. So does a part with announced payloads on the topic of such a
    relay.
    """
    if reason := _why_declared(part.part) or _why_by_itself(device, part):
        return reason
    for other in device.parts:
        if other is not part and (reason := _why_beside(device, part, other)):
            return reason
    return _why_in_machine(device, part) if part.part.service_type in _IN_MACHINES else ""


def why_it_drives(device: Device, part: DevicePart, groups: Groups = ALL_THAT_ASK) -> str:
    """Return why *part* is, or switches, a load of *groups*, for people; empty if it is not.

    For policies and apps: a plug called ``Water valve`` drives ``WATER`` just as a part of that type does.
    """
    kind = part.part.service_type
    if _LOADS.get(kind) in groups:
        return f"it is {spoken_type(kind)}"
    if kind in _RELAYS and (kind != "siren" or part.part.guessed):
        reason = _why_named(groups, *names_of(device, part)) or _why_of_model(device, part, groups)
        return reason or (_why_garage(device, part) if "entry" in groups else "")
    return ""


def why_device_asks(device: Device) -> str:
    """Return why the first part of *device* that always asks does so; empty if none does."""
    for part in device.parts:  # a loop is cheaper than a generator for each announcement
        if reason := _why_declared(part.part) or _why_by_itself(device, part):
            return reason
    return ""


def asks_by_itself(part: Part) -> bool:
    """Return whether an announced *part* always asks by its type, a setting or its name, whatever its device."""
    return bool(_why_declared(part) or matching_words(part.name or part.id, ALL_THAT_ASK))


def is_declared(part: DevicePart) -> bool:
    """Return whether the type of *part*, its announced type, or a settable capability makes it always ask."""
    return bool(_why_declared(part.part))


def is_arming(part: DevicePart) -> bool:
    """Return whether *part* is called ``Armed``, like the setting that arms and disarms the alarm of a keypad."""
    return part.part.name in _ARMED


def is_approved(device: Device) -> bool:
    """Return whether the owner approved an announcement of *device* in its present form."""
    return any(route.approved for part in device.parts for route in part.routes)


def is_of_known_load(device: Device, part: DevicePart) -> bool:
    """Return whether it is known what *part* turns on: not behind a breaker, nor by the tag ``always_ask``."""
    return part.part.tag != BREAKER and _TAG not in map(fold, device.tags)


def is_opener(device: Device) -> bool:
    """Return whether the model of *device* says that it opens a door or gate: ``Garage door opener``.

    Even its settings may open the door, also when they are turned off.
    """
    return any(matching_words(model, OPENER, anywhere=True) for model in models_of(device))


def waits_for_approval(device: Device) -> bool:
    """Return whether a part of *device* always asks, takes commands, and has no route that the owner approved."""
    return bool(why_device_asks(device)) and any(_waits(device, part) for part in device.parts)


def _waits(device: Device, part: DevicePart) -> bool:
    if not part.routes or any(route.approved for route in part.routes):
        return False
    return any(capability.settable for capability in part.part.capabilities) and always_asks(device, part)


def _why_beside(device: Device, part: DevicePart, other: DevicePart) -> str:
    """Return why *part* always asks because of *other*; a command on the topic of a lock may unlock it."""
    shares_topic = not frozenset(part.part.writes).isdisjoint(other.part.writes)
    if not shares_topic and not _has_aliases(device) and _is_told_apart(part, other):
        return ""
    reason = _why_declared(other.part)
    if not reason and shares_topic and part.part.payloads and other.part.service_type in _RELAYS:
        reason = _why_by_itself(device, other)
    return f"beside another part: {reason}" if reason else ""


def _why_in_machine(device: Device, part: DevicePart) -> str:
    """Return why *part* always asks for the garage door, oven or car whose further parts its device has."""
    if part.part.tag in _NO_DEED or not any(capability.settable for capability in part.part.capabilities):
        return ""
    for other in device.parts:
        if other is part:
            continue
        if other.part.service_type == "window_covering" and (reason := why_it_drives(device, other, NO_LOCK)):
            return f"beside another part: {reason}"
        if words := matching_words(other.part.name or other.part.id, MACHINE, anywhere=True):
            return f"beside another part: the name {other.part.name or other.part.id!r} says {words!r}"
    return ""


def _is_told_apart(part: DevicePart, other: DevicePart) -> bool:
    kind = part.part.service_type
    return kind == "light" or (kind == "window_covering" and _has_its_program(part, other))


def _has_aliases(device: Device) -> bool:
    """Return whether further topics reach any part of it, such as ``LOCK/left/set`` and that of its address."""
    bridges = [fact.value for fact in device.facts if fact.name == "via_device"]
    return any(aliasing_bridge(bridge, device.identifiers) for bridge in bridges or [""])


def _has_its_program(part: DevicePart, other: DevicePart) -> bool:
    """Return whether one program announces both, and so tells a blind from a garage door, which others may not.

    ESPSomfy-RTS announces all covers of a house as one device; only Home Assistant may know what a Shelly moves.
    """
    programs = {(route.gateway, route.convention) for route in other.routes}
    return any((route.gateway, route.convention) in programs for route in part.routes)


def _why_by_itself(device: Device, part: DevicePart) -> str:
    """Return why *part* always asks by its tag, name or model; empty if it does not."""
    kind = part.part.service_type
    if device.tags and _TAG in map(fold, device.tags):
        return "it has the tag always_ask"
    if kind in _RELAYS:
        reason = why_it_drives(device, part, NO_LOCK if part.part.category else ALL_THAT_ASK)
        return reason or (_why_on_panel(device) if part.part.service_type == "switch" else "")
    if kind in _BUTTONS and (reason := _why_on_panel(device) or _why_named_setting(device, part)):
        return reason
    if kind == "x_setting":
        return _why_of_model(device, part, ALL_THAT_ASK)
    return _why_hot(device, part) if kind == "thermostat" else ""


def _why_on_panel(device: Device) -> str:
    """Return why a switch, button or setting always asks by the device on which its own hangs: it may bypass a zone."""
    panels = (fact.value for fact in device.facts if fact.name == PANEL)
    return next((f"it hangs on the alarm panel {panel.removeprefix('id:')}" for panel in panels), "")


def _why_declared(part: Part) -> str:
    if part.service_type in ALWAYS_ASK:
        return f"it is {spoken_type(part.service_type)}"
    if part.tag == BREAKER:
        return "it is a circuit breaker"
    if part.advertised and matching_words(part.advertised, HEAT) and _does_something(part):
        return f"it calls itself {part.advertised}"
    for capability in part.capabilities:  # a loop is cheaper than a generator for each announcement and command
        if capability.settable and capability.name in _TELLING and (reason := _why_settable(capability, part)):
            return reason
    return ""


def _does_something(part: Part) -> bool:
    return not part.category and any(capability.settable for capability in part.capabilities)


def _why_settable(capability: Capability, part: Part) -> str:
    if capability.name in _CAPABILITIES:
        return f"its {capability.name} can be set"
    if capability.name == "option" and not _DISARMING.isdisjoint(map(str.casefold, capability.options)):
        return "it disarms the alarm"
    if capability.name == "on_off" and part.name in _ARMED:
        return "it disarms the alarm"
    if capability.name == "heating_setpoint" and capability.bounds and capability.bounds[-1] >= _SCALDING:
        return f"it heats up to {capability.bounds[-1]:g} °C"
    return ""


def _why_named_setting(device: Device, part: DevicePart) -> str:
    """Return why a button or setting always asks: its name contains a thing that opens or heats.

    The device's name does not count for maintenance settings, such as a restart; a lock among its settings is a key
    lock.
    """
    reasons = (_why_called(capability, device, part) for capability in part.part.capabilities if capability.settable)
    return next((reason for reason in reasons if reason is not None), "")


def _why_called(capability: Capability, device: Device, part: DevicePart) -> str | None:
    """Return the same as :func:`_why_named_setting`; None if names say nothing about such a capability."""
    description = part.part
    unit = {"number": capability.unit, "text": description.name.strip("()")[-2:]}.get(
        capability.name
    )  # BSB-LAN's texts
    if unit in _DEGREES:
        return _why_named(HEAT, *names_of(device, part)) or _why_named(HEAT, description.name, anywhere=True)
    if (capability.name in _PRESSED or description.service_type == "generic_switch") and _is_deed(description):
        return _why_named(ALL_THAT_ASK, *names_of(device, part), f"{device.name} {description.name or part.id}")
    if capability.name == "number" and unit in _VOLUMES and not description.category:
        return f"its unit is {unit}"
    description = part.part
    names = (description.name,) if description.name else names_of(device, part)[:-1]
    if capability.name in _CHOSEN:
        return _why_chosen(device, part, names)
    return _why_named(OPEN, *names) if capability.name in _OPENING else None


def _why_chosen(device: Device, part: DevicePart, names: Sequence[str]) -> str:
    description = part.part
    if description.category:
        return _why_named(NO_LOCK, *names)
    return _why_named(ALL_THAT_ASK, *names, _class_of(description)) or _why_named(HEAT, *names_of(device, part))


def _is_deed(button: Part) -> bool:
    return not button.category and button.tag not in _NO_DEED


def _why_named(groups: Groups, *names: str, anywhere: bool = False) -> str:
    for name in names:
        if words := matching_words(name, groups, anywhere=anywhere):
            return f"the {'icon' if name.startswith('mdi:') else 'name'} {name!r} says {words!r}"
    return ""


def _why_garage(device: Device, part: DevicePart) -> str:
    """Return why a cover of unknown class is a garage door or a window: its whole name is ``Garage``, or its model."""
    description = part.part
    if description.service_type != "window_covering" or description.tag in _AT_WINDOWS:
        return ""
    for model in models_of(device):
        words = matching_words(model, WINDOW, anywhere=True)
        if words and not matching_words(model, COVERING, anywhere=True):
            return f"the model {model!r} says {words!r}"
    return _why_named(GARAGE, *((description.name,) if description.name else names_of(device, part)))


def _why_of_model(device: Device, part: DevicePart, groups: Groups) -> str:
    """Return why a part always asks by its model: an opener with all its settings, or the load of a relay."""
    for model in models_of(device):
        words = matching_words(model, OPENER & groups, anywhere=True)
        if not words and (
            loads := matching_words(model, BURNS_OR_FLOODS & groups, anywhere=True) or matching_words(model, groups)
        ):
            words = loads if _is_load(device, part) else ""
        if words:
            return f"the model {model!r} says {words!r}"
    return ""


def _is_load(device: Device, part: DevicePart) -> bool:
    """Return whether a part is the load of a relay, or a dose of a device that has settings alone."""
    doses = [capability for capability in part.part.capabilities if capability.settable and capability.name in _DOSES]
    return part.part.service_type in _RELAYS or (
        bool(doses) and all(other.part.service_type.startswith("x_") for other in device.parts)
    )


def _why_hot(device: Device, part: DevicePart) -> str:
    """Return why a thermostat always asks: it lights a fire, or is called a boiler and gets hotter than a room."""
    for capability in part.part.capabilities:
        if capability.name == "heating_setpoint" and capability.settable:
            return _why_named(HEAT if _is_hot(capability) else FIRE, *names_of(device, part))
    return ""


def _is_hot(setpoint: Capability) -> bool:
    return not setpoint.bounds or setpoint.bounds[-1] > _HOTTER_THAN_A_ROOM


def names_of(device: Device, part: DevicePart) -> tuple[str, ...]:
    """Return the names of *device*, and the name or id and the class or icon of *part*."""
    return device.name, *device.names, part.part.name or part.id, _class_of(part.part)


def _class_of(part: Part) -> str:
    """Return the class or icon, such as ``mdi:valve``; empty for settings, and a lock, the icon of child locks."""
    return "" if part.category or "lock" in part.tag else part.tag


def models_of(device: Device) -> Iterable[str]:
    """Return all makers and models in announcements of *device*: a stranger may state the first."""
    models = [item.value for item in device.metadata if item.key in MAKE]
    return dict.fromkeys((*models, *[fact.value for fact in device.facts if fact.name in _MODELS]))
