"""Columns: the values of one capability of all parts of one type, stored for fast comparison. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import compress
from typing import final

from homebot.devices.query.matching import COMPARISONS, compares
from homebot.devices.query.terms import StateIs
from homebot.devices.value import UNKNOWN, PlainValue, Value
from homebot.messages import Time

_NEVER = Time(sec=0, nanosec=0)


@dataclass(slots=True)
class StoredValue:
    """A value that a part reported.

    Attributes:
        value: The reported value as a Python value.
        heard_at: ``told_at`` on the monotonic clock, which decides which value is newer.
        live: Whether the device reported it live, rather than a retained message.
        column: The column with a copy of ``value``; None if it is not searchable.
        is_first: Whether no other value was reported before it.
        was_absent: Whether the device was unreachable since the value before it.
        before: The last known live value before it, reported since *before_since*.
    """

    reported: Value
    value: PlainValue
    since: Time
    told_at: Time
    live: bool
    heard_at: float = -math.inf
    column: Column | None = None
    row: int = 0
    is_first: bool = True
    was_absent: bool = False
    before: Value = UNKNOWN
    before_since: Time = _NEVER


@final
class Column:
    """Values and their devices; a value has one row in one column.

    Attributes:
        values: The values; code that changes `StoredValue.value` must change its row too.
    """

    __slots__ = ("_devices", "_stored", "values")

    def __init__(self) -> None:
        self.values: list[PlainValue] = []
        self._devices: list[str] = []
        self._stored: list[StoredValue] = []

    def add(self, device_id: str, stored: StoredValue) -> None:
        """Add a value of the device; if it already has a row, maybe for another device, it moves."""
        if stored.column is not None:
            stored.column.remove(stored)
        stored.column, stored.row = self, len(self.values)
        self.values.append(stored.value)
        self._devices.append(device_id)
        self._stored.append(stored)

    def discard(self, device_id: str, stored: StoredValue) -> None:
        """Remove a value, unless it belongs to another device by now."""
        if stored.column is self and self._devices[stored.row] == device_id:
            self.remove(stored)

    def remove(self, stored: StoredValue) -> None:
        """Remove a value."""
        row, stored.column = stored.row, None
        value, device, last = self.values.pop(), self._devices.pop(), self._stored.pop()
        if last is not stored:
            self.values[row], self._devices[row], self._stored[row] = value, device, last
            last.row = row

    def fitting(self, term: StateIs) -> set[str]:
        """Return the devices that match; numbers and flags, the usual values, are compared without function calls."""
        wanted, values = term.value, self.values
        if isinstance(wanted, bool) and term.operator == "=":
            fits = [value is wanted for value in values]
        elif isinstance(wanted, float):
            holds = COMPARISONS[term.operator]
            fits = [isinstance(value, float) and holds(value, wanted) for value in values]
        else:
            fits = [compares(term, value) for value in values]
        return set(compress(self._devices, fits))
