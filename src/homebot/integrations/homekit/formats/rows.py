"""Rows: the capabilities of services, with what reads and sets them. Pure."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeAlias

from homebot.conventions.capability_row import CapabilityRow
from homebot.conventions.command_values import require_option
from homebot.conventions.units import number_grid
from homebot.devices.capabilities import CAPABILITIES, EVENTS
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.integrations.homekit.formats.accessory import HapService

Writes: TypeAlias = Mapping[str, float]
"""Values of characteristics, by their types."""


ServiceRow: TypeAlias = CapabilityRow[
    HapService, Callable[[HapService], PlainValue], Callable[[HapService, Command], Writes]
]
"""A capability of the services that have its characteristics; it is watched by their types."""


def service_row(
    services: str,
    capability: str,
    watched: str,
    target: str = "",
    values: Mapping[int, str] | None = None,
    read: Callable[[HapService], PlainValue] | None = None,
    write: Callable[[HapService, Command], Writes] | None = None,
    options: Callable[[HapService], tuple[str, ...]] | None = None,
    bounds: Callable[[HapService], tuple[float, ...]] | None = None,
    grid: Callable[[HapService], tuple[float, ...]] | None = None,
    when: Callable[[HapService], object] | None = None,
    unit: str = "",
) -> ServiceRow:
    """Return the row of a capability.

    Args:
        services: The types of the services, separated by spaces; empty for any.
        watched: The types of the characteristics that its value depends on, separated by spaces; a service without the
            first one does not have the capability.
        target: The characteristic by which it is set; empty for none.
        values: The texts of a capability by the numbers in *target*, or the first watched one.
        read: Returns its value; by default the value of the first watched one.
        write: Returns what a command that fits the capability sets; by default the value itself in *target*.
        options: Returns the texts that it has, if *values* are not all.
        bounds: Returns the bounds of its value; by default those of *target* or the vocabulary.
        grid: Returns the grid of its value; by default that of *target*.
    """
    kinds, types, is_number = watched.split(), services.split(), CAPABILITIES[capability].kind == "number"
    first = kinds[0]

    def applies(service: HapService) -> bool:
        is_of_row = first in service.characteristics and (not types or service.type in types)
        return is_of_row and (when is None or bool(when(service)))

    def of_number(values_of: Callable[[HapService], tuple[float, ...]]) -> Callable[[HapService], tuple[float, ...]]:
        return lambda service: values_of(service) if is_number and service.can(target, "pw") else ()

    return ServiceRow(
        capability,
        read or partial(_read, capability, first, values),
        write or partial(_write, capability, target, values),
        applies,
        options or (lambda service: tuple(known_values(service, target or first, values or {}).values())),
        of_number(bounds or partial(_bounds, capability, target, is_own=write is None)),
        unit,
        of_number(grid or partial(_grid, target)),
        readable=lambda service: capability in EVENTS or "pr" in service.characteristics[first].perms,
        settable=lambda service: service.can(target, "pw"),
        watched=tuple(kinds),
    )


def _read(capability: str, kind: str, values: Mapping[int, str] | None, service: HapService) -> PlainValue:
    """Return the value of a characteristic, or the last event; None for unknown."""
    if values is None and CAPABILITIES[capability].kind == "number":
        return read_number(capability, kind, service)
    value = service.number(kind)
    if value is None:
        return None
    return value != 0 if values is None else values.get(int(value))


def _write(
    capability: str, target: str, values: Mapping[int, str] | None, service: HapService, command: Command
) -> Writes:
    value = command.value
    if values is not None:
        raw = {text: number for number, text in known_values(service, target, values).items()}
        return {target: raw[require_option(capability, value.text, raw)]}
    return {target: value.number if CAPABILITIES[capability].kind == "number" else float(value.flag)}


def _bounds(capability: str, target: str, service: HapService, *, is_own: bool) -> tuple[float, ...]:
    usual, own = CAPABILITIES[capability].bounds, service.characteristics[target].bounds
    is_narrower = own and (not usual or (usual[0] <= own[0] and own[1] <= usual[1]))
    return own if is_narrower and is_own else usual or own


def _grid(target: str, service: HapService) -> tuple[float, ...]:
    characteristic = service.characteristics[target]
    return number_grid(sum(characteristic.bounds[:1]), characteristic.step)


def known_values(service: HapService, kind: str, values: Mapping[int, str]) -> dict[int, str]:
    """Return those of the *values* that a characteristic can have."""
    characteristic = service.characteristics.get(kind)
    if characteristic is None:
        return {}
    least, most = characteristic.bounds or (0.0, 2.0**32)
    return {
        raw: text
        for raw, text in values.items()
        if raw in (characteristic.valid_values or (raw,)) and least <= raw <= most
    }


def read_number(capability: str, kind: str, service: HapService) -> float | None:
    """Return the value of a characteristic if it is in the bounds of a capability."""
    least, most = CAPABILITIES[capability].bounds or (-1e9, 1e9)
    value = service.number(kind)
    return round(value, 4) if value is not None and least <= value <= most else None
