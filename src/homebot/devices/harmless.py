"""The list of harmless parts: what can hurt nobody, by type and purpose. Pure.

It is for issuers that the owner knows little of: agents, local programs without a token, and all with the right
``harmless``. No words name every danger (:mod:`homebot.devices.always_ask`), so nothing is on the list unless its type,
class, icon or model says what it moves, or the owner said that it is harmless.
"""

from collections.abc import Mapping
from typing import Final

from homebot.devices import words
from homebot.devices.always_ask import models_of, names_of, why_it_asks
from homebot.devices.client_rights import HARMLESS, ClientRights
from homebot.devices.device import Device, DevicePart
from homebot.devices.device_types import spoken_type
from homebot.devices.names import OWNER
from homebot.devices.value import PlainValue
from homebot.support.folding import fold

_ALWAYS: Final = frozenset({"light", "speaker", "video_player", "x_humidifier"})
_LOADS: Final = {"fan": words.BURNS_OR_FLOODS, "room_air_conditioner": words.HEAT, "thermostat": words.HEAT}
"""What the model or name of a part of a harmless type must not say."""

_SETPOINTS: Final = frozenset({"cooling_setpoint", "heating_setpoint"})
_COLDEST, _HOTTEST = 5.0, 28.0
"""Degrees Celsius at which no pipe freezes and no person suffers."""

_OF_LAMPS: Final = frozenset({"number", "on_off", "option", "scene"})
"""Settings of a lamp, such as its effect; its buttons may reset it, its texts contain anything."""

_BESIDE_LAMPS: Final = frozenset({"x_scene", "x_setting"})


def why_not_harmless(device: Device, part: DevicePart, settings: Mapping[str, PlainValue] | None = None) -> str:
    """Return why *part* of *device* is not on the list, for people; empty if it is. What always asks never is.

    Args:
        settings: The wanted values, of which those of a thermostat count; None for any within its range.
    """
    kind = part.part.service_type
    if reason := why_it_asks(device, part):
        return reason
    if kind in _ALWAYS or _is_owners_word(device, part) or _is_of_lamp(device, part):
        return ""
    if kind in _LOADS:
        return _said(device, part, _LOADS[kind]) or _why_out_of_range(settings or {})
    if kind == "window_covering":
        if _said(device, part, words.COVERING) or words.matching_words(part.part.advertised, words.COVERING):
            return _said(device, part, words.WINDOW)
        return "nothing says that it is a blind, a curtain or an awning"
    return _why_no_lamp(device, part) if kind in {"plug", "switch"} else f"it is {spoken_type(kind)}"


def why_not_covered(
    rights: ClientRights, device: Device, part: DevicePart, asks: str, settings: Mapping[str, PlainValue] | None = None
) -> str | None:
    """Return why *part* asks, or is not harmless, or empty, if *rights* do not cover it; None if they do.

    Args:
        asks: Why it always asks; empty if it does not.
        settings: As for :func:`why_not_harmless`.
    """
    limit = asks
    if not limit and rights.acts_on_harmless and not rights.acts_on_ordinary:
        limit = why_not_harmless(device, part, settings)
    return None if rights.may_command(device, part, asks=bool(asks), is_harmless=not limit) else limit


def _why_no_lamp(device: Device, part: DevicePart) -> str:
    is_lamp = any(
        words.matching_words(model, words.LAMP, anywhere=True) for model in (part.part.tag, *models_of(device))
    )
    return "" if is_lamp else f"nothing but its name says what this {part.part.service_type} turns on"


def _is_owners_word(device: Device, part: DevicePart) -> bool:
    """Return whether the owner tagged *device* or approved *part*; a tag in an announcement is not the owner's."""
    tags = (fold(fact.value) for fact in device.facts if fact.name == "tag" and fact.convention == OWNER)
    return HARMLESS in tags or any(route.approved for route in part.routes)


def _said(device: Device, part: DevicePart, groups: words.Groups) -> str:
    """Return which class, model or name has a word of *groups*; empty if none has."""
    texts = [(text, words.matching_words(text, groups, anywhere=True)) for text in (part.part.tag, *models_of(device))]
    texts += [(name, words.matching_words(name, groups)) for name in names_of(device, part)]
    return next((f"{text!r} says {said!r}" for text, said in texts if said), "")


def _why_out_of_range(settings: Mapping[str, PlainValue]) -> str:
    wanted = {name: value for name, value in settings.items() if name in _SETPOINTS and isinstance(value, float)}
    far = (f"{name} {value:g}" for name, value in wanted.items() if not _COLDEST <= value <= _HOTTEST)
    return next((f"{celsius} is not within {_COLDEST:g} to {_HOTTEST:g} °C" for celsius in far), "")


def _is_of_lamp(device: Device, part: DevicePart) -> bool:
    """Return whether *part* is a setting or scene of a device that is a lamp and nothing else."""
    settable = {capability.name for capability in part.part.capabilities if capability.settable}
    kinds = {other.part.service_type for other in device.parts if other.part.category != "diagnostic"} - _BESIDE_LAMPS
    if part.part.service_type not in _BESIDE_LAMPS or not settable <= _OF_LAMPS or kinds != {"light"}:
        return False
    return not words.matching_words(part.part.name or part.id, words.ALL_THAT_ASK | words.SIREN, anywhere=True)
