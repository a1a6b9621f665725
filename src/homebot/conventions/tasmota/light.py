"""Lamps with Tasmota firmware. Pure.

Source: tasmota.github.io/docs, Lights; hatasmota 0.10.2, ``light.py``; rounding as Home Assistant core 2025.4,
``components/tasmota/light.py``.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from homebot.conventions.command_values import require_bool, require_color, require_number, require_option
from homebot.conventions.decode import NO_READINGS, JsonMessage, Readings
from homebot.conventions.description import Publication
from homebot.conventions.light_color import kelvin_mired, mired_bounds
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.tasmota.config import LIGHT, TasmotaConfig
from homebot.conventions.tasmota.device_topics import TasmotaTopics
from homebot.conventions.tasmota.fade_speed import FadeTarget, LampState, speed_for
from homebot.devices.value import PlainValue
from homebot.numbers import finite_number

__all__ = ["add_light"]


def add_light(part: JsonPart, topics: TasmotaTopics, index: int) -> None:
    """Have *part* be the lamp at the output *index*."""
    lamp = _lamp(topics, index)
    for topic in topics.states:
        part.read_from(topic, lamp.read)
    part.add_command_topics(topics.topic("Backlog"))
    part.add_capability("on_off", writer=lamp.switch)
    if lamp.kind != _ON_OFF:
        part.add_capability("level", writer=lamp.dim)
    if lamp.has_white:
        part.add_capability("color_temperature", writer=lamp.set_white, bounds=lamp.kelvins)
    if lamp.has_color:
        part.add_capability("color", writer=lamp.set_color)
        part.add_capability("effect", writer=lamp.play, options=_EFFECTS)
    part.add_state_request(*topics.state_requests)


_ON_OFF, _DIMMER, _WHITES, _COLOR, _COLOR_WHITE, _COLOR_WHITES = range(6)
_EFFECTS = ("Solid", "Wake up", "Cycle up", "Cycle down", "Random")
_MIRED = (153, 500)
_REDUCED_MIRED = (200, 380)
_REDUCED_MIRED_OPTION, _DIMMERS_OPTION, _POWER_APART_OPTION = 82, 68, 20
_FIXED_FADE_OPTION = 117
_PAIR = 2


@dataclass(frozen=True, slots=True)
class _TasmotaLamp:
    """The state and the commands of one lamp.

    Attributes:
        topics: Its topics.
        index: Which output it is.
        kind: Its light type.
        dimmer: The command for its brightness.
        dimmer_key: What its brightness is called in messages.
        last_state: What it said last; a command that shall take time depends on it.
    """

    topics: TasmotaTopics
    index: int
    kind: int
    dimmer: str
    dimmer_key: str
    last_state: LampState = field(default_factory=LampState)

    @property
    def has_white(self) -> bool:
        return self.kind in (_WHITES, _COLOR_WHITES)

    @property
    def has_color(self) -> bool:
        return self.kind >= _COLOR

    @property
    def kelvins(self) -> tuple[float, ...]:
        coldest, warmest = self._mireds
        return mired_bounds(coldest, warmest)

    @property
    def _mireds(self) -> tuple[int, int]:
        return _REDUCED_MIRED if self.topics.config.option(_REDUCED_MIRED_OPTION) else _MIRED

    def read(self, message: JsonMessage) -> Readings:
        found = dict(self.topics.read_power(self.index, message))
        self.last_state.update(
            found.get("on_off"), message.get(self.dimmer_key), message.get("Color"), message.get("CT")
        )
        if self.kind == _ON_OFF:
            return found
        level = finite_number(message.get(self.dimmer_key))
        if level is not None and 0 < level <= 100:
            found["level"] = level
        found.update(self._read_color(message))
        scheme = message.get("Scheme")
        if self.has_color and isinstance(scheme, int) and 0 <= scheme < len(_EFFECTS):
            found["effect"] = _EFFECTS[scheme]
        return found

    def switch(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        on = require_bool("on_off", value)
        return self._publish([self._power(on)], transition, FadeTarget(on=on))

    def dim(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        """Rounded twice, by way of 0 to 255, as Home Assistant does."""
        percent = require_number("level", value, 0, 100, "%")
        if not percent:
            return self._publish([self._power(on=False)], transition, FadeTarget(on=False))
        steps = max(1, round(round(255 * percent / 100) / 255 * 100))
        apart = [self._power(on=True)] if self.topics.config.option(_POWER_APART_OPTION) else []
        return self._publish([(self.dimmer, steps), *apart], transition, FadeTarget(level=steps))

    def set_white(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        kelvin = require_number("color_temperature", value, 1_000, 40_000, "K")
        mired = kelvin_mired(int(kelvin))
        return self._publish([self._power(on=True), ("CT", mired)], transition, FadeTarget(mired=mired))

    def set_color(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        hue, saturation = require_color(value)
        color_commands: list[tuple[str, str | int]] = [("HsbColor1", round(hue)), ("HsbColor2", round(saturation))]
        return self._publish([self._power(on=True), *color_commands], transition, FadeTarget(color=(hue, saturation)))

    def play(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        scheme = _EFFECTS.index(require_option("effect", value, _EFFECTS))
        return self._publish([self._power(on=True), ("Scheme", scheme)], transition, FadeTarget())

    def _power(self, on: bool) -> tuple[str, str | int]:  # noqa: FBT001 - it is what the command says
        return f"Power{self.index + 1}", self.topics.state_text(on)

    def _publish(
        self, commands: list[tuple[str, str | int]], transition: float, target: FadeTarget
    ) -> tuple[Publication, ...]:
        """Tell it to fade first: ``Fade2`` and ``Speed2`` are for the next change only."""
        if not transition or self.kind == _ON_OFF or self.topics.config.is_tuya:
            return self.topics.publish_all(commands)
        is_whole = self.topics.config.option(_FIXED_FADE_OPTION)
        distance = 1.0 if is_whole else self.last_state.distance(target, self.kind, self._mireds)
        return self.topics.publish_all([("Fade2", 1), ("Speed2", speed_for(transition, distance)), *commands])

    def _read_color(self, message: JsonMessage) -> Readings:
        """One with colours and white shows a colour while its white is at 0."""
        shows_white = self.kind in (_COLOR_WHITE, _COLOR_WHITES) and message.get("White") not in (None, 0)
        found: dict[str, PlainValue] = {}
        if self.has_color and not shows_white and (color := _hue_saturation(message.get("HSBColor"))):
            found["color"] = color
            if self.has_white:
                found["color_temperature"] = None
        mired = finite_number(message.get("CT"))
        if self.has_white and mired is not None and mired > 0 and (shows_white or not self.has_color):
            found["color_temperature"] = float(kelvin_mired(mired))
        if self.has_color and shows_white:
            found["color"] = None
        return found or NO_READINGS


def _lamp(topics: TasmotaTopics, index: int) -> _TasmotaLamp:
    """One device may be several lamps: each channel a dimmer, or colours and then white where they are not linked."""
    config = topics.config
    if config.option(_DIMMERS_OPTION):
        channel = f"Channel{index + 1}"
        return _TasmotaLamp(topics, index, _DIMMER, channel, channel)
    place = _place(config, index)
    if config.light_type >= _COLOR_WHITE and not config.is_linked and place < _PAIR:
        white = _DIMMER if config.light_type == _COLOR_WHITE else _WHITES
        dimmer = f"Dimmer{place + 1}"
        return _TasmotaLamp(topics, index, white if place else _COLOR, dimmer, dimmer)
    kind = config.light_type if _ON_OFF <= config.light_type <= _COLOR_WHITES else _ON_OFF
    return _TasmotaLamp(topics, index, kind, "Dimmer3" if config.is_tuya else "Dimmer", "Dimmer")


def _place(config: TasmotaConfig, index: int) -> int:
    """Return how many lamps come before the one at *index*."""
    return index - config.outputs.index(LIGHT)


def _hue_saturation(value: object) -> tuple[float, float] | None:
    """Return the first two of ``hue,saturation,brightness``."""
    if not isinstance(value, str) or len(value) > _MAX_COLOR:
        return None
    try:
        hue, saturation, _ = (float(one) for one in value.split(","))
    except ValueError:
        return None
    return (hue, saturation) if 0 <= hue <= 360 and 0 <= saturation <= 100 else None


_MAX_COLOR = 40
