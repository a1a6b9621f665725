"""The component ``alarm_control_panel``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/alarm_control_panel.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.gateways.mqtt.description import DescribedPart, Publication
from homebot.gateways.mqtt.homeassistant.command_topic import CommandTopic
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.homeassistant.entity import Entity
from homebot.gateways.mqtt.readings import NOTHING, Readings
from homebot.gateways.mqtt.wanted import wanted_option

__all__ = ["build_alarm_control_panel"]


def build_alarm_control_panel(config: Config) -> DescribedPart:
    """Describe an alarm. What wants a code cannot be told: there is nowhere to have it from."""
    source = config.required_source("state_topic")
    features = frozenset(config.options("supported_features") if config.has("supported_features") else _FEATURES)
    listens = _Listening(
        config.required_command(),
        {
            word: config.text(f"payload_{action}", action.upper())
            for word, action in _TOLD.items()
            if action == "disarm" or action in features
        },
        frozenset(
            word
            for word, action in _TOLD.items()
            if config.has("code") and config.flag(f"code_{action.partition('_')[0]}_required", default=True)
        ),
    )

    def read(text: str) -> Readings:
        if text == "None":
            return {"alarm": None}
        return {"alarm": text} if text in _STATES else NOTHING

    entity = Entity(config, "x_alarm_panel")
    entity.offers("alarm", readable=entity.hears(source, read), writer=listens.set, options=_STATES)
    entity.listens_at(listens.command)
    return entity.described()


_TOLD = {
    "disarmed": "disarm",
    "armed_home": "arm_home",
    "armed_away": "arm_away",
    "armed_night": "arm_night",
    "armed_vacation": "arm_vacation",
    "armed_custom_bypass": "arm_custom_bypass",
    "triggered": "trigger",
}
_FEATURES = tuple(action for action in _TOLD.values() if action != "disarm")
_STATES = (*_TOLD, "pending", "arming", "disarming")


@dataclass(frozen=True, slots=True)
class _Listening:
    """Tells the alarm."""

    command: CommandTopic
    payloads: Mapping[str, str]
    coded: frozenset[str]

    def set(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        word = wanted_option("alarm", value, self.payloads)
        if word in self.coded:
            raise RefusedError(f"alarm {word}", "it wants a code")
        action = self.payloads[word]
        told = action if self.command.template is None else None
        return (self.command.publication(told, {"action": action, "code": None}),)
