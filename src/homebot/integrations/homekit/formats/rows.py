"""Rows: the capabilities of services, with what reads and sets them. Pure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from homebot.conventions.command_values import require_option
from homebot.conventions.units import number_grid
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.integrations.homekit.formats.accessory import HapService

__all__ = ["ServiceRow", "Writes", "known_values", "read_number"]

Writes: TypeAlias = Mapping[str, float]
"""Values of characteristics, by their types."""


@dataclass(frozen=True, slots=True)
class ServiceRow:
    """A capability of the services that have its characteristics.

    Attributes:
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

    services: str
    capability: str
    watched: str
    target: str = ""
    values: Mapping[int, str] | None = None
    read: Callable[[HapService], PlainValue] | None = None
    write: Callable[[HapService, Command], Writes] | None = None
    options: Callable[[HapService], tuple[str, ...]] | None = None
    bounds: Callable[[HapService], tuple[float, ...]] | None = None
    grid: Callable[[HapService], tuple[float, ...]] | None = None
    when: Callable[[HapService], object] | None = None
    unit: str = ""

    @property
    def kinds(self) -> list[str]:
        """The types of the characteristics that its value depends on."""
        return self.watched.split()

    def describe(self, service: HapService) -> Capability | None:
        """Return the capability of *service* by this row; None if it has none."""
        first = self.kinds[0]
        known = service.characteristics.get(first)
        is_of_row = not self.services or service.type in self.services.split()
        if known is None or not is_of_row or (self.when and not self.when(service)):
            return None
        is_settable = service.can(self.target, "pw")
        kind, is_event = CAPABILITIES[self.capability].kind, CAPABILITIES[self.capability].is_event
        target = service.characteristics.get(self.target, known)
        grid = self.grid(service) if self.grid else number_grid(sum(target.bounds[:1]), target.step)
        return Capability(
            name=self.capability,
            readable=is_event or "pr" in known.perms,
            settable=is_settable,
            unit=self.unit,
            bounds=self._bounds(service) if is_settable and kind == "number" else (),
            grid=grid if is_settable and kind == "number" else (),
            options=self.options(service) if self.options else tuple(self._texts(service).values()),
        )

    def read_value(self, service: HapService) -> PlainValue:
        """Return the value of its capability, or the last event; None for unknown."""
        if self.read is not None:
            return self.read(service)
        first = self.kinds[0]
        if self.values is None and CAPABILITIES[self.capability].kind == "number":
            return read_number(self.capability, first, service)
        value = service.number(first)
        if value is None:
            return None
        return value != 0 if self.values is None else self.values.get(int(value))

    def write_value(self, service: HapService, command: Command) -> Writes:
        """Return what a command that fits its capability sets; raise RefusedError for what cannot be done now."""
        if self.write is not None:
            return self.write(service, command)
        value = command.value
        if self.values is not None:
            raw = {text: number for number, text in self._texts(service).items()}
            return {self.target: raw[require_option(self.capability, value.text, raw)]}
        is_number = CAPABILITIES[self.capability].kind == "number"
        return {self.target: value.number if is_number else float(value.flag)}

    def _texts(self, service: HapService) -> dict[int, str]:
        return known_values(service, self.target or self.kinds[0], self.values or {})

    def _bounds(self, service: HapService) -> tuple[float, ...]:
        if self.bounds is not None:
            return self.bounds(service)
        usual, own = CAPABILITIES[self.capability].bounds, service.characteristics[self.target].bounds
        is_narrower = own and (not usual or (usual[0] <= own[0] and own[1] <= usual[1]))
        return own if is_narrower and self.write is None else usual or own


def known_values(service: HapService, kind: str, values: Mapping[int, str]) -> dict[int, str]:
    """Return those of the *values* that a characteristic can have."""
    found = service.characteristics.get(kind)
    if found is None:
        return {}
    least, most = found.bounds or (0.0, 2.0**32)
    return {raw: text for raw, text in values.items() if raw in (found.valid_values or (raw,)) and least <= raw <= most}


def read_number(capability: str, kind: str, service: HapService) -> float | None:
    """Return the value of a characteristic if it is in the bounds of a capability."""
    least, most = CAPABILITIES[capability].bounds or (-1e9, 1e9)
    value = service.number(kind)
    return round(value, 4) if value is not None and least <= value <= most else None
