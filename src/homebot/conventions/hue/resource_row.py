"""Rows: the capabilities of resources of a Hue bridge, with their readers and encoders. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["Fields", "HueBody", "HueRow", "at"]

Fields: TypeAlias = Mapping[str, object]
"""A resource, or an object in one, as the bridge sends it."""

HueBody: TypeAlias = dict[str, object]
"""The changes that a request asks for."""


@dataclass(frozen=True, slots=True)
class HueRow:
    """A capability of the resources of one type.

    Attributes:
        type: The type of the resource: ``light``.
        fields: The fields that its value depends on; it is reported by a resource with one of them.
        read: Returns its value, None for unknown; never raises. None for events, and for a capability without a state.
        write: Returns the body of the request that sets it, given the resource, the value and the transition in
            seconds; raises RefusedError. None for a capability that cannot be set.
        needs: The field that a resource has if it has the capability.
        at_owner: Whether the request goes to the device that the resource belongs to.
    """

    type: str
    capability: str
    fields: frozenset[str]
    read: Callable[[Fields], PlainValue] | None = None
    write: Callable[[Fields, PlainValue, float], HueBody] | None = None
    needs: str = "id"
    bounds: Callable[[Fields], tuple[float, ...]] = lambda _: ()
    options: Callable[[Fields], tuple[str, ...]] = lambda _: ()
    at_owner: bool = False

    def describe(self, resource: Fields) -> Capability:
        """Return the capability of a resource that has it."""
        return Capability(
            name=self.capability,
            readable=not self.fields.isdisjoint(resource),
            settable=self.write is not None,
            bounds=self.bounds(resource),
            options=self.options(resource),
        )


def at(resource: object, *path: str) -> object:
    """Return the value at a path of names in JSON objects; None if there is none."""
    for name in path:
        resource = resource.get(name) if isinstance(resource, Mapping) else None
    return resource
