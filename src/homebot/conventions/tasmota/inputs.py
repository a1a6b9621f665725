"""Switches and buttons that are wired to a Tasmota device. Pure.

Source: tasmota.github.io/docs, Buttons and Switches; hatasmota 0.10.2, ``switch.py`` and ``button.py``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial

from homebot.conventions.description import AutoExpiry, DescribedPart
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, as_fields, clean_text
from homebot.conventions.tasmota.config import TasmotaConfig, sensor_values

__all__ = ["describe_inputs"]


def describe_inputs(config: TasmotaConfig) -> Iterable[DescribedPart]:
    """Describe the contacts, and the presses of switches and buttons."""
    for index, mode in enumerate(config.switch_modes):
        if mode in _FOLLOWED:
            yield _contact(config, index, mode)
        if mode in _PRESSED:
            actions = {config.state_texts[place]: press for place, press in _PRESSED[mode].items()}
            name = _switch_name(config, index)
            yield _presses(config, f"switch_{index + 1}_press", f"Switch{index + 1}", name, actions)
    if config.option(_BUTTONS_OPTION):
        for index, is_there in enumerate(config.buttons):
            if is_there:
                report = f"Button{index + 1}"
                yield _presses(config, f"button_{index + 1}", report, report, _button_actions(config))


_TOGGLE, _HOLD = 2, 3
"""Places in a device's texts of states."""

_PULSES = frozenset({13, 14})
"""Modes of inputs that report on and never off."""

_FOLLOWED = frozenset({1, 2, 3, 4, 5, 6, 9, 10, 13, 14, 15, 16})
"""Modes in which the input's state is reported."""

_SINGLE = {_TOGGLE: "single"}
_PRESSED: Mapping[int, Mapping[int, str]] = {
    0: _SINGLE,
    3: _SINGLE,
    4: _SINGLE,
    5: {_TOGGLE: "single", _HOLD: "hold"},
    6: {_TOGGLE: "single", _HOLD: "hold"},
    7: _SINGLE,
    8: {_TOGGLE: "single", _HOLD: "double"},
    9: {_HOLD: "double"},
    10: {_HOLD: "double"},
    11: _SINGLE,
    12: _SINGLE,
}
"""Modes that report presses, with the meaning of each text."""

_BUTTONS_OPTION, _SWAP_OPTION, _SINGLE_ONLY_OPTION = 73, 11, 13
_BUTTON_ACTIONS: Mapping[str, str] = {
    "SINGLE": "single",
    "DOUBLE": "double",
    "TRIPLE": "triple",
    "QUAD": "quadruple",
    "PENTA": "quintuple",
    "HOLD": "hold",
}
_PULSE_SECONDS = 1.0


def _switch_name(config: TasmotaConfig, index: int) -> str:
    names = config.switch_names
    return (names[index] if index < len(names) else "") or f"Switch{index + 1}"


def _contact(config: TasmotaConfig, index: int, mode: int) -> DescribedPart:
    name = _switch_name(config, index)
    part = JsonPart(f"switch_{index + 1}", "x_binary_sensor", name=clean_text(name), advertised="switch")
    read = partial(_read_state, config.state_texts[0], config.state_texts[1], name)
    part.add_capability("state")
    if mode in _PULSES:
        for topic in config.results(f"Switch{index + 1}"):
            part.read_events_from(topic, read)
        part.add_expiry(AutoExpiry("state", _PULSE_SECONDS, value=False, only=True))
    else:
        for topic in (*config.results(f"Switch{index + 1}"), *config.sensors):
            part.read_from(topic, read)
        part.add_state_request(*config.sensor_requests)
    return part.build()


def _read_state(off: str, on: str, name: str, message: JsonMessage) -> Readings:
    """Read the action on one topic, the bare text on the others."""
    value = sensor_values(message).get(name)
    text = value.get("Action") if isinstance(value, dict) else value
    if not isinstance(text, str) or text not in (off, on):
        return NO_READINGS
    return {"state": text == on}


def _button_actions(config: TasmotaConfig) -> Mapping[str, str]:
    if config.option(_SINGLE_ONLY_OPTION):
        return {"SINGLE": "single"}
    if config.option(_SWAP_OPTION):
        return {**_BUTTON_ACTIONS, "SINGLE": "double", "DOUBLE": "single"}
    return _BUTTON_ACTIONS


def _presses(config: TasmotaConfig, part_id: str, report: str, name: str, actions: Mapping[str, str]) -> DescribedPart:
    part = JsonPart(part_id, "generic_switch", name=clean_text(name), advertised="button")
    for topic in config.results(report):
        part.read_events_from(topic, partial(_read_press, name, actions))
    part.add_capability("press", options=tuple(dict.fromkeys(actions.values())))
    return part.build()


def _read_press(name: str, actions: Mapping[str, str], message: JsonMessage) -> Readings:
    action = as_fields(message.get(name)).get("Action")
    return {"press": actions[action]} if isinstance(action, str) and action in actions else NO_READINGS
