"""The abilities of an endpoint: its capabilities, with functions that read and set them. Pure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from homebot.conventions.matter.endpoint import MatterEndpoint, MatterOrder
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["MatterAbility", "WriteValue"]

WriteValue: TypeAlias = Callable[[MatterEndpoint, PlainValue, float, str], tuple[MatterOrder, ...]]
"""Takes an endpoint, a value, the transition in seconds and a code; returns the orders that set the value."""


@dataclass(frozen=True, slots=True)
class MatterAbility:
    """One capability of an endpoint.

    Attributes:
        cluster: The cluster that it belongs to.
        capability: The capability.
        read: Returns its value from the known attributes; None where it is never reported.
        write: Returns the orders that set it; None where it cannot be set.
        also_read: A further cluster that it is read from; None where there is none.
        beside: The part of the endpoint that has it, such as ``battery``; empty for what the endpoint is for.
    """

    cluster: int
    capability: Capability
    read: Callable[[MatterEndpoint], PlainValue] | None = None
    write: WriteValue | None = None
    also_read: int | None = None
    beside: str = ""
