"""The component ``siren``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/siren.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.topics import CommandTopic
from homebot.conventions.payload import Readings, compact_json, fields_of, number_of
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["build_siren"]


def build_siren(config: DiscoveryConfig) -> DescribedPart:
    """Describe a siren, which is commanded in JSON where it has no template."""
    on = config.required_command()
    off = config.required_command(template_key="command_off_template")
    payloads = {True: config.text("payload_on", "ON"), False: config.text("payload_off", "OFF")}
    tones = config.options("available_tones")
    commands = _SirenCommands(on, off if off.template is not None else on, payloads, tones)
    decoder = _SirenStateDecoder(
        {
            config.text("state_on") or payloads[True]: True,
            config.text("state_off") or payloads[False]: False,
            "None": None,
        },
        tones,
        has_volume=config.flag("support_volume_set", default=True),
    )
    entity = Entity(config, "siren")
    readable = entity.read_text_from(config.source("state_topic", "state_value_template"), decoder.read)
    entity.add_capability("on_off", readable=readable, writer=commands.switch)
    if tones:
        entity.add_capability("siren_tone", readable=readable, writer=commands.sound, options=tones)
    if decoder.has_volume:
        entity.add_capability("volume", readable=readable, writer=commands.set_volume)
    entity.add_commands(on)
    return entity.build()


@dataclass(frozen=True, slots=True)
class _SirenCommands:
    """The commands of a siren. Tone and volume also turn it on, as they do in Home Assistant."""

    on: CommandTopic
    off: CommandTopic
    payloads: Mapping[bool, str]
    tones: tuple[str, ...]

    def switch(self, value: PlainValue, _transition: float) -> Publications:
        return self._publish(on=require_bool("on_off", value))

    def sound(self, value: PlainValue, _transition: float) -> Publications:
        return self._publish(tone=require_option("siren_tone", value, self.tones))

    def set_volume(self, value: PlainValue, _transition: float) -> Publications:
        return self._publish(volume_level=require_number("volume", value, 0, 100, "%") / 100)

    def _publish(self, *, on: bool = True, **fields: object) -> Publications:
        command = self.on if on else self.off
        variables = {"state": self.payloads[on], **fields}
        if command.template is None:
            return command.publish(compact_json(variables))
        publication = command.publication(self.payloads[on], variables)
        if publication.payload in _EMPTY_PAYLOADS:
            raise RefusedError(f"a command on {command.topic}", "its template renders nothing for it")
        return (publication,)


@dataclass(frozen=True, slots=True)
class _SirenStateDecoder:
    """Reads what the siren reports: a plain text, or an object with ``state`` and more."""

    states: Mapping[str, bool | None]
    tones: tuple[str, ...]
    has_volume: bool

    def read(self, text: str) -> Readings:
        if text in self.states:
            return {"on_off": self.states[text]}
        message = fields_of(text)
        found: dict[str, PlainValue] = {}
        state, tone, volume = message.get("state"), message.get("tone"), number_of(message.get("volume_level"))
        if isinstance(state, str) and state in self.states:
            found["on_off"] = self.states[state]
        if isinstance(tone, str) and tone in self.tones:
            found["siren_tone"] = tone
        if self.has_volume and volume is not None and 0 <= volume <= 1:
            found["volume"] = volume * 100
        return found


_EMPTY_PAYLOADS = (b"", b"None")
