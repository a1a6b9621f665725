"""The values before commands: those that may come back are those that nothing else has changed since. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final, TypeAlias, final

from homebot.devices.capabilities import CAPABILITIES, LIGHTS_UP
from homebot.devices.command_messages import Setting
from homebot.devices.device import Device, State, target_of
from homebot.devices.obedience import fits

if TYPE_CHECKING:
    from homebot.devices.command_messages import CommandedPart
    from homebot.devices.value import PlainValue

__all__ = ["RESTORED", "EarlierValues", "KnownStates", "known_states"]

RESTORED: Final = (
    *("on_off", "level", "color", "color_temperature", "fan_speed", "volume"),
    *("position", "tilt", "movement", "heating_setpoint", "cooling_setpoint"),
)
"""The values that an undo brings back, in this order. It opens nothing that was locked, and arms nothing."""

_SETTLES: Final = 10.0
"""Seconds after a command in which further changes are still its own, such as the last steps of a dimmer."""

_ROUNDING: Final = 1e-5
"""Seconds by which the clock of a replay may be ahead of the stamps of devices."""

_TOLD: Final = 3
_WITHOUT_EFFECT: Final = frozenset({"refused", "gone"})
_NOT_SENT: Final = "already_so"

KnownStates: TypeAlias = "Mapping[tuple[str, str, str], State]"
"""Values by device, part and capability."""


def known_states(devices: Iterable[Device]) -> KnownStates:
    """Return the known values of *devices*."""
    return {(device.id, one.part, one.capability): one for device in devices for one in device.states}


@final
class EarlierValues:
    """The values before some commands.

    Args:
        entries: As JSON, for a store: by part and capability, the value before, when the command was given and ended,
            in seconds since the Unix epoch, and the value that was reported as commanded; it is updated.
    """

    def __init__(self, entries: dict[str, list[Any]] | None = None) -> None:
        self.entries = {} if entries is None else entries

    def add(self, states: KnownStates, commanded: Iterable[CommandedPart], given_at: float, ended_at: float) -> None:
        """Add the *states* before commands, or those before earlier ones that brought these about."""
        for one in commanded:
            kind = one.result.outcome
            if kind not in _WITHOUT_EFFECT:
                told = {each.capability: each.value.plain() for each in one.result.reported}
                self._add(states, (one.device, one.part), given_at, ended_at, None if kind == _NOT_SENT else told)

    def add_parts(
        self, states: KnownStates, parts: Iterable[tuple[str, str]], given_at: float, ended_at: float
    ) -> None:
        """Add the *states* before a command of which the outcome for each of *parts* is not known."""
        for place in parts:
            self._add(states, place, given_at, ended_at, {})

    def _add(
        self,
        states: KnownStates,
        place: tuple[str, str],
        given_at: float,
        ended_at: float,
        told: Mapping[str, PlainValue] | None,
    ) -> None:
        """Add the states of a place; *told* is None if nothing was sent: no later change is its own."""
        until = ended_at - _SETTLES if told is None else ended_at
        for capability in RESTORED:
            if (state := states.get((*place, capability))) is not None:
                key = f"{target_of(*place)} {capability}"
                entry = [state.value.plain(), given_at, until, (told or {}).get(capability)]
                if (earlier := self.entries.pop(key, None)) and _is_own(state, earlier):
                    entry = earlier if told is None else [*earlier[:2], *entry[2:]]
                self.entries[key] = entry

    def due(self, states: KnownStates) -> dict[tuple[str, str], tuple[Setting, ...]]:
        """Return the settings by part that bring back the values that nothing else has changed since; forget all."""
        found: dict[tuple[str, str], dict[str, PlainValue]] = {}
        for key, entry in self.entries.items():
            target, _, capability = key.rpartition(" ")
            device, _, part = target.partition("#")
            now, was = states.get((device, part, capability)), _plain(entry[0])
            is_known = was is not None and was not in CAPABILITIES[capability].only_reported
            if now is not None and is_known and now.value.plain() != was and _is_own(now, entry):
                found.setdefault((device, part), {})[capability] = was
        self.entries.clear()
        for place, values in found.items():
            _stay_off(values, states.get((*place, "on_off")))
        return {place: _settings(values) for place, values in found.items() if values}


def _stay_off(values: dict[str, PlainValue], power: State | None) -> None:
    """Leave out levels of a lamp that somebody else turned off, as they would turn it on."""
    if power is not None and power.value.plain() is False and "on_off" not in values:
        for capability in LIGHTS_UP:
            values.pop(capability, None)


def _is_own(state: State, entry: list[Any]) -> bool:
    """Return whether the command of *entry* brought about the value of *state*."""
    given_at, ended_at, told = entry[1], entry[2], _plain(entry[3]) if len(entry) > _TOLD else None
    at, is_as_told = state.since.to_seconds(), told is not None and fits(state.capability, told, state.value.plain())
    if not given_at - _ROUNDING <= at <= ended_at + _SETTLES:
        return state.is_first and is_as_told  # since a restart nobody knows how old it is
    return at <= ended_at or told is None or is_as_told


def _plain(value: Any) -> PlainValue:
    """Return a value that was JSON."""
    return tuple(value) if isinstance(value, list) else value


def _settings(values: dict[str, PlainValue]) -> tuple[Setting, ...]:
    if values.get("on_off") is False:
        return (Setting.of("on_off", False),)  # noqa: FBT003 - a level or a colour would turn it on again
    if "position" in values:
        values.pop("movement", None)
    return tuple([Setting.of(name, value) for name, value in values.items()])
