"""Thermostats that say apart whether they follow their program: one mode out of two properties. Pure.

Source: zigbee-herdsman-converters 26.105.0, Bosch BTH-RA, BTH-RM and BTH-RM230Z, as Zigbee2MQTT 2.14.1 announces them
to Home Assistant: paused is off, and what ``system_mode`` says counts only where the thermostat is in manual operation.
"""

from __future__ import annotations

from dataclasses import dataclass

from homebot.conventions.command_values import require_option
from homebot.conventions.decode import NO_READINGS, JsonMessage, Readings
from homebot.conventions.description import Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.zigbee2mqtt.device_topics import Zigbee2MqttTopics
from homebot.conventions.zigbee2mqtt.expose import Expose
from homebot.devices.value import PlainValue

__all__ = ["add_mode", "is_program"]

_MANUAL = "manual"
_MODES = {"schedule": "auto", "pause": "off"}
_OPTIONS = {mode: option for option, mode in _MODES.items()}
_PAIR = 2


def is_program(expose: Expose) -> bool:
    """Return whether *expose* says if a thermostat follows its program, is told by hand, or paused."""
    is_whole = expose.is_published and expose.is_settable
    return expose.name == "operating_mode" and is_whole and set(expose.options) == {_MANUAL, *_MODES}


def add_mode(part: JsonPart, topics: Zigbee2MqttTopics, mode: Expose, program: Expose) -> None:
    """Have *part* offer ``thermostat_mode``.

    Args:
        part: The part in the making.
        topics: The topics of its device.
        mode: The enum ``system_mode``.
        program: The enum ``operating_mode``.
    """
    by_hand = tuple(one for one in mode.options if one not in _OPTIONS)
    both = _Mode(topics, mode, program, by_hand)
    part.read_from(topics.state, both.read)
    part.add_capability("thermostat_mode", writer=both.write, options=("off", *by_hand, "auto"))
    part.add_command_topics(topics.command)


@dataclass(frozen=True, slots=True)
class _Mode:
    """The state of the mode and its commands; *by_hand* are those of manual operation."""

    topics: Zigbee2MqttTopics
    mode: Expose
    program: Expose
    by_hand: tuple[str, ...]

    def read(self, message: JsonMessage) -> Readings:
        if self.program.key not in message:
            return NO_READINGS
        reported = message[self.program.key]
        if reported is None:
            return {"thermostat_mode": None}
        if reported == _MANUAL:
            reported = message.get(self.mode.key)
            found = reported if reported in self.by_hand else self.by_hand[0] if len(self.by_hand) == 1 else None
        else:
            found = _MODES.get(reported) if isinstance(reported, str) else None
        return NO_READINGS if found is None else {"thermostat_mode": found}

    def write(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        target = require_option("thermostat_mode", value, ("off", *self.by_hand, "auto"))
        if target in _OPTIONS:
            return self.topics.publish({self.program.key: _OPTIONS[target]})
        further = {self.mode.key: self.mode.options[target]} if len(self.mode.options) >= _PAIR else {}
        return self.topics.publish({self.program.key: _MANUAL, **further})
