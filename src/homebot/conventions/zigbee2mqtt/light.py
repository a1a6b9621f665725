"""A lamp that Zigbee2MQTT knows. Pure.

Source: zigbee2mqtt.io, Usage > Exposes > light; brightness and colours are rounded as for Home Assistant's JSON lamps,
so that both conventions send the same message.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.command_values import require_bool, require_color, require_number, require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.light_color import (
    CHANNELS,
    KelvinRange,
    from_hue_saturation,
    kelvin_mired,
    mired_bounds,
    to_hue_saturation,
)
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings
from homebot.conventions.zigbee2mqtt.expose import Expose, Scalar
from homebot.conventions.zigbee2mqtt.features import Zigbee2MqttPart, Zigbee2MqttTopics, flag_of, text_of
from homebot.devices.value import PlainValue
from homebot.support.numbers import finite_number

__all__ = ["FEATURES_OF_LIGHT", "build_light"]

FEATURES_OF_LIGHT = frozenset({"state", "brightness", "color_temp", "color_xy", "color_hs"})


def build_light(part: Zigbee2MqttPart, light: Expose, effect: Expose | None) -> DescribedPart:
    """Describe a lamp; *effect* is the enum of its effects."""
    features = {one.name: one for one in light.features if one.name in FEATURES_OF_LIGHT}
    lamp = _Zigbee2MqttLamp(part.topics, features, light.suffix, _color_mode(light), effect)
    state = features.get("state")
    is_readable = state is not None and state.is_published
    part.read_from(part.topics.state, lamp.read)
    part.add_command_topics(part.topics.command)
    part.add_capability("on_off", readable=is_readable, writer=lamp.switch)
    if "brightness" in features:
        part.add_capability("level", readable=is_readable, writer=lamp.set_level)
    if "color_temp" in features:
        part.add_capability("color_temperature", writer=lamp.set_white, bounds=_kelvins(features["color_temp"]))
    if lamp.mode:
        part.add_capability("color", writer=lamp.set_color)
    if effect is not None:
        part.add_capability(
            "effect", readable=effect.is_published, writer=lamp.set_effect, options=tuple(effect.options)
        )
    part.request(*features.values())
    return part.build()


@dataclass(frozen=True, slots=True)
class _Zigbee2MqttLamp:
    """Reader and writers of one lamp; its colour mode is ``xy``, ``hs`` or empty."""

    topics: Zigbee2MqttTopics
    features: Mapping[str, Expose]
    suffix: str
    mode: str
    effect: Expose | None

    def read(self, message: JsonMessage) -> Readings:
        """Read the brightness; 0 is that of a lamp that is off, and is no report."""
        found: dict[str, PlainValue] = dict(self._read_state(message))
        brightness = self.features.get("brightness")
        if brightness is not None:
            level = finite_number(message.get(brightness.key))
            if level is not None and level > 0:
                found["level"] = min(100.0, level * 100 / _full(brightness))
        found.update(self._read_color(message))
        if self.effect is not None and (played := text_of(message.get(self.effect.key))):
            found["effect"] = played
        return found

    def _read_state(self, message: JsonMessage) -> Readings:
        state = self.features.get("state")
        if state is None or state.key not in message:
            return NO_READINGS
        value = message[state.key]
        on = flag_of(state, value)
        return {"on_off": on} if on is not None or value is None else NO_READINGS

    def switch(self, value: PlainValue, transition: float) -> Publications:
        return self._publish({}, transition, on=require_bool("on_off", value))

    def set_level(self, value: PlainValue, transition: float) -> Publications:
        """Set a brightness that is rounded twice, by way of 0 to 255, as Home Assistant does."""
        percent = require_number("level", value, 0, 100, "%")
        if not percent:
            return self._publish({}, transition, on=False)
        brightness = self.features["brightness"]
        steps = max(1, round(round(255 * percent / 100) * _full(brightness) / 255))
        return self._publish({brightness.key: steps}, transition)

    def set_white(self, value: PlainValue, transition: float) -> Publications:
        low, high = _kelvins(self.features["color_temp"]) or _KELVIN
        kelvin = require_number("color_temperature", value, min(low, _KELVIN[0]), max(high, _KELVIN[1]), "K")
        return self._publish({self.features["color_temp"].key: kelvin_mired(int(kelvin))}, transition)

    def set_color(self, value: PlainValue, transition: float) -> Publications:
        hue, saturation = require_color(value)
        channels = from_hue_saturation(self.mode, hue, saturation, _NO_WHITE)
        color = dict(zip(CHANNELS[self.mode], channels, strict=True))
        return self._publish({self._color_property: color}, transition)

    def set_effect(self, value: PlainValue, transition: float) -> Publications:
        if self.effect is None:
            return ()
        option: Scalar = self.effect.options[require_option("effect", value, self.effect.options)]
        return self._publish({self.effect.key: option}, transition)

    @property
    def _color_property(self) -> str:
        return self.features[f"color_{self.mode}"].key

    def _publish(self, message: Mapping[str, object], transition: float, *, on: bool = True) -> Publications:
        state = self.features.get("state")
        state_fields = {} if state is None else {state.key: state.value_on if on else state.value_off}
        return self.topics.publish({**state_fields, **message}, transition)

    def _only_mode(self, message: JsonMessage) -> str:
        """Return the only mode with a value in the message; empty for none or several."""
        white = self.features.get("color_temp")
        has_white = white is not None and message.get(white.key) is not None
        color = message.get(self._color_property) if self.mode else None
        if not isinstance(color, dict):
            return "color_temp" if has_white else ""
        return "" if has_white else next((mode for mode in _COLOR_MODES if _hue_saturation(mode, color)), "")

    def _read_color(self, message: JsonMessage) -> Readings:
        """Read the colour of the reported ``color_mode``, or of the only mode with a value.

        The other values in the message are outdated.
        """
        white = self.features.get("color_temp")
        mode = message.get(f"color_mode{self.suffix}")
        if mode is None:
            mode = self._only_mode(message)
        if mode == "color_temp" and white is not None:
            return self._read_white(finite_number(message.get(white.key)))
        if mode in _COLOR_MODES and self.mode:
            color = _hue_saturation(str(mode), message.get(self._color_property))
            if color is not None:
                return {"color": color} | ({"color_temperature": None} if white is not None else {})
        return NO_READINGS

    def _read_white(self, mired: float | None) -> Readings:
        if mired is None or not 0 < mired <= _MOST_MIRED:
            return NO_READINGS
        return {"color_temperature": float(kelvin_mired(mired))} | ({"color": None} if self.mode else {})


_COLOR_MODES = ("xy", "hs")
_NO_WHITE: KelvinRange = (2_000, 6_535)
"""Only colours with channels of white need it."""

_MOST_MIRED = 1_000_000
_KELVIN = (1_000.0, 40_000.0)
_FULL = 254.0


def _color_mode(light: Expose) -> str:
    """Return the mode that the device names first."""
    return next((one.name.removeprefix("color_") for one in light.features if one.name in ("color_xy", "color_hs")), "")


def _full(brightness: Expose) -> float:
    return brightness.most if brightness.most is not None and brightness.most >= 1 else _FULL


def _kelvins(white: Expose) -> tuple[float, ...]:
    if white.least is None or white.most is None or not 1 <= white.least <= white.most <= _MOST_MIRED:
        return ()
    return mired_bounds(white.least, white.most)


def _hue_saturation(mode: str, color: object) -> tuple[float, float] | None:
    if not isinstance(color, dict):
        return None
    keys, bounds = (("x", "y"), (1.0, 1.0)) if mode == "xy" else (("hue", "saturation"), (360.0, 100.0))
    first, second = (finite_number(color.get(key, color.get(key[0]))) for key in keys)
    if first is None or second is None or not (0 <= first <= bounds[0] and 0 <= second <= bounds[1]):
        return None
    return to_hue_saturation(mode, (first, second), _NO_WHITE)
