"""The component ``alarm_control_panel``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/alarm_control_panel.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from hmac import compare_digest

from homebot.conventions.command_values import require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.topics import CommandTopic
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.value import PlainValue
from homebot.errors import WrongCodeError

__all__ = ["build_alarm_control_panel"]


def build_alarm_control_panel(config: DiscoveryConfig) -> DescribedPart:
    """Describe an alarm. One that wants a code is commanded with one.

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

    def set(self, value: PlainValue, code: str) -> Publications:
        state = require_option("alarm", value, self.payloads)
        if state in self.coded:
            self._check(state, code)
        action = self.payloads[state]
        payload = action if self.command.template is None else None
        return (self.command.publication_with_code(payload, code, {"action": action}),)

    def _check(self, state: str, code: str) -> None:
        if not code:
            raise WrongCodeError(f"alarm {state}", "it needs a code")
        if self.code not in _REMOTE and not compare_digest(code.encode(), self.code.encode()):
            raise WrongCodeError(f"alarm {state}", "the code is wrong")
