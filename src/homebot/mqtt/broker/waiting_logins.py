"""Connections that have not logged in: how many there may be, and who has to go when there are more. No I/O."""

from __future__ import annotations

from collections import Counter
from typing import Protocol, final

from homebot.mqtt.broker.client_text import host_of

__all__ = ["LoginCandidate", "WaitingLogins"]


class LoginCandidate(Protocol):
    """A connection whose CONNECT has not been accepted yet."""

    @property
    def address(self) -> str:
        """The far side."""
        ...

    def make_room(self) -> None:
        """End the connection: another one needs its place."""
        ...


@final
class WaitingLogins:
    """The connections that have not logged in, oldest first.

    One more than the bound costs the oldest one of the host that has most of them, so that a flood from one host
    keeps nobody else out.

    Args:
        most: The bound.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._candidates: dict[LoginCandidate, None] = {}

    def __len__(self) -> int:
        return len(self._candidates)

    def add(self, candidate: LoginCandidate) -> None:
        """A connection was opened."""
        if len(self._candidates) >= self._most:
            self._make_room()
        self._candidates[candidate] = None

    def discard(self, candidate: LoginCandidate) -> None:
        """A connection has logged in, or has gone."""
        self._candidates.pop(candidate, None)

    def _make_room(self) -> None:
        hosts = [host_of(each.address) for each in self._candidates]
        most = Counter(hosts).most_common(1)[0][0]
        oldest = next(each for each, host in zip(self._candidates, hosts, strict=True) if host == most)
        del self._candidates[oldest]
        oldest.make_room()
