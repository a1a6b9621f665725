"""Reachability of a device, by its availability topics. Pure."""

from __future__ import annotations

from homebot.conventions.description import Availability

__all__ = ["ReachabilityReader"]


class ReachabilityReader:
    """The last reports about one device, and their combined meaning.

    Attributes:
        value: True if the device can be reached; None for unknown.
    """

    __slots__ = ("_latest", "_reports", "availability", "value")

    def __init__(self, availability: Availability) -> None:
        self.availability = availability
        self._reports: list[tuple[bool, bool] | None] = [None] * len(availability.sources)
        self._latest: tuple[bool, bool] | None = None
        self.value: bool | None = None

    def update(self, index: int, is_reachable: bool, *, retained: bool) -> None:  # noqa: FBT001 - the report of the source
        """Take the report of source *index*: whether the device can be reached."""
        self._reports[index] = self._latest = is_reachable, retained
        self.value = self._combined()

    def discard_retained_offline(self) -> None:
        """Forget each "offline" that the broker had kept from before the device's message: it is often never cleared.

        An "offline" that was heard live stays, and so does every "online".
        """
        if self._latest == _RETAINED_OFFLINE:
            self._latest = None
        self._reports = [None if report == _RETAINED_OFFLINE else report for report in self._reports]
        self.value = self._combined()

    def _combined(self) -> bool | None:
        if self.availability.mode == "latest":
            return self._latest[0] if self._latest is not None else None
        known = [report[0] for report in self._reports if report is not None]
        decisive = self.availability.mode == "any"
        if decisive in known:
            return decisive
        return not decisive if len(known) == len(self._reports) else None


_RETAINED_OFFLINE = (False, True)
