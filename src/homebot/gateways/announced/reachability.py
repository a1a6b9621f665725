"""Reachability of a device, by its availability topics. Pure."""

from __future__ import annotations

from homebot.conventions.description import Availability

__all__ = ["ReachabilityReader"]


class ReachabilityReader:
    """The last words about one device, and what they mean together.

    Args:
        availability: Where the words come from, and how they are joined.
    """

    __slots__ = ("_latest", "_words", "availability")

    def __init__(self, availability: Availability) -> None:
        self.availability = availability
        self._words: list[tuple[bool, bool] | None] = [None] * len(availability.sources)
        self._latest: tuple[bool, bool] | None = None

    @property
    def value(self) -> bool | None:
        """True if the device can be reached; None for unknown."""
        if self.availability.mode == "latest":
            return self._latest[0] if self._latest is not None else None
        known = [word[0] for word in self._words if word is not None]
        decisive = self.availability.mode == "any"
        if decisive in known:
            return decisive
        return not decisive if len(known) == len(self._words) else None

    def hear(self, index: int, said: bool, *, retained: bool) -> None:  # noqa: FBT001 - what the source says
        """Take the word of source *index*: whether the device can be reached."""
        self._words[index] = self._latest = said, retained

    def doubt(self) -> None:
        """Forget each "offline" that the broker had kept from before the device's message: it is often never cleared.

        An "offline" that was heard live stays, and so does every "online".
        """
        if self._latest == _KEPT_NO:
            self._latest = None
        self._words = [None if word == _KEPT_NO else word for word in self._words]


_KEPT_NO = (False, True)
