"""The values before commands: those that may come back are those that nothing else has changed since. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import closing
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias, final

from homebot.devices.capabilities import CAPABILITIES, LIGHTS_UP
from homebot.devices.command_messages import Setting
from homebot.devices.device import Device, State, target_of
from homebot.devices.journal_messages import GetCauses, GetCausesRequest, KnownCause
from homebot.devices.names import GET_CAUSES
from homebot.devices.value_comparison import fits
from homebot.errors import ServiceError

if TYPE_CHECKING:
    from homebot.devices.command_messages import CommandedPart
    from homebot.devices.value import PlainValue
    from homebot.graph import Node

RESTORED: Final = (
    *("on_off", "level", "color", "color_temperature", "fan_speed", "volume"),
    *("position", "tilt", "movement", "thermostat_mode", "preset_mode", "heating_setpoint", "cooling_setpoint"),
)
"""The values that an undo brings back, in this order. It opens nothing that was locked, and arms nothing."""

_WITHOUT_EFFECT: Final = frozenset({"refused", "gone"})
_NOT_SENT: Final = "already_so"


class KnownValue(NamedTuple):
    """A value, and the cause of its newest change; None if control has not seen it change."""

    state: State
    cause: KnownCause | None


KnownStates: TypeAlias = "Mapping[tuple[str, str, str], KnownValue]"
"""Values by device, part and capability."""


def plain_states(devices: Iterable[Device]) -> Mapping[tuple[str, str, str], State]:
    """Return the known values of *devices*."""
    return {(device.id, state.part, state.capability): state for device in devices for state in device.states}


async def known_states(node: Node, devices: Iterable[Device], *, from_journal: bool = False) -> KnownStates:
    """Return the known values of *devices*, each with its cause.

    Args:
        from_journal: Whether to look in the journal for changes that came before this homebot started.
    """
    devices, client = list(devices), node.create_client(GetCauses, GET_CAUSES)
    request = GetCausesRequest(devices=tuple([device.id for device in devices]), from_journal=from_journal)
    with closing(client):
        try:
            causes = (await client.call(request, timeout=10.0)).causes
        except ServiceError:
            causes = ()
    by_place = {(cause.device, cause.part, cause.capability): cause for cause in causes}
    known: dict[tuple[str, str, str], KnownValue] = {}
    for place, state in plain_states(devices).items():
        cause = by_place.get(place)
        known[place] = KnownValue(state, cause if cause is not None and cause.value == state.value else None)
    return known


@final
class UndoRecord:
    """The values before some commands.

    Args:
        entries: As JSON, for a store: by part and capability, the value before, the ids of the commands, and the value
            that was reported as commanded; it is updated.
    """

    def __init__(self, entries: dict[str, list[Any]] | None = None) -> None:
        self.entries = {} if entries is None else entries

    def add(self, states: KnownStates, commanded: Iterable[CommandedPart]) -> None:
        """Add the *states* before commands, or those before earlier ones that brought these about."""
        for part in commanded:
            if part.result.outcome not in _WITHOUT_EFFECT:
                reported = {setting.capability: setting.value.plain() for setting in part.result.reported}
                commands = [] if part.result.outcome == _NOT_SENT else [part.result.command_id]
                self._add(states, (part.device, part.part), commands, reported)

    def add_parts(
        self,
        states: KnownStates,
        parts: Mapping[tuple[str, str], Mapping[str, PlainValue]],
        commands: Iterable[str] = (),
    ) -> None:
        """Add the *states* before *commands* whose outcomes for *parts*, each with its wanted values, are not known."""
        for place, values in parts.items():
            self._add(states, place, [*commands], values)

    def _add(
        self, states: KnownStates, place: tuple[str, str], commands: list[str], told: Mapping[str, PlainValue]
    ) -> None:
        for capability in RESTORED:
            if (known := states.get((*place, capability))) is not None:
                key = f"{target_of(*place)} {capability}"
                entry = [known.state.value.plain(), commands, told.get(capability)]
                if (earlier := self.entries.pop(key, None)) and _is_own(known, earlier):
                    entry = [earlier[0], [*earlier[1], *commands], entry[2] if commands else earlier[2]]
                self.entries[key] = entry

    @property
    def devices(self) -> frozenset[str]:
        """The ids of the devices with values that may come back."""
        return frozenset([key.rpartition(" ")[0].partition("#")[0] for key in self.entries])

    def due(self, states: KnownStates) -> dict[tuple[str, str], tuple[Setting, ...]]:
        """Return the settings by part that bring back the values that nothing else has changed since; forget all."""
        by_part: dict[tuple[str, str], dict[str, PlainValue]] = {}
        for key, entry in self.entries.items():
            target, _, capability = key.rpartition(" ")
            device, _, part = target.partition("#")
            now, was = states.get((device, part, capability)), _plain(entry[0])
            is_known = was is not None and was not in CAPABILITIES[capability].only_reported
            if now is not None and is_known and now.state.value.plain() != was and _is_own(now, entry):
                by_part.setdefault((device, part), {})[capability] = was
        self.entries.clear()
        for place, values in by_part.items():
            power = states.get((*place, "on_off"))
            _stay_off(values, None if power is None else power.state)
        return {place: _settings(values) for place, values in by_part.items() if values}


def _stay_off(values: dict[str, PlainValue], power: State | None) -> None:
    """Leave out levels of a lamp that somebody else turned off, as they would turn it on."""
    if power is not None and power.value.plain() is False and "on_off" not in values:
        for capability in LIGHTS_UP:
            values.pop(capability, None)


def _is_own(known: KnownValue, entry: list[Any]) -> bool:
    """Return whether the commands of *entry* brought about the value."""
    commands, reported = entry[1], _plain(entry[2])
    is_as_told = reported is not None and fits(known.state.capability, reported, known.state.value.plain())
    if known.cause is None:  # since a restart nobody knows how old it is
        return known.state.is_first and is_as_told
    is_told = known.cause.command in commands if commands else is_as_told  # it ended before the outcomes were known
    return is_told and not known.cause.may_be_person and known.cause.cause != "program"


def _plain(value: Any) -> PlainValue:
    """Return a value that was JSON."""
    return tuple(value) if isinstance(value, list) else value


def _settings(values: dict[str, PlainValue]) -> tuple[Setting, ...]:
    if values.get("on_off") is False:
        return (Setting.of("on_off", False),)  # noqa: FBT003 - a level or a colour would turn it on again
    if "position" in values:
        values.pop("movement", None)
    return tuple([Setting.of(name, value) for name, value in values.items()])
