"""A WLED controller: its parts and values from its JSON documents, and the documents that command it. Pure.

A controller has a master switch and dimmer, and segments with brightness, colours and effects of their own. One with a
single segment is one lamp; with several, the master is a lamp that can be dimmed and each segment is another.

Source: WLED, JSON API (https://kno.wled.ge/interfaces/json-api): state, segment and info objects, light capabilities;
0.13 to 16. The white of ``cct`` has 256 steps of 32 K from 1900 K on. Presets: https://kno.wled.ge/features/presets.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, NamedTuple

from homebot.conventions.command_values import (
    require_bool,
    require_color,
    require_number,
    require_option,
    require_transition,
)
from homebot.conventions.light_color import from_hue_saturation, to_hue_saturation
from homebot.conventions.payload import Readings, as_fields, clean_text, shown, text_of
from homebot.devices.identity import identifiers
from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.support.numbers import to_number

__all__ = ["MASTER", "Fields", "WledStrip", "effect_names", "preset_names"]

Fields = Mapping[str, object]

MASTER = ""
"""The part that is the whole controller."""

_PRESET = "preset"
_NO_PRESETS: Mapping[int, str] = MappingProxyType({})

_RGB, _WHITE, _CCT = 1, 2, 4
_MOST_SEGMENTS, _MOST_EFFECTS, _MOST_PRESETS = 64, 300, 250
_LONGEST_NAME = 60
_LONGEST_TRANSITION = 65.5
_FULL = 255
_WARMEST, _STEP = 1900, 32
_COLDEST = _WARMEST + _FULL * _STEP
_WHITE_RANGE = (_WARMEST, _COLDEST)
_NO_EFFECTS = frozenset({"RSVD", "-", ""})
_ON_OFF = Capability(name="on_off", settable=True)
_LEVEL = Capability(name="level", settable=True)


class _Extra(NamedTuple):
    """A value of the controller besides its light: a part with one capability, at *field* of *owner*.

    Attributes:
        is_info: Whether *owner* is in the info, not in the state; an empty one is the info itself.
    """

    part: str
    owner: str
    field: str
    name: str
    service_type: str
    category: Category
    capability: Capability
    is_info: bool = False


_EXTRAS: Final = (
    _Extra("sync_send", "udpn", "send", "Sends its state to others", "switch", "config", _ON_OFF),
    _Extra("sync_receive", "udpn", "recv", "Takes the state of others", "switch", "config", _ON_OFF),
    _Extra("nightlight", "nl", "on", "Night light", "switch", "config", _ON_OFF),
    _Extra(
        "live",
        "",
        "live",
        "Lit by another program",
        "x_binary_sensor",
        "diagnostic",
        Capability(name="state"),
        is_info=True,
    ),
    _Extra("signal", "wifi", "rssi", "", "x_sensor", "diagnostic", Capability(name="signal_strength"), is_info=True),
)


@dataclass(frozen=True, slots=True)
class _Segment:
    """A segment with LEDs.

    Attributes:
        part: The id of its part.
        abilities: Bits: 1 colours, 2 a white channel, 4 whites of different temperature.
        fields: Its object in the state.
    """

    id: int
    part: str
    name: str
    abilities: int
    fields: Fields

    @property
    def channels(self) -> tuple[float, ...] | None:
        """The first of its three colours: red, green, blue and perhaps white; None if it is invalid."""
        colors = self.fields.get("col")
        first = colors[0] if isinstance(colors, list) and colors else None
        if not isinstance(first, list) or len(first) not in {3, 4}:
            return None
        channels = tuple(one for one in map(_byte, first) if one is not None)
        return channels if len(channels) == len(first) else None


class WledStrip:
    """One controller in its last reported state.

    Args:
        document: Its state and info, the answer to ``/json/si`` or a message of its WebSocket.
        effects: The names of its effects, by number; those that cannot be chosen are empty.
        presets: The names of its presets and playlists, by number.

    Raises:
        WireError: The document has no state or no info.
    """

    def __init__(self, document: Fields, effects: tuple[str, ...], presets: Mapping[int, str] = _NO_PRESETS) -> None:
        state, info = document.get("state"), document.get("info")
        if not isinstance(state, dict) or not isinstance(info, dict):
            raise WireError("a message has no state or no info")
        self._state: Fields = state
        self._info: Fields = info
        self._effects = effects if any(effects) else ()
        self._presets = presets
        self._segments = {one.part: one for one in _segments(state, as_fields(info.get("leds")))}

    def with_state(self, state: Fields) -> WledStrip:
        """Return the same controller in another state."""
        return WledStrip({"state": state, "info": self._info}, self._effects, self._presets)

    @property
    def name(self) -> str:
        """Its name; empty for none."""
        return text_of(self._info.get("name"))

    @property
    def identifiers(self) -> tuple[str, ...]:
        """Its hardware address, as an identifier."""
        return identifiers((text_of(self._info.get("mac")),))

    @property
    def metadata(self) -> dict[str, str]:
        """Further facts."""
        facts = {
            "manufacturer": text_of(self._info.get("brand")) or "WLED",
            "model": text_of(self._info.get("product")),
            "sw_version": text_of(self._info.get("ver")),
            "architecture": text_of(self._info.get("arch")),
        }
        return {name: value for name, value in facts.items() if value}

    def parts(self) -> tuple[Part, ...]:
        """Return its parts, the master first."""
        found = [
            Part(
                id=one.part,
                name=one.name,
                service_type="light",
                advertised="segment",
                capabilities=tuple(self._capabilities(one)),
            )
            for one in self._segments.values()
        ]
        if MASTER not in self._segments:
            found.insert(0, Part(id=MASTER, service_type="light", advertised="wled", capabilities=(_ON_OFF, _LEVEL)))
        return (*found, *(_part(extra) for extra, _ in self._extras()))

    def readings(self) -> Iterator[tuple[str, Readings]]:
        """Yield the reports of each part, by its id."""
        for segment in self._segments.values():
            yield segment.part, self._read_segment(segment)
        if MASTER not in self._segments:
            yield MASTER, {"on_off": _flag(self._state.get("on")), "level": _percent(_byte(self._state.get("bri")))}
        for extra, value in self._extras():
            yield extra.part, {extra.capability.name: value}

    def write(self, part: str, capability: str, value: PlainValue, transition: float) -> dict[str, object]:
        """Return the state to send so that *capability* of *part* becomes *value*.

        Raises:
            RefusedError: There is no such part, it cannot do that, or the value is out of its bounds.
        """
        seconds = min(require_transition(transition), _LONGEST_TRANSITION)
        given: dict[str, object] = {"tt": round(seconds * 10)} if seconds else {}
        switch = next((one for one in _EXTRAS if one.part == part and one.capability is _ON_OFF), None)
        if switch is not None and capability == "on_off":
            return {switch.owner: {switch.field: require_bool(capability, value)}}
        if part == _PRESET and self._presets and capability == "option":
            chosen = require_option(capability, value, tuple(self._presets.values()))
            return given | {"ps": next(number for number, name in self._presets.items() if name == chosen)}
        if part in self._segments:
            return given | self._write_segment(self._segments[part], capability, value)
        if part != MASTER:
            raise RefusedError(f"a command to {part[:60]!r}", "the device has no such part any more")
        return given | _write_master(capability, value)

    def _extras(self) -> Iterator[tuple[_Extra, PlainValue]]:
        """Yield the further values that it has."""
        for extra in _EXTRAS:
            if extra.part == "live" and self._presets:
                options = Capability(name="option", settable=True, options=tuple(self._presets.values()))
                preset = _Extra(_PRESET, "", "", "Preset", "x_setting", "config", options)
                yield preset, self._shown_preset()
            source = self._info if extra.is_info else self._state
            fields = as_fields(source.get(extra.owner)) if extra.owner else source
            value = fields.get(extra.field)
            if extra.part == "signal" and extra.field in fields:
                yield extra, to_number(value)
            elif isinstance(value, bool):
                yield extra, value

    def _shown_preset(self) -> str | None:
        """Return the name of the running playlist, or of the preset that was chosen last."""
        numbers = (number for field in ("pl", "ps") if isinstance(number := self._state.get(field), int))
        return next((self._presets[number] for number in numbers if number in self._presets), None)

    def _capabilities(self, segment: _Segment) -> Iterator[Capability]:
        yield from (_ON_OFF, _LEVEL)
        if segment.abilities & _CCT:
            bounds = (float(_WARMEST), float(_COLDEST))
            yield Capability(name="color_temperature", settable=True, bounds=bounds)
        if segment.abilities & _RGB:
            yield Capability(name="color", settable=True)
        if self._effects:
            names = tuple(dict.fromkeys(one for one in self._effects if one))
            yield Capability(name="effect", settable=True, options=names)

    def _read_segment(self, segment: _Segment) -> Readings:
        readers = (self._read_light, self._read_colors, self._read_effect)
        return {name: value for read in readers for name, value in read(segment).items()}

    def _read_light(self, segment: _Segment) -> Readings:
        master_on, own_on = _flag(self._state.get("on")), _flag(segment.fields.get("on", True))
        master_level = _byte(self._state.get("bri")) if segment.part == MASTER else _FULL
        own_level = _byte(segment.fields.get("bri", _FULL))
        level = None if own_level is None or master_level is None else own_level * master_level / _FULL
        is_on = None if master_on is None or own_on is None else master_on and own_on
        return {"on_off": is_on, "level": _percent(level)}

    def _read_colors(self, segment: _Segment) -> Readings:
        channels, steps = segment.channels, _byte(segment.fields.get("cct"))
        found: dict[str, PlainValue] = {}
        if segment.abilities & _RGB:
            found["color"] = None if channels is None else _hue_saturation(channels)
        if segment.abilities & _CCT:
            is_white = channels is not None and len(set(channels[:3])) == 1
            shows_white = is_white or not segment.abilities & _RGB
            found["color_temperature"] = _WARMEST + _STEP * steps if steps is not None and shows_white else None
        return found

    def _read_effect(self, segment: _Segment) -> Readings:
        if not self._effects:
            return {}
        number = segment.fields.get("fx")
        is_known = isinstance(number, int) and 0 <= number < len(self._effects)
        return {"effect": (self._effects[number] or None) if is_known and isinstance(number, int) else None}

    def _write_segment(self, segment: _Segment, capability: str, value: PlainValue) -> dict[str, object]:
        writers: dict[str, Callable[[_Segment, PlainValue], dict[str, object]]] = {
            "on_off": _write_on,
            "level": _write_level,
        }
        if segment.abilities & _RGB:
            writers["color"] = _write_color
        if segment.abilities & _CCT:
            writers["color_temperature"] = _write_white
        if self._effects:
            writers["effect"] = self._write_effect
        if capability not in writers:
            raise RefusedError(shown(capability), "this segment does not support it")
        return writers[capability](segment, value)

    def _write_effect(self, segment: _Segment, value: PlainValue) -> dict[str, object]:
        name = require_option("effect", value, [one for one in self._effects if one])
        return _lit(segment, fx=self._effects.index(name))


def effect_names(document: object) -> tuple[str, ...]:
    """Return the names of effects by number; those that cannot be chosen are empty.

    Args:
        document: The answer to ``/json/eff``: a list of texts; any other document has no effects.
    """
    names: list[str] = []
    for one in document[:_MOST_EFFECTS] if isinstance(document, list) else ():
        name = text_of(one, 40).partition("@")[0]
        names.append("" if name in _NO_EFFECTS or name in names else name)
    return tuple(names)


def preset_names(document: object) -> dict[int, str]:
    """Return the names of the presets and playlists by number, each name once; of two, the later has its number too.

    Args:
        document: The answer to ``/presets.json``: objects by number. The one of 0 is none.
    """
    names: dict[int, str] = {}
    for key, fields in as_fields(document).items():
        if not (isinstance(fields, dict) and key.isascii() and key.isdecimal() and 0 < int(key[:4]) <= _MOST_PRESETS):
            continue
        own = fields.get("n")
        name = clean_text(own, _LONGEST_NAME) if isinstance(own, str) and own.strip() else f"Preset {key}"
        names[int(key)] = f"{name} ({key})" if name in names.values() else name
    return names


def _segments(state: Fields, leds: Fields) -> Iterator[_Segment]:
    """Yield the segments with LEDs; a single one is the master part."""
    listed = state.get("seg")
    given = [one for one in listed if isinstance(one, dict)] if isinstance(listed, list) else []
    lit = [one for one in given[:_MOST_SEGMENTS] if one.get("stop") != 0]
    known = leds.get("seglc")
    by_place = isinstance(known, list) and len(known) == len(lit)
    seen: set[int] = set()
    for place, fields in enumerate(lit):
        number = fields.get("id", place)
        if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < _FULL or number in seen:
            continue
        seen.add(number)
        part = MASTER if len(lit) == 1 else f"segment:{number}"
        abilities = _abilities(fields, leds, place if by_place else number)
        yield _Segment(number, part, text_of(fields.get("n"), _LONGEST_NAME), abilities, fields)


def _abilities(segment: Fields, leds: Fields, place: int) -> int:
    """Return the abilities of a segment: from 16 on it names them itself, before 0.13 no segment does."""
    known = leds.get("seglc")
    of_place = known[place] if isinstance(known, list) and place < len(known) else None
    for one in (segment.get("lc"), of_place, leds.get("lc")):
        if isinstance(one, int) and not isinstance(one, bool) and 0 <= one <= _FULL:
            return one
    return _RGB | (_WHITE if leds.get("rgbw") is True else 0)


def _part(extra: _Extra) -> Part:
    return Part(
        id=extra.part,
        name=extra.name,
        service_type=extra.service_type,
        category=extra.category,
        capabilities=(extra.capability,),
    )


def _lit(segment: _Segment, **fields: object) -> dict[str, object]:
    """Return the state that turns a segment on with these *fields*."""
    return {"on": True, "seg": [{"id": segment.id, "on": True, **fields}]}


def _write_on(segment: _Segment, value: PlainValue) -> dict[str, object]:
    if require_bool("on_off", value):
        return _lit(segment)
    return {"on": False} if segment.part == MASTER else {"seg": [{"id": segment.id, "on": False}]}


def _write_level(segment: _Segment, value: PlainValue) -> dict[str, object]:
    level = require_number("level", value, 0, 100, "%")
    if level == 0:
        return _write_on(segment, value=False)
    brightness = max(1, round(level * _FULL / 100))
    return {**_lit(segment, bri=_FULL), "bri": brightness} if segment.part == MASTER else _lit(segment, bri=brightness)


def _write_color(segment: _Segment, value: PlainValue) -> dict[str, object]:
    hue, saturation = require_color(value)
    rgb = [int(one) for one in from_hue_saturation("rgb", hue, saturation, _WHITE_RANGE)]
    return _lit(segment, col=[[*rgb, 0] if len(segment.channels or ()) == 4 else rgb])


def _write_white(segment: _Segment, value: PlainValue) -> dict[str, object]:
    kelvin = require_number("color_temperature", value, _WARMEST, _COLDEST, "K")
    white = [0, 0, 0, _FULL] if segment.abilities & _WHITE else [_FULL] * 3
    colors = {"col": [white]} if segment.abilities & _RGB else {}
    return _lit(segment, cct=round((kelvin - _WARMEST) / _STEP), **colors)


def _write_master(capability: str, value: PlainValue) -> dict[str, object]:
    if capability == "on_off":
        return {"on": require_bool(capability, value)}
    if capability != "level":
        raise RefusedError(shown(capability), "the whole controller takes on_off and level")
    level = require_number(capability, value, 0, 100, "%")
    return {"on": True, "bri": max(1, round(level * _FULL / 100))} if level else {"on": False}


def _hue_saturation(channels: tuple[float, ...]) -> tuple[float, float]:
    white = channels[3] if len(channels) == 4 else 0.0
    return to_hue_saturation("rgb", tuple(min(_FULL, one + white) for one in channels[:3]), _WHITE_RANGE)


def _flag(value: object) -> bool | None:
    return value if isinstance(value, bool) else None


def _byte(value: object) -> float | None:
    number = to_number(value) if not isinstance(value, str) else None
    return number if number is not None and 0 <= number <= _FULL else None


def _percent(level: float | None) -> float | None:
    return None if level is None else round(level * 100 / _FULL, 1)
