"""A WLED controller: its parts and values from its JSON documents, and the documents that command it. Pure.

A controller has a master switch and dimmer, and segments with brightness, colours and effects of their own. One with a
single segment is one lamp; with several, the master is a lamp that can be dimmed and each segment is another.

Source: WLED, JSON API (https://kno.wled.ge/interfaces/json-api): state and info objects; 0.13 to 16. Presets:
https://kno.wled.ge/features/presets.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Final

from homebot.conventions.command_values import require_bool, require_option, require_transition
from homebot.conventions.lamp import LightFeatures
from homebot.conventions.payload import Readings, as_fields, clean_text, text_of
from homebot.devices.identity import identifiers, in_pairs
from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.wled.formats.segment import (
    MASTER,
    MASTER_FEATURES,
    MAX_NAME_CHARACTERS,
    Fields,
    find_segments,
    read_master,
)
from homebot.support.numbers import to_number

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
            yield _own(_PRESET, "Preset", "x_setting", "config", options), shown
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
    return Part(id=part, name=name, service_type="light", advertised=advertised, capabilities=capabilities)
