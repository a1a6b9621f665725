"""The values before commands: those that may come back are those that nothing else has changed since. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final, TypeAlias, final

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.command_messages import Setting
from homebot.devices.device import Device, State, target_of

if TYPE_CHECKING:
    from homebot.devices.value import PlainValue

__all__ = ["RESTORED", "EarlierValues", "KnownStates", "known_states"]

RESTORED: Final = (
    *("on_off", "level", "color", "color_temperature", "fan_speed", "volume"),
    *("position", "tilt", "movement", "heating_setpoint", "cooling_setpoint"),
)
"""What an undo brings back, in this order. It opens nothing that was locked, and arms nothing."""

_SETTLES: Final = 10.0
"""Seconds after a command in which further changes are still its own, such as the last steps of a dimmer."""

_ROUNDING: Final = 1e-5
"""Seconds by which the clock of a replay may be ahead of the stamps of devices."""

KnownStates: TypeAlias = "Mapping[tuple[str, str, str], State]"
"""Values by device, part and capability."""


def known_states(devices: Iterable[Device]) -> KnownStates:
    """Return the known values of *devices*."""
    return {(device.id, one.part, one.capability): one for device in devices for one in device.states}


@final
class EarlierValues:
    """The values before some commands.

    Args:
        entries: As JSON, for a store: by part and capability, the value before, and when the command was given and
            ended, in seconds since the Unix epoch; it is updated.
    """

    def __init__(self, entries: dict[str, list[Any]] | None = None) -> None:
        self.entries = {} if entries is None else entries

    def add(self, states: KnownStates, parts: Iterable[tuple[str, str]], given_at: float, ended_at: float) -> None:
        """Add the *states* before a command to *parts*, or those before an earlier one that brought these about."""
        for device, part in parts:
            for capability in RESTORED:
                if (state := states.get((device, part, capability))) is not None:
                    key = f"{target_of(device, part)} {capability}"
                    earlier = self.entries.pop(key, None)
                    was, since = earlier[:2] if earlier and _is_own(state, earlier) else (state.value.plain(), given_at)
                    self.entries[key] = [was, since, ended_at]

    def take(self, states: KnownStates) -> dict[tuple[str, str], tuple[Setting, ...]]:
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
        return {place: _settings(values) for place, values in found.items()}


def _is_own(state: State, entry: list[Any]) -> bool:
    """Return whether the command of *entry* brought about the value of *state*."""
    _, given_at, ended_at = entry
    return bool(given_at - _ROUNDING <= state.since.to_seconds() <= ended_at + _SETTLES)


def _plain(value: Any) -> PlainValue:
    """Return a value that was JSON."""
    return tuple(value) if isinstance(value, list) else value


def _settings(values: dict[str, PlainValue]) -> tuple[Setting, ...]:
    if values.get("on_off") is False:
        return (Setting.of("on_off", False),)  # noqa: FBT003 - a level or a colour would turn it on again
    if "position" in values:
        values.pop("movement", None)
    return tuple([Setting.of(name, value) for name, value in values.items()])
