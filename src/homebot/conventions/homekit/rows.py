"""Rows: the capabilities of services, with what reads and sets them. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.homekit.accessory import HapService
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["HomekitAbility", "ServiceRow", "Writes", "known_values", "read_number"]

Writes: TypeAlias = Mapping[str, float]
"""Values of characteristics, by their types."""

_NO_VALUES: Mapping[int, str] = {}


@dataclass(frozen=True, slots=True)
class HomekitAbility:
    """A capability of a service; see :class:`ServiceRow`.

    Attributes:
        watched: The types of the characteristics that its value depends on.
        read: Returns its value, or the last event; None for unknown.
        write: Returns what sets a value, or raises RefusedError; None if it cannot be set.
    """

    capability: Capability
    watched: frozenset[str]
    read: Callable[[], PlainValue]
    write: Callable[[PlainValue], Writes] | None


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
        write: Returns what sets a value; by default the value itself in *target*.
        options: Returns the texts that it has, if *values* are not all.
        bounds: Returns the bounds of its value; by default those of *target* or the vocabulary.
    """

    services: str
    capability: str
    watched: str
    target: str = ""
    values: Mapping[int, str] | None = None
    read: Callable[[HapService], PlainValue] | None = None
    write: Callable[[HapService, PlainValue], Writes] | None = None
    options: Callable[[HapService], tuple[str, ...]] | None = None
    bounds: Callable[[HapService], tuple[float, ...]] | None = None
    when: Callable[[HapService], object] | None = None
    unit: str = ""

    def ability(self, service: HapService) -> HomekitAbility | None:
        """Return the ability of *service* by this row; None if it has none."""
        first, *_ = watched = self.watched.split()
        known = service.characteristics.get(first)
        is_of_row = not self.services or service.type in self.services.split()
        if known is None or not is_of_row or (self.when and not self.when(service)):
            return None
        is_settable = service.can(self.target, "pw")
        kind, is_event = CAPABILITIES[self.capability].kind, CAPABILITIES[self.capability].is_event
        texts = known_values(service, self.target or first, self.values or _NO_VALUES)
        capability = Capability(
            name=self.capability,
            readable=is_event or "pr" in known.perms,
            settable=is_settable,
            unit=self.unit,
            bounds=self._bounds(service) if is_settable and kind == "number" else (),
            options=self.options(service) if self.options else tuple(texts.values()),
        )
        read = partial(self.read or partial(_read, self.capability, first, self.values), service)
        write = partial(self.write or partial(_write, self.capability, self.target, texts, self._bounds), service)
        return HomekitAbility(capability, frozenset(watched), read, write if is_settable else None)

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


def _read(capability: str, kind: str, values: Mapping[int, str] | None, service: HapService) -> PlainValue:
    if values is None and CAPABILITIES[capability].kind == "number":
        return read_number(capability, kind, service)
    value = service.number(kind)
    if value is None:
        return None
    return value != 0 if values is None else values.get(int(value))


def _write(
    capability: str,
    kind: str,
    texts: Mapping[int, str],
    bounds: Callable[[HapService], tuple[float, ...]],
    service: HapService,
    value: PlainValue,
) -> Writes:
    if texts:
        raw = {text: number for number, text in texts.items()}
        return {kind: raw[require_option(capability, value, raw)]}
    if CAPABILITIES[capability].kind == "number":
        least, most = bounds(service) or (-1e9, 1e9)
        return {kind: require_number(capability, value, least, most)}
    return {kind: float(require_bool(capability, value))}
