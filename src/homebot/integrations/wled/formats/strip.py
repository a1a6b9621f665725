"""A WLED controller and its segments: parts and values from its JSON documents, and documents that command it. Pure.

A controller has a master switch and dimmer, and segments with brightness, colours and effects of their own. One with a
single segment is one lamp; with several, the master is a lamp that can be dimmed and each segment is another.

Source: WLED, JSON API (https://kno.wled.ge/interfaces/json-api): state, info and segment objects, light capabilities;
0.13 to 16. The white of ``cct`` has 256 steps of 32 K from 1900 K on. Presets: https://kno.wled.ge/features/presets.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from homebot.conventions.command_values import require_bool, require_option, require_transition
from homebot.conventions.lamp import LightCommand, LightFeatures, WhiteRange
from homebot.conventions.light_color import to_hue_saturation
from homebot.conventions.payload import Readings, as_fields, clean_text, text_of
from homebot.devices.identity import identifiers, in_pairs
from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.support.numbers import to_number, whole_number

Fields = Mapping[str, object]

MASTER = ""
"""The part that is the whole controller."""

MAX_NAME_CHARACTERS = 60

_RGB, _WHITE, _CCT = 1, 2, 4
_MAX_SEGMENTS = 64
_FULL = 255
_WARMEST, _STEP = 1900, 32
_COLDEST = _WARMEST + _FULL * _STEP
_WHITES = WhiteRange((_WARMEST, _COLDEST), (float(_WARMEST), float(_COLDEST)))

MASTER_FEATURES = LightFeatures(frozenset({"brightness"}), _WHITES, most_seconds=math.inf)
"""The features of a controller with several segments."""


@dataclass(frozen=True, slots=True)
class WledSegment:
    """A segment with LEDs.

    Attributes:
        abilities: Bits: 1 colours, 2 a channel of white, 4 whites of different temperature.
        effects: The names of its effects, by number; those that cannot be chosen are empty.
    """

    id: int
    part: str
    name: str
    abilities: int
    fields: Fields
    effects: tuple[str, ...]

    @property
    def features(self) -> LightFeatures:
        """Its capabilities."""
        modes = {"brightness"} | ({"color_temp"} if self.abilities & _CCT else set())
        return LightFeatures(
            frozenset(modes | ({"rgb"} if self.abilities & _RGB else set())),
            _WHITES,
            effects=tuple(dict.fromkeys(effect for effect in self.effects if effect)),
            only_in_bounds=True,
            most_seconds=math.inf,
        )

    def read(self, state: Fields) -> Readings:
        """Return its readings in the *state* of the controller."""
        master, own_on = read_master(state), _flag(self.fields.get("on", True))
        master_on, own_level = master["on_off"], _byte(self.fields.get("bri", _FULL))
        master_level = _byte(state.get("bri")) if self.part == MASTER else _FULL
        level = None if own_level is None or master_level is None else own_level * master_level / _FULL
        readings = {
            "on_off": None if master_on is None or own_on is None else master_on and own_on,
            "level": _percent(level),
            **self._read_colors(),
        }
        if self.effects:
            number = self.fields.get("fx")
            is_known = isinstance(number, int) and 0 <= number < len(self.effects)
            readings["effect"] = (self.effects[number] or None) if is_known and isinstance(number, int) else None
        return readings

    def write(self, command: LightCommand) -> dict[str, object]:
        """Return the state of the controller that carries out *command*."""
        if not command.on:
            return {"on": False} if self.part == MASTER else {"seg": [{"id": self.id, "on": False}]}
        fields: dict[str, object] = {"id": self.id, "on": True}
        whole: dict[str, object] = {"on": True, "seg": [fields]}
        if command.color:
            rgb = [int(channel) for channel in command.color]
            fields["col"] = [[*rgb, 0] if len(self._channels or ()) == 4 else rgb]
        elif command.white is not None:
            fields["cct"] = round((command.white - _WARMEST) / _STEP)
            if self.abilities & _RGB:
                fields["col"] = [[0, 0, 0, _FULL] if self.abilities & _WHITE else [_FULL] * 3]
        if command.level is not None:
            fields["bri"] = command.brightness
            if self.part == MASTER:
                fields["bri"], whole["bri"] = _FULL, command.brightness
        if command.effect:
            fields["fx"] = self.effects.index(command.effect)
        return whole

    def _read_colors(self) -> dict[str, PlainValue]:
        channels, steps = self._channels, _byte(self.fields.get("cct"))
        readings: dict[str, PlainValue] = {}
        if self.abilities & _RGB:
            readings["color"] = None
            if channels is not None:
                white = channels[3] if len(channels) == 4 else 0.0
                rgb = tuple(min(_FULL, channel + white) for channel in channels[:3])
                readings["color"] = to_hue_saturation("rgb", rgb, _WHITES.kelvins)
        if self.abilities & _CCT:
            is_white = channels is not None and len(set(channels[:3])) == 1
            shows_white = is_white or not self.abilities & _RGB
            readings["color_temperature"] = _WARMEST + _STEP * steps if steps is not None and shows_white else None
        return readings

    @property
    def _channels(self) -> tuple[float, ...] | None:
        """The first of its three colours: red, green, blue and perhaps white; None if it is invalid."""
        colors = self.fields.get("col")
        first = colors[0] if isinstance(colors, list) and colors else None
        if not isinstance(first, list) or len(first) not in {3, 4}:
            return None
        channels = tuple(channel for channel in map(_byte, first) if channel is not None)
        return channels if len(channels) == len(first) else None


def read_master(state: Fields) -> dict[str, PlainValue]:
    """Return switch and level of the whole controller."""
    return {"on_off": _flag(state.get("on")), "level": _percent(_byte(state.get("bri")))}


def find_segments(state: Fields, leds: Fields, effects: tuple[str, ...]) -> Iterator[WledSegment]:
    """Yield the segments with LEDs; a single one is the master part."""
    listed = state.get("seg")
    given = [segment for segment in listed if isinstance(segment, dict)] if isinstance(listed, list) else []
    lit = [segment for segment in given[:_MAX_SEGMENTS] if segment.get("stop") != 0]
    known = leds.get("seglc")
    by_place = isinstance(known, list) and len(known) == len(lit)
    seen: set[int] = set()
    for place, fields in enumerate(lit):
        number = whole_number(fields.get("id", place))
        if number is None or not 0 <= number < _FULL or number in seen:
            continue
        seen.add(number)
        part = MASTER if len(lit) == 1 else f"segment:{number}"
        abilities = _abilities(fields, leds, place if by_place else number)
        yield WledSegment(number, part, text_of(fields.get("n"), MAX_NAME_CHARACTERS), abilities, fields, effects)


def _abilities(segment: Fields, leds: Fields, place: int) -> int:
    """Return the abilities of a segment: from 16 on it names them itself, before 0.13 no segment does."""
    known = leds.get("seglc")
    of_place = known[place] if isinstance(known, list) and place < len(known) else None
    for abilities in (segment.get("lc"), of_place, leds.get("lc")):
        if isinstance(abilities, int) and not isinstance(abilities, bool) and 0 <= abilities <= _FULL:
            return abilities
    return _RGB | (_WHITE if leds.get("rgbw") is True else 0)


def _flag(value: object) -> bool | None:
    return value if isinstance(value, bool) else None


def _byte(value: object) -> float | None:
    number = to_number(value) if not isinstance(value, str) else None
    return number if number is not None and 0 <= number <= _FULL else None


def _percent(level: float | None) -> float | None:
    return None if level is None else round(level * 100 / _FULL, 1)


_NO_PRESETS: Mapping[int, str] = MappingProxyType({})
_MAX_EFFECTS, _MAX_PRESETS = 300, 250
_MAX_TRANSITION_S = 65.5
_NO_EFFECTS = frozenset({"RSVD", "-", ""})
_ON_OFF = Capability(name="on_off", settable=True)


def _own(part_id: str, name: str, service_type: str, category: Category, capability: Capability = _ON_OFF) -> Part:
    """Return the part of a value of the controller besides its light."""
    return Part(id=part_id, name=name, service_type=service_type, category=category, capabilities=(capability,))


_SWITCHES: Final[Mapping[tuple[str, str], Part]] = {
    ("udpn", "send"): _own("sync_send", "Sends its state to others", "switch", "config"),
    ("udpn", "recv"): _own("sync_receive", "Takes the state of others", "switch", "config"),
    ("nl", "on"): _own("nightlight", "Night light", "switch", "config"),
}
"""By object and field of the state."""

_PATHS = {switch.id: path for path, switch in _SWITCHES.items()}

_PRESET = "preset"
_LIVE: Final = _own("live", "Lit by another program", "x_binary_sensor", "diagnostic", Capability(name="state"))
_SIGNAL: Final = _own("signal", "", "x_sensor", "diagnostic", Capability(name="signal_strength"))


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
        self._segments = {
            segment.part: segment for segment in find_segments(state, as_fields(info.get("leds")), self._effects)
        }

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
        return identifiers((in_pairs(text_of(self._info.get("mac"))),))

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
        described = [
            _lamp(segment.part, segment.name, "segment", segment.features) for segment in self._segments.values()
        ]
        if MASTER not in self._segments:
            described.insert(0, _lamp(MASTER, "", "wled", MASTER_FEATURES))
        return (*described, *(extra for extra, _ in self._extras()))

    def readings(self) -> Iterator[tuple[str, Readings]]:
        """Yield the reports of each part, by its id."""
        for segment in self._segments.values():
            yield segment.part, segment.read(self._state)
        if MASTER not in self._segments:
            yield MASTER, read_master(self._state)
        for extra, value in self._extras():
            yield extra.id, {extra.capabilities[0].name: value}

    def write(self, part: str, values: Mapping[str, PlainValue], transition: float) -> dict[str, object]:
        """Return the state to send so that *part* gets all *values*, of which only a light has several.

        Raises:
            RefusedError: There is no such part, it cannot do that, or the value is out of its bounds.
        """
        seconds = min(require_transition(transition), _MAX_TRANSITION_S)
        given: dict[str, object] = {"tt": round(seconds * 10)} if seconds else {}
        capability, value = next(iter(values.items()))
        if capability == "on_off" and part in _PATHS:
            owner, field = _PATHS[part]
            return {owner: {field: require_bool(capability, value)}}
        if part == _PRESET and self._presets and capability == "option":
            name = require_option(capability, value, self._presets.values())
            return given | {"ps": next(number for number, preset in self._presets.items() if preset == name)}
        if part in self._segments:
            segment = self._segments[part]
            return given | segment.write(segment.features.joint_command(values))
        if part != MASTER:
            raise RefusedError(f"a command to {part[:60]!r}", "the device has no such part any more")
        command = MASTER_FEATURES.joint_command(values)
        return given | {"on": command.on} | ({} if command.level is None else {"bri": command.brightness})

    def _extras(self) -> Iterator[tuple[Part, PlainValue]]:
        for (owner, field), switch in _SWITCHES.items():
            if isinstance(is_on := as_fields(self._state.get(owner)).get(field), bool):
                yield switch, is_on
        if self._presets:
            options = Capability(name="option", settable=True, options=tuple(self._presets.values()))
            numbers = (number for field in ("pl", "ps") if isinstance(number := self._state.get(field), int))
            shown = next((self._presets[number] for number in numbers if number in self._presets), None)
            preset = _own(_PRESET, "Preset", "x_setting", "config", options)
            yield preset.model_copy(update={"fades": True}), shown
        if isinstance(is_live := self._info.get("live"), bool):
            yield _LIVE, is_live
        wifi = as_fields(self._info.get("wifi"))
        if "rssi" in wifi:
            yield _SIGNAL, to_number(wifi["rssi"])


def effect_names(document: object) -> tuple[str, ...]:
    """Return the names of effects by number; those that cannot be chosen are empty.

    Args:
        document: The answer to ``/json/eff``: a list of texts; any other document has no effects.
    """
    names: list[str] = []
    for effect in document[:_MAX_EFFECTS] if isinstance(document, list) else ():
        name = text_of(effect, 40).partition("@")[0]
        names.append("" if name in _NO_EFFECTS or name in names else name)
    return tuple(names)


def preset_names(document: object) -> dict[int, str]:
    """Return the names of the presets and playlists by number, each name once; of two, the later has its number too.

    Args:
        document: The answer to ``/presets.json``: objects by number. The one of 0 is none.
    """
    names: dict[int, str] = {}
    for key, fields in as_fields(document).items():
        if not (isinstance(fields, dict) and key.isascii() and key.isdecimal() and 0 < int(key[:4]) <= _MAX_PRESETS):
            continue
        own = fields.get("n")
        name = clean_text(own, MAX_NAME_CHARACTERS) if isinstance(own, str) and own.strip() else f"Preset {key}"
        names[int(key)] = f"{name} ({key})" if name in names.values() else name
    return names


def _lamp(part: str, name: str, advertised: str, features: LightFeatures) -> Part:
    capabilities = tuple(
        Capability(name=capability, settable=True, **more) for capability, more in features.abilities().items()
    )
    return Part(id=part, name=name, service_type="light", advertised=advertised, capabilities=capabilities, fades=True)
