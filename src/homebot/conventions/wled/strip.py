"""A WLED controller: its parts and values from its JSON documents, and the documents that command it. Pure.

A controller has a master switch and dimmer, and segments with brightness, colours and effects of their own. One with a
single segment is one lamp; with several, the master is a lamp that can be dimmed and each segment is another.

Source: WLED, JSON API (https://kno.wled.ge/interfaces/json-api): state, segment and info objects, light capabilities;
0.13 to 16. The white of ``cct`` has 256 steps of 32 K from 1900 K on.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.conventions.command_values import (
    require_bool,
    require_color,
    require_number,
    require_option,
    require_transition,
)
from homebot.conventions.light_color import from_hue_saturation, to_hue_saturation
from homebot.conventions.payload import Readings, as_fields, shown, text_of
from homebot.conventions.wled.presets import shown_preset
from homebot.devices.identity import identifiers
from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.support.numbers import to_number

__all__ = ["MASTER", "Fields", "WledStrip", "effect_names"]

Fields = Mapping[str, object]

MASTER = ""
"""The part that is the whole controller."""

_PRESET = "preset"
_NO_PRESETS: Mapping[int, str] = MappingProxyType({})

_RGB, _WHITE, _CCT = 1, 2, 4
_MOST_SEGMENTS = 64
_MOST_EFFECTS = 300
_LONGEST_TRANSITION = 65.5
_FULL = 255
_CHANNELS = (3, 4)
_WARMEST, _STEP = 1900, 32
_COLDEST = _WARMEST + _FULL * _STEP
_WHITE_RANGE = (_WARMEST, _COLDEST)
_NO_EFFECTS = frozenset({"RSVD", "-", ""})

_ON_OFF = Capability(name="on_off", settable=True)
_LEVEL = Capability(name="level", settable=True)
_COLOR = Capability(name="color", settable=True)
_TEMPERATURE = Capability(name="color_temperature", settable=True, bounds=(float(_WARMEST), float(_COLDEST)))

_SWITCHES: Mapping[str, tuple[str, str, str]] = {
    "sync_send": ("udpn", "send", "Sends its state to others"),
    "sync_receive": ("udpn", "recv", "Takes the state of others"),
    "nightlight": ("nl", "on", "Night light"),
}
"""Settings that are switches: the object and its field in the state, and a name."""


@dataclass(frozen=True, slots=True)
class _Segment:
    """A segment that lights LEDs.

    Attributes:
        id: Its number.
        part: The id of its part.
        name: Its name for people; empty if it has none.
        abilities: Bits: 1 colours, 2 a white channel, 4 whites of different temperature.
        fields: Its object in the state.
    """

    id: int
    part: str
    name: str
    abilities: int
    fields: Fields


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
        self._segments = tuple(_segments(state, as_fields(info.get("leds"))))

    def with_state(self, state: Fields) -> WledStrip:
        """Return the same controller in another state."""
        return WledStrip({"state": state, "info": self._info}, self._effects, self._presets)

    @property
    def name(self) -> str:
        """Its name for people; empty if it does not say."""
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
        names = tuple(dict.fromkeys(one for one in self._effects if one))
        found = [
            Part(
                id=one.part,
                name=one.name,
                service_type="light",
                advertised="segment",
                capabilities=_capabilities(one.abilities, names),
            )
            for one in self._segments
        ]
        if not found or found[0].id != MASTER:
            found.insert(0, Part(id=MASTER, service_type="light", advertised="wled", capabilities=(_ON_OFF, _LEVEL)))
        for part_id, (owner, field, name) in _SWITCHES.items():
            if field in as_fields(self._state.get(owner)):
                found.append(_extra(part_id, "switch", "config", name, _ON_OFF))
        if self._presets:
            options = tuple(self._presets.values())
            choice = Capability(name="option", settable=True, options=options)
            found.append(_extra(_PRESET, "x_setting", "config", "Preset", choice))
        if isinstance(self._info.get("live"), bool):
            found.append(
                _extra("live", "x_binary_sensor", "diagnostic", "Lit by another program", Capability(name="state"))
            )
        if "rssi" in as_fields(self._info.get("wifi")):
            found.append(_extra("signal", "x_sensor", "diagnostic", "", Capability(name="signal_strength")))
        return tuple(found)

    def readings(self) -> Iterator[tuple[str, Readings]]:
        """Yield the reports of each part, by its id."""
        for one in self._segments:
            yield one.part, self._read_segment(one)
        if not any(one.part == MASTER for one in self._segments):
            level = _percent(_byte(self._state.get("bri")))
            yield MASTER, {"on_off": _flag(self._state.get("on")), "level": level}
        for part_id, (owner, field, _) in _SWITCHES.items():
            if isinstance(value := as_fields(self._state.get(owner)).get(field), bool):
                yield part_id, {"on_off": value}
        if self._presets:
            yield _PRESET, {"option": shown_preset(self._state, self._presets)}
        if isinstance(live := self._info.get("live"), bool):
            yield "live", {"state": live}
        wifi = as_fields(self._info.get("wifi"))
        if "rssi" in wifi:
            yield "signal", {"signal_strength": to_number(wifi["rssi"])}

    def write(self, part: str, capability: str, value: PlainValue, transition: float) -> dict[str, object]:
        """Return the state to send so that *capability* of *part* becomes *value*.

        Raises:
            RefusedError: There is no such part, it cannot do that, or the value is out of its bounds.
        """
        given: dict[str, object] = {}
        if require_transition(transition):
            given["tt"] = round(min(transition, _LONGEST_TRANSITION) * 10)
        if part in _SWITCHES and capability == "on_off":
            owner, field, _ = _SWITCHES[part]
            return {owner: {field: require_bool(capability, value)}}
        if part == _PRESET and self._presets and capability == "option":
            chosen = require_option(capability, value, tuple(self._presets.values()))
            return given | {"ps": next(number for number, name in self._presets.items() if name == chosen)}
        segment = next((one for one in self._segments if one.part == part), None)
        if segment is not None:
            return given | self._write_segment(segment, capability, value)
        if part != MASTER:
            raise RefusedError(f"a command to {part[:60]!r}", "the device has no such part any more")
        return given | _write_master(capability, value)

    def _read_segment(self, segment: _Segment) -> Readings:
        fields = segment.fields
        master_on = _flag(self._state.get("on"))
        master_level = _byte(self._state.get("bri")) if segment.part == MASTER else _FULL
        own_level = _byte(fields.get("bri", _FULL))
        own_on = _flag(fields.get("on", True))
        level = None if own_level is None or master_level is None else own_level * master_level / _FULL
        found: dict[str, PlainValue] = {
            "on_off": None if master_on is None or own_on is None else master_on and own_on,
            "level": _percent(level),
        }
        channels = _first_color(fields.get("col"))
        is_white = channels is not None and len(set(channels[:3])) == 1
        if segment.abilities & _RGB:
            found["color"] = None if channels is None else _hue_saturation(channels)
        if segment.abilities & _CCT:
            steps = _byte(fields.get("cct"))
            shows_white = is_white or not segment.abilities & _RGB
            found["color_temperature"] = _WARMEST + _STEP * steps if steps is not None and shows_white else None
        if self._effects:
            number = fields.get("fx")
            is_known = isinstance(number, int) and 0 <= number < len(self._effects)
            found["effect"] = (self._effects[number] or None) if is_known and isinstance(number, int) else None
        return found

    def _write_segment(self, segment: _Segment, capability: str, value: PlainValue) -> dict[str, object]:
        own: dict[str, object] = {"id": segment.id}
        match capability:
            case "on_off":
                is_on = require_bool(capability, value)
                if segment.part == MASTER and not is_on:
                    return {"on": False}
                own["on"] = is_on
                return {"on": True, "seg": [own]} if is_on else {"seg": [own]}
            case "level":
                level = require_number(capability, value, 0, 100, "%")
                if level == 0:
                    return self._write_segment(segment, "on_off", value=False)
                own["on"] = True
                brightness = max(1, round(level * _FULL / 100))
                if segment.part == MASTER:
                    return {"on": True, "bri": brightness, "seg": [own | {"bri": _FULL}]}
                return {"on": True, "seg": [own | {"bri": brightness}]}
            case "color" if segment.abilities & _RGB:
                hue, saturation = require_color(value)
                rgb = [int(one) for one in from_hue_saturation("rgb", hue, saturation, _WHITE_RANGE)]
                has_white = len(_first_color(segment.fields.get("col")) or ()) == 4
                return {"on": True, "seg": [own | {"on": True, "col": [[*rgb, 0] if has_white else rgb]}]}
            case "color_temperature" if segment.abilities & _CCT:
                kelvin = require_number(capability, value, _WARMEST, _COLDEST, "K")
                own |= {"on": True, "cct": round((kelvin - _WARMEST) / _STEP)}
                if segment.abilities & _RGB:
                    own["col"] = [[0, 0, 0, _FULL] if segment.abilities & _WHITE else [_FULL] * 3]
                return {"on": True, "seg": [own]}
            case "effect" if self._effects:
                name = require_option(capability, value, [one for one in self._effects if one])
                return {"on": True, "seg": [own | {"on": True, "fx": self._effects.index(name)}]}
            case _:
                raise RefusedError(shown(capability), "this segment does not support it")


def effect_names(document: object) -> tuple[str, ...]:
    """Return the names of effects by number; those that cannot be chosen are empty.

    Args:
        document: The answer to ``/json/eff``: a list of texts; any other document has no effects.
    """
    if not isinstance(document, list):
        return ()
    names: list[str] = []
    for one in document[:_MOST_EFFECTS]:
        name = text_of(one, 40).partition("@")[0]
        names.append("" if name in _NO_EFFECTS or name in names else name)
    return tuple(names)


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
        yield _Segment(number, part, text_of(fields.get("n"), 60), abilities, fields)


def _abilities(segment: Fields, leds: Fields, place: int) -> int:
    """Return the abilities of a segment: from 16 on it names them itself, before 0.13 no segment does."""
    known = leds.get("seglc")
    of_place = known[place] if isinstance(known, list) and place < len(known) else None
    for one in (segment.get("lc"), of_place, leds.get("lc")):
        if isinstance(one, int) and not isinstance(one, bool) and 0 <= one <= _FULL:
            return one
    return _RGB | (_WHITE if leds.get("rgbw") is True else 0)


def _capabilities(abilities: int, effects: tuple[str, ...]) -> tuple[Capability, ...]:
    found = [_ON_OFF, _LEVEL]
    if abilities & _CCT:
        found.append(_TEMPERATURE)
    if abilities & _RGB:
        found.append(_COLOR)
    if effects:
        found.append(Capability(name="effect", settable=True, options=effects))
    return tuple(found)


def _extra(part_id: str, service_type: str, category: Category, name: str, capability: Capability) -> Part:
    return Part(id=part_id, name=name, service_type=service_type, category=category, capabilities=(capability,))


def _write_master(capability: str, value: PlainValue) -> dict[str, object]:
    if capability == "on_off":
        return {"on": require_bool(capability, value)}
    if capability != "level":
        raise RefusedError(shown(capability), "the whole controller takes on_off and level")
    level = require_number(capability, value, 0, 100, "%")
    return {"on": True, "bri": max(1, round(level * _FULL / 100))} if level else {"on": False}


def _first_color(colors: object) -> tuple[float, ...] | None:
    """Return the channels of the first of three colours: red, green and blue, with white where there is some."""
    first = colors[0] if isinstance(colors, list) and colors else None
    if not isinstance(first, list) or len(first) not in _CHANNELS:
        return None
    channels = tuple(one for one in map(_byte, first) if one is not None)
    return channels if len(channels) == len(first) else None


def _hue_saturation(channels: tuple[float, ...]) -> tuple[float, float]:
    white = channels[3] if len(channels) == len(_CHANNELS) + 2 else 0.0
    return to_hue_saturation("rgb", tuple(min(_FULL, one + white) for one in channels[:3]), _WHITE_RANGE)


def _flag(value: object) -> bool | None:
    return value if isinstance(value, bool) else None


def _byte(value: object) -> float | None:
    number = to_number(value) if not isinstance(value, str) else None
    return number if number is not None and 0 <= number <= _FULL else None


def _percent(level: float | None) -> float | None:
    return None if level is None else round(level * 100 / _FULL, 1)
