"""Handle: one part of one device, with its latest values and its commands."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractAsyncContextManager
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self, Unpack

from homebot.devices.capabilities import CAPABILITIES, EVENTS
from homebot.devices.device import Device, Freshness
from homebot.devices.device_view import DeviceView
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery, Term
from homebot.devices.house_view import HouseView
from homebot.devices.part import Capability, check_no_share
from homebot.devices.query.terms import CanDo, Not, Operator, StateIs
from homebot.devices.value import PlainValue, plain_value
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.support.names import did_you_mean

if TYPE_CHECKING:
    from homebot.devices.hold import Hold
    from homebot.devices.journal_messages import KnownCause
    from homebot.devices.outcomes import Outcome

_NONE: Mapping[str, Any] = MappingProxyType({})


class Handle:
    """One part of a device; the base class of all kinds. ``find(Handle)`` finds parts of every type.

    Its properties are the latest values that the device reported, or ``None`` if unknown. A command does not change
    them; the device's report does. Two handles of the same part and kind are equal.

    A command raises `RefusedError` if the part does not accept it, or its value. A *code* is for an alarm or lock that
    requires one; it is never logged or shown in an error.

    Attributes:
        service_types: The device types of this kind; empty for any.
    """

    service_types: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, view: DeviceView, part_id: str, house: HouseView) -> None:
        """For internal use: :meth:`homebot.devices.Devices.find` returns handles."""
        self._view = view
        self._part_id = part_id
        self._house = house

    @classmethod
    def where(cls, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            filters: ``area``: the room; ``name``: a name of the device or part; ``reachable``: whether it can be
                reached; ``fresh``: whether it reported recently; ``category``: ``config`` for settings or
                ``diagnostic`` for diagnostics, which are left out otherwise.
        """
        return HandleQuery(cls, filters)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Handle) and (self.id, type(self)) == (other.id, type(other))

    def __hash__(self) -> int:
        return hash((self.id, type(self)))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id}>"

    @property
    def id(self) -> str:
        """The id of the device, with ``#`` and the id of the part if it has one; renaming does not change it."""
        return f"{self._view.device.id}#{self._part_id}" if self._part_id else self._view.device.id

    @property
    def part_id(self) -> str:
        """The id of the part, unique in its device; see :attr:`homebot.devices.DevicePart.id`."""
        return self._part_id

    @property
    def name(self) -> str:
        """The name for people: the device's, followed by the part's if it has one."""
        part = self._view.device.part(self._part_id)
        own = part.part.name if part else ""
        return f"{self._view.device.name} {own}" if own else self._view.device.name

    @property
    def area(self) -> str:
        """The room of the device; empty if unknown."""
        return self._view.device.area

    @property
    def device(self) -> Device:
        """The device of the part, as last announced."""
        return self._view.device

    @property
    def is_gone(self) -> bool:
        """True once the device was removed or no longer has this part; then commands end with `Gone`."""
        return self._view.is_gone or self._view.device.part(self._part_id) is None

    @property
    def reachable(self) -> bool | None:
        """True if it can be reached, as reported by the part or else the device; None if neither reports it."""
        device = self._view.device
        return False if self._part_id in device.offline_parts else _REACHABLE[device.reachable.state]

    @property
    def freshness(self) -> Freshness:
        """``fresh``, ``unconfirmed`` or ``stale``; see :class:`homebot.devices.Device`."""
        return self._view.device.freshness

    @property
    def capabilities(self) -> tuple[Capability, ...]:
        """The capabilities of the part, with units, bounds and options."""
        part = self._view.device.part(self._part_id)
        return part.part.capabilities if part is not None else ()

    def can(self, capability: str) -> bool:
        """Return whether *capability*, for example ``level``, can be set."""
        return any(offered.name == capability and offered.settable for offered in self.capabilities)

    def value(self, capability: str) -> PlainValue:
        """Return the latest value of *capability*, in the unit of the vocabulary; None if unknown.

        Raises:
            UsageError: There is no such capability (the message suggests the nearest), or it is an event, not a state.
        """
        if capability in EVENTS:
            raise UsageError(f"{capability} is an event, not a state; use `follow` to receive events")
        if capability not in CAPABILITIES and not any(offered.name == capability for offered in self.capabilities):
            known = ", ".join(offered.name for offered in self.capabilities) or "nothing"
            hint = did_you_mean(capability, CAPABILITIES, f"{self.id} reports {known}", cutoff=0.7)
            raise UsageError(f"{capability!r} is not a capability; {hint}")
        return self._view.value(self._part_id, capability)

    def since(self, capability: str) -> float:
        """Return since when *capability* has had its value, in seconds since the Unix epoch; 0 if unknown."""
        state = self._view.state(self._part_id, capability)
        return state.since.to_seconds() if state is not None and state.value.type else 0.0

    async def cause(self, capability: str) -> KnownCause | None:
        """Return the cause of the newest change of a setting; None if the control layer has not seen it change."""
        return await self._house.cause(self._view.device.id, self._part_id, capability)

    @property
    def told_at(self) -> float:
        """The time of the latest new value of the device, in seconds since the Unix epoch; 0 if there is none."""
        return max((state.told_at.to_seconds() for state in self._view.current().states), default=0.0)

    async def command(self, capability: str, value: PlainValue, *, transition: float = 0.0, code: str = "") -> Outcome:
        """Set *capability* to *value*. Commands are absolute: sending one twice has the effect of sending it once.

        It returns when the outcome is known: mostly when the device has reported the new value, at the latest when its
        usual response time is over. A failure of a device or its network is an outcome; a command that makes no sense
        raises an error, and nothing is sent.

        Args:
            capability: For example ``level``.
            value: The value, in the unit of the vocabulary.
            transition: Seconds that the change takes, if the device supports that; 0 or more.
            code: The code of an alarm or a lock; never logged or shown in an error.

        Raises:
            RefusedError: It does not support the capability or the value; the message names the accepted values.
        """
        plain = {capability: plain_value(value)}
        return await self._house.commander.perform(self._view, self._part_id, plain, transition, code)

    async def commands(self, settings: Mapping[str, PlainValue], *, transition: float = 0.0, code: str = "") -> Outcome:
        """Set several capabilities in order, as one command with one outcome; see :meth:`command`.

        Args:
            settings: The values by capability, at least one.
            transition: Seconds that the change takes, if the device supports that; 0 or more.
            code: The code of an alarm or a lock; never logged or shown in an error.

        Raises:
            RefusedError: It does not support one of the capabilities or values; nothing was sent.
        """
        plain = {capability: plain_value(value) for capability, value in settings.items()}
        return await self._house.commander.perform(self._view, self._part_id, plain, transition, code)

    def hold(self, value: str, *, by: str, ttl: float = 10.0) -> AbstractAsyncContextManager[Hold]:
        """Command *value* and keep it while the block runs: ``async with door.hold("open", by="robot") as hold``.

        Meanwhile every command that would change it is refused, from any issuer, except stop commands. Others may hold
        the same value. The block begins once the outcome of the command is known, good or bad: check ``hold.succeeded``
        or ``hold.outcome``. Leaving the block releases the part.

        Args:
            value: A word that the part accepts, as for ``homebot do``: ``open``, ``on``, ``locked``, ``0.4``.
            by: The holder, for people; not empty.
            ttl: Seconds after which the part is free if this program dies, 1 to 3,600; renewed while the block runs.

        Raises:
            UsageError: *by* is empty or *ttl* out of range.
            RefusedError: The part does not accept the word, or its effect does not last, as for ``press``.
        """
        return self._house.commander.hold(self._view, self._part_id, value, by, ttl)

    async def _set(self, settings: Mapping[str, PlainValue], *, transition: float = 0.0) -> Outcome:
        """As :meth:`commands`, but refuse a share of 1 for a percentage, which only :meth:`command` takes as it is."""
        plain = {capability: plain_value(value) for capability, value in settings.items()}
        for capability, value in plain.items():
            if isinstance(value, float) and value < 1:
                with self._house.commander.refusals_logged(self._view.device, self._part_id):
                    check_no_share(self.id, capability, value, f"command({capability!r}, {value!r})")
        return await self._house.commander.perform(self._view, self._part_id, plain, transition)

    def _flag(self, capability: str) -> bool | None:
        value = self._view.value(self._part_id, capability)
        return value if isinstance(value, bool) else None

    def _number(self, capability: str) -> float | None:
        value = self._view.value(self._part_id, capability)
        return value if isinstance(value, float) else None

    def _number_of_device(self, capability: str) -> float | None:
        """Return the number of the part, or else that of the only part of the device that has one."""
        if any(offered.name == capability for offered in self.capabilities):
            return self._number(capability)
        value = self._view.only_value(capability)
        return value if isinstance(value, float) else None

    def _text(self, capability: str) -> str | None:
        value = self._view.value(self._part_id, capability)
        return value if isinstance(value, str) else None

    @classmethod
    def _where(
        cls,
        filters: CommonFilters,
        *terms: Term,
        states: Mapping[str, PlainValue] = _NONE,
        above: Mapping[str, float | None] = _NONE,
        below: Mapping[str, float | None] = _NONE,
        settable: Mapping[str, bool | None] = _NONE,
    ) -> HandleQuery[Self]:
        """Return the query with conditions by capability; conditions that are None are left out."""
        all_terms = list(terms)
        comparisons: tuple[tuple[Operator, Mapping[str, PlainValue]], ...] = (("=", states), (">", above), ("<", below))
        for operator, wanted in comparisons:
            for name, value in wanted.items():
                if value is not None:
                    all_terms.append(
                        StateIs(name, operator, fold(value) if isinstance(value, str) else plain_value(value))
                    )
        for name, can in settable.items():
            if can is not None:
                all_terms.append(CanDo(name, settable=True) if can else Not(CanDo(name, settable=True)))
        return HandleQuery(cls, filters, tuple(all_terms))


_REACHABLE: Mapping[str, bool | None] = {"yes": True, "no": False, "unknown": None}
