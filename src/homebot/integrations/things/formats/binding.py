"""A protocol's choice among the forms of an affordance, and the resulting capabilities. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from homebot.conventions.payload import shown
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.things.formats.payload import PayloadFormats, basic_formats
from homebot.integrations.things.formats.thing import WRITE_OPS, Affordance, Form

_PUSH_OPS = frozenset({"observeproperty", "subscribeevent"})


class Binding(Protocol):
    """A protocol's choice among the forms of an affordance: those that it can use, best first."""

    @property
    def formats(self) -> PayloadFormats:
        """The payload formats that it supports."""

    def observe_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms by which its values become known: pushed or asked for."""

    def write_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms by which it is written, or invoked."""


@dataclass(frozen=True, slots=True)
class RequestBinding:
    """A protocol of requests and responses, such as HTTP and CoAP.

    Attributes:
        schemes: Of the addresses that it can use.
        subprotocols: The ways in which it can be sent values, best first; ``""`` for the protocol's own.
    """

    schemes: frozenset[str]
    subprotocols: tuple[str, ...] = ()
    formats: PayloadFormats = basic_formats

    def push_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms by which values are pushed."""
        observed = [
            form
            for form in self._usable(affordance)
            if not _PUSH_OPS.isdisjoint(form.ops) and form.subprotocol in self.subprotocols
        ]
        return tuple(sorted(observed, key=lambda form: self.subprotocols.index(form.subprotocol)))

    def read_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms by which values are asked for."""
        return tuple(form for form in self._usable(affordance) if "readproperty" in form.ops)

    def observe_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms by which its values become known: pushed or asked for."""
        return (*self.push_forms(affordance), *self.read_forms(affordance))

    def write_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms by which it is written, or invoked."""
        return tuple(
            form
            for form in affordance.forms
            if not WRITE_OPS.isdisjoint(form.ops)
            and self._can_reach(form)
            and (affordance.kind == "action" or self.formats(form.content_type) is not None)
        )

    def _usable(self, affordance: Affordance) -> tuple[Form, ...]:
        return tuple(
            form
            for form in affordance.forms
            if self._can_reach(form) and self.formats(form.response_type or form.content_type) is not None
        )

    def _can_reach(self, form: Form) -> bool:
        return form.scheme in self.schemes and "{" not in form.href


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
        return {
            affordance.capability.name: affordance
            for affordance in self.affordances
            if affordance.written is not None or affordance.actions
        }
