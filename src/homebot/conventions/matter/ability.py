"""The abilities of an endpoint, in the words of the vocabulary. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeAlias

from homebot.conventions.matter.endpoint import MatterEndpoint, MatterOrder
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["FindAbilities", "MatterAbility", "WriteValue"]

WriteValue: TypeAlias = Callable[[MatterEndpoint, PlainValue, float, str], tuple[MatterOrder, ...]]
"""Returns the orders that set a value; the numbers are the seconds that it may take, and the text a code."""


@dataclass(frozen=True, slots=True)
class MatterAbility:
    """One capability of an endpoint.

    Attributes:
        cluster: The cluster that it stands for.
        capability: The capability.
        read: Returns its value, by the attributes that are known; None where it is never reported.
        write: None where it cannot be set.
        also_read: A further cluster that it is read from; None where there is none.
        is_battery: Whether it is about the battery of the endpoint rather than about what it is for.
    """

    cluster: int
    capability: Capability
    read: Callable[[MatterEndpoint], PlainValue] | None = None
    write: WriteValue | None = None
    also_read: int | None = None
    is_battery: bool = False


FindAbilities: TypeAlias = Callable[[MatterEndpoint], Iterable[MatterAbility]]
"""Yields the abilities of an endpoint that one group of clusters gives it."""
