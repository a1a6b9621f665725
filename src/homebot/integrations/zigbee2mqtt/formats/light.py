"""A lamp that Zigbee2MQTT knows. Pure.

Source: zigbee2mqtt.io, Usage > Exposes > light; brightness and colours are rounded as for Home Assistant's JSON lamps,
so that both conventions send the same message.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.lamp import LightCommand, LightFeatures, WhiteRange
from homebot.conventions.light_color import CHANNELS, KelvinRange, kelvin_mired, mired_bounds, to_hue_saturation
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings
from homebot.devices.value import PlainValue
from homebot.integrations.zigbee2mqtt.formats.expose import Expose
from homebot.integrations.zigbee2mqtt.formats.features import (
    Zigbee2MqttPart,
    Zigbee2MqttTopics,
    flag_of,
    read_finite,
    text_of,
)
from homebot.support.numbers import finite_number


def build_light(part: Zigbee2MqttPart, light: Expose, effect: Expose | None) -> DescribedPart:
    """Describe a lamp; *effect* is the enum of its effects."""
    features = {feature.name: feature for feature in light.own_features}
    lamp = _Zigbee2MqttLamp(part.topics, features, light.suffix, _color_mode(light), effect)
    part.read_from(part.topics.state, lamp.read)
    modes = {name for name in ("brightness", "color_temp") if name in features} | ({lamp.mode} if lamp.mode else set())
    white = features.get("color_temp")
    LightFeatures(
        modes=frozenset(modes or {"onoff"}),
        white=WhiteRange(_NO_WHITE, _kelvins(white) if white else ()),
        effects=tuple(effect.options) if effect else (),
        is_dimmable="brightness" in features,
    ).add_to(part, _readable(features.get("state"), effect), lamp.publish)
    part.request(*features.values())
    return part.build()


def _readable(state: Expose | None, effect: Expose | None) -> frozenset[str]:
    """Return the capabilities that the lamp reports; whites and colours always."""
    switched = ("on_off", "level") if state and state.is_published else ()
    effects = ("effect",) if effect and effect.is_published else ()
    return frozenset({"color_temperature", "color", *switched, *effects})


@dataclass(frozen=True, slots=True)
class _Zigbee2MqttLamp:
    """Reader and writer of one lamp; its colour mode is ``xy``, ``hs`` or empty."""

    topics: Zigbee2MqttTopics
    features: Mapping[str, Expose]
    suffix: str
    mode: str
    effect: Expose | None

    def publish(self, command: LightCommand) -> Publications:
        """Encode a command; the brightness is rounded twice, by way of 0 to 255, as Home Assistant does."""
        message: dict[str, object] = {}
        state = self.features.get("state")
        if state is not None:
            message[state.key] = state.value_on if command.on else state.value_off
        if command.brightness is not None:
            brightness = self.features["brightness"]
            message[brightness.key] = max(1, round(command.brightness * _full(brightness) / 255))
        if command.kelvin is not None:
            message[self.features["color_temp"].key] = kelvin_mired(command.kelvin)
        if command.color:
            message[self._color_property] = dict(zip(CHANNELS[command.mode], command.color, strict=True))
        if command.effect and self.effect is not None:
            message[self.effect.key] = self.effect.options[command.effect]
        return self.topics.publish(message, command.transition or 0.0)

    def read(self, message: JsonMessage) -> Readings:
        """Read the brightness; 0 is that of a lamp that is off, and is no report."""
        readings: dict[str, PlainValue] = dict(self._read_state(message))
        brightness = self.features.get("brightness")
        if brightness is not None:
            level = read_finite(message.get(brightness.key))
            if level is not None and level > 0:
                readings["level"] = min(100.0, level * 100 / _full(brightness))
        readings.update(self._read_color(message))
        if self.effect is not None and (played := text_of(message.get(self.effect.key))):
            readings["effect"] = played
        return readings

    def _read_state(self, message: JsonMessage) -> Readings:
        state = self.features.get("state")
        if state is None or state.key not in message:
            return NO_READINGS
        value = message[state.key]
        on = flag_of(state, value)
        return {"on_off": on} if on is not None or value is None else NO_READINGS

    @property
    def _color_property(self) -> str:
        return self.features[f"color_{self.mode}"].key

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
        if mired is None or not 0 < mired <= _MAX_MIRED:
            return NO_READINGS
        return {"color_temperature": float(kelvin_mired(mired))} | ({"color": None} if self.mode else {})


_COLOR_MODES = ("xy", "hs")
_NO_WHITE: KelvinRange = (2_000, 6_535)
"""Only colours with channels of white need it."""

_MAX_MIRED = 1_000_000
_FULL = 254.0


def _color_mode(light: Expose) -> str:
    return next(
        (feature.name.removeprefix("color_") for feature in light.features if feature.name in ("color_xy", "color_hs")),
        "",
    )


def _full(brightness: Expose) -> float:
    return brightness.most if brightness.most is not None and brightness.most >= 1 else _FULL


def _kelvins(white: Expose) -> tuple[float, ...]:
    if white.least is None or white.most is None or not 1 <= white.least <= white.most <= _MAX_MIRED:
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
