"""Parts of a thing, and its affordances as their capabilities. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.payload import shown
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.wot.thing import Affordance, Form

__all__ = ["ClassifiedAffordance", "ClassifiedPart"]


@dataclass(frozen=True, slots=True)
class ClassifiedAffordance:
    """An affordance as a capability.

    Attributes:
        observed: The form of its values; None if the protocol has none, or it is never read.
        written: The form of its commands; None if the protocol has none, or it is never written.
        actions: The actions that set it in place of that, by value.
    """

    capability: Capability
    affordance: Affordance
    observed: Form | None
    written: Form | None
    actions: Mapping[str, ClassifiedAffordance] = field(default_factory=dict)

    def request(self, value: PlainValue) -> tuple[ClassifiedAffordance, Form, PlainValue]:
        """Return the affordance, form and value that set it to *value*; raise RefusedError if none do."""
        if isinstance(value, str) and value in self.actions:
            return self.actions[value].request(value=True)
        if self.written is None:
            what = " or ".join(self.actions) or "no values"
            raise RefusedError(f"{self.capability.name} {shown(value)}", f"it takes {what}")
        return self, self.written, value


@dataclass(frozen=True, slots=True)
class ClassifiedPart:
    """A part of a thing, and the affordances that are its capabilities, in the same order."""

    part: Part
    affordances: tuple[ClassifiedAffordance, ...]

    @property
    def settable(self) -> dict[str, ClassifiedAffordance]:
        """Those that can be set, by capability."""
        return {one.capability.name: one for one in self.affordances if one.written is not None or one.actions}
