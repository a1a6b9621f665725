"""Sirens that Zigbee2MQTT knows: what exposes a ``warning``. Pure.

Source: zigbee-herdsman-converters 26.105.0, ``warning``; what is not told is as Zigbee2MQTT 2.14.1 has Home Assistant
tell it. A siren never says whether it sounds.
"""

from __future__ import annotations

from dataclasses import dataclass

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.zigbee2mqtt.device_topics import Zigbee2MqttTopics
from homebot.conventions.zigbee2mqtt.expose import Expose
from homebot.devices.value import PlainValue

__all__ = ["build_siren"]


def build_siren(part: JsonPart, topics: Zigbee2MqttTopics, warning: Expose) -> DescribedPart:
    """Describe a siren."""
    mode = warning.feature("mode")
    tones = tuple(one for one in mode.options if one != _SILENT) if mode is not None else ()
    siren = _Siren(topics, warning.key, tones)
    part.add_capability("on_off", readable=False, writer=siren.switch)
    if tones:
        part.add_capability("siren_tone", readable=False, writer=siren.sound, options=tones)
    if warning.feature("level") is not None:
        part.add_capability("volume", readable=False, writer=siren.set_volume)
    part.add_command_topics(topics.command)
    return part.build()


_SILENT = "stop"
_TONE = "emergency"
_SECONDS = 10
_LEVELS = ((25.0, "low"), (50.0, "medium"), (75.0, "high"), (100.0, "very_high"))


@dataclass(frozen=True, slots=True)
class _Siren:
    """The commands of a siren. Tone and volume also turn it on."""

    topics: Zigbee2MqttTopics
    key: str
    tones: tuple[str, ...]

    def switch(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        if require_bool("on_off", value):
            return self._warn()
        return self.topics.publish({self.key: {"mode": _SILENT}})

    def sound(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return self._warn(tone=require_option("siren_tone", value, self.tones))

    def set_volume(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        percent = require_number("volume", value, 0, 100, "%")
        return self._warn(level=next(level for most, level in _LEVELS if percent <= most))

    def _warn(self, *, tone: str = "", level: str = "medium") -> tuple[Publication, ...]:
        usual = _TONE if _TONE in self.tones or not self.tones else self.tones[0]
        return self.topics.publish({self.key: {"mode": tone or usual, "level": level, "duration": _SECONDS}})
