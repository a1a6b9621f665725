"""The components ``alarm_control_panel`` and ``siren``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt``: alarm_control_panel.py, siren.py.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from hmac import compare_digest

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.conversion import fields_of, number_of
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.topics import CommandTopic
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WrongCodeError

__all__ = ["build_alarm_control_panel", "build_siren"]


def build_alarm_control_panel(config: DiscoveryConfig) -> DescribedPart:
    """Describe an alarm. One that wants a code is told with one.

    A code that the config names must be that one; where it says ``REMOTE_CODE`` the alarm itself judges any.
    """
    source = config.required_source("state_topic")
    features = frozenset(config.options("supported_features") if config.has("supported_features") else _FEATURES)
    commands = _AlarmCommands(
        config.required_command(),
        {
            state: config.text(f"payload_{action}", action.upper())
            for state, action in _ACTIONS.items()
            if action == "disarm" or action in features
        },
        frozenset(
            state
            for state, action in _ACTIONS.items()
            if config.has("code") and config.flag(f"code_{action.partition('_')[0]}_required", default=True)
        ),
        config.text("code"),
    )

    def read(text: str) -> Readings:
        if text == "None":
            return {"alarm": None}
        return {"alarm": text} if text in _STATES else NO_READINGS

    entity = Entity(config, "x_alarm_panel")
    entity.add_coded_capability("alarm", commands.set, readable=entity.read_text_from(source, read), options=_STATES)
    entity.add_commands(commands.command)
    return entity.build()


_ACTIONS = {
    "disarmed": "disarm",
    "armed_home": "arm_home",
    "armed_away": "arm_away",
    "armed_night": "arm_night",
    "armed_vacation": "arm_vacation",
    "armed_custom_bypass": "arm_custom_bypass",
    "triggered": "trigger",
}
_FEATURES = tuple(action for action in _ACTIONS.values() if action != "disarm")
_REMOTE = frozenset({"REMOTE_CODE", "REMOTE_CODE_TEXT"})
_STATES = (*_ACTIONS, "pending", "arming", "disarming")


@dataclass(frozen=True, slots=True)
class _AlarmCommands:
    """The commands of an alarm."""

    command: CommandTopic
    payloads: Mapping[str, str]
    coded: frozenset[str]
    code: str = field(repr=False)

    def set(self, value: PlainValue, code: str) -> tuple[Publication, ...]:
        state = require_option("alarm", value, self.payloads)
        if state in self.coded:
            self._check(state, code)
        action = self.payloads[state]
        payload = action if self.command.template is None else None
        return (self.command.publication_with_code(payload, code, {"action": action}),)

    def _check(self, state: str, code: str) -> None:
        if not code:
            raise WrongCodeError(f"alarm {state}", "it wants a code")
        if self.code not in _REMOTE and not compare_digest(code.encode(), self.code.encode()):
            raise WrongCodeError(f"alarm {state}", "it wants another code")


def build_siren(config: DiscoveryConfig) -> DescribedPart:
    """Describe a siren, which is told in JSON where it has no template."""
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

    def switch(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return self._publish(on=require_bool("on_off", value))

    def sound(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return self._publish(tone=require_option("siren_tone", value, self.tones))

    def set_volume(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return self._publish(volume_level=require_number("volume", value, 0, 100, "%") / 100)

    def _publish(self, *, on: bool = True, **fields: object) -> tuple[Publication, ...]:
        command = self.on if on else self.off
        variables = {"state": self.payloads[on], **fields}
        if command.template is None:
            return (command.publication(json.dumps(variables, ensure_ascii=False, separators=(",", ":"))),)
        publication = command.publication(self.payloads[on], variables)
        if publication.payload in _EMPTY_PAYLOADS:
            raise RefusedError(f"a command on {command.topic}", "its template makes nothing of it")
        return (publication,)


@dataclass(frozen=True, slots=True)
class _SirenStateDecoder:
    """Reads what the siren says: a plain word, or an object with ``state`` and more."""

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
