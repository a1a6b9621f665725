"""A limit on the requests that a server takes. Pure."""

from collections.abc import Callable
from typing import Final, final

from homebot.clock import Clock
from homebot.support.addresses import network_of
from homebot.support.bounded_map import BoundedMap
from homebot.support.rate_limit import RateLimit

__all__ = ["RequestLimit"]

_OF_HOST: Final = (20.0, 1000.0)
_OF_ALL: Final = (100.0, 5000.0)
"""Requests per second, and at once."""

_MOST_HOSTS: Final = 1000


@final
class RequestLimit:
    """The limit for each host, and for all of them: who sends it may be a lie.

    Args:
        on_drop: Called with the host of each request that is not let in.
    """

    def __init__(self, clock: Clock, on_drop: Callable[[str], None]) -> None:
        self._clock = clock
        self._on_drop = on_drop
        self._hosts: BoundedMap[str, RateLimit] = BoundedMap(_MOST_HOSTS)
        self._all = RateLimit(*_OF_ALL)

    def admits(self, host: str) -> bool:
        """Return whether to let a request of *host* in; count it."""
        now, key = self._clock.monotonic(), network_of(host)
        limit = self._hosts[key] = self._hosts.get(key) or RateLimit(*_OF_HOST)
        if limit.admits(now) and self._all.admits(now):
            return True
        self._on_drop(host)
        return False
