"""A lamp that Zigbee2MQTT knows. Pure.

Source: zigbee2mqtt.io, Usage > Exposes > light; brightness and colours are rounded as for Home Assistant's JSON lamps,
so that both conventions send the same message.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.lamp import MAX_FADE_S, LightCommand, LightFeatures, WhiteRange
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
    colors = [feature.name for feature in light.features if feature.name in ("color_xy", "color_hs")]
    mode = colors[0].removeprefix("color_") if colors else ""
    lamp = _Zigbee2MqttLamp(part.topics, features, light.suffix, mode, effect)
    part.read_from(part.topics.state, lamp.read)
    modes = {name for name in ("brightness", "color_temp") if name in features} | ({lamp.mode} if lamp.mode else set())
    white = features.get("color_temp")
    state = features.get("state")
    switched = ("on_off", "level") if state and state.is_published else ()
    effects = ("effect",) if effect and effect.is_published else ()
    LightFeatures(
        modes=frozenset(modes or {"onoff"}),
        white=WhiteRange(_NO_WHITE, _kelvins(white) if white else ()),
        effects=tuple(effect.options) if effect else (),
        is_dimmable="brightness" in features,
        most_seconds=MAX_FADE_S if part.topics.takes_transition else 0.0,
    ).add_to(part, frozenset({"color_temperature", "color", *switched, *effects}), lamp.publish)
    part.request(*features.values())
    return part.build()


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
        readings: dict[str, PlainValue] = {}
        state = self.features.get("state")
        if state is not None and state.key in message:
            on = flag_of(state, message[state.key])
            if on is not None or message[state.key] is None:
                readings["on_off"] = on
        brightness = self.features.get("brightness")
        if brightness is not None:
            level = read_finite(message.get(brightness.key))
            if level is not None and level > 0:
                readings["level"] = min(100.0, level * 100 / _full(brightness))
        readings.update(self._read_color(message))
        if self.effect is not None and (played := text_of(message.get(self.effect.key))):
            readings["effect"] = played
        return readings

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
            mired = finite_number(message.get(white.key))
            if mired is None or not 0 < mired <= _MAX_MIRED:
                return NO_READINGS
            return {"color_temperature": float(kelvin_mired(mired))} | ({"color": None} if self.mode else {})
        if mode in _COLOR_MODES and self.mode:
            color = _hue_saturation(str(mode), message.get(self._color_property))
            if color is not None:
                return {"color": color} | ({"color_temperature": None} if white is not None else {})
        return NO_READINGS


_COLOR_MODES = ("xy", "hs")
_NO_WHITE: KelvinRange = (2_000, 6_535)
"""Only colours with channels of white need it."""

_MAX_MIRED = 1_000_000
_FULL = 254.0


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
