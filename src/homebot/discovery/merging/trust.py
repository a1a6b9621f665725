"""Trust in the endpoints of a device: which of them may get its commands. Pure.

A hardware address, host name or serial number in an announcement is a claim that any host on a network can make. It
is enough to list an endpoint with the device, but not to give it the device's commands: a stranger would get them as
soon as the true endpoint is unreachable. Of several endpoints that take commands, these get them:

- the first known one,
- those that proved their identity to their gateway (:attr:`homebot.devices.Sighting.authenticated`),
- those that reported the same changes as a trusted one (:class:`Agreement`),
- those that the owner confirmed.

All others are *claimed*. They get no commands, and their reports do not count for parts that trusted endpoints have.
When no trusted endpoint is left, the oldest claimed one gets the commands, unless the device is of a type that can hurt
(:data:`homebot.devices.device_types.CAN_HURT`).

An endpoint is a gateway as a whole, if the gateway's addresses belong to devices (see :mod:`homebot.discovery.topics`);
otherwise it is one key of a gateway, at whatever network address.
"""

from collections import OrderedDict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias, final

from homebot.devices import Sighting
from homebot.devices.device_types import CAN_HURT
from homebot.devices.value import PlainValue
from homebot.discovery.source_record import SourceRecord

EndpointKey: TypeAlias = tuple[str, str]
"""Gateway and key; the key is empty if the endpoint is the gateway as a whole."""

MAX_TRUSTED = 64
"""Most trusted endpoints of a device that are remembered."""

NOBODY_TRUSTED: frozenset[EndpointKey] = frozenset()


def endpoint_of(source: SourceRecord) -> EndpointKey:
    """Return the endpoint of an announcement."""
    sighting = source.sighting
    has_addresses = (
        sighting.announced_on
        or sighting.is_plain_text
        or any(part.writes or part.reads for part in sighting.parts)  # last, because it is the slowest
    )
    return (source.key[0], "") if has_addresses else source.key


def takes_commands(sighting: Sighting) -> bool:
    """Return whether an announcement offers anything that can be commanded."""
    if not sighting.parts:
        return bool(sighting.command_address)
    return any(capability.settable for part in sighting.parts for capability in part.capabilities)


def command_endpoints(sources: Iterable[SourceRecord]) -> tuple[EndpointKey, ...]:
    """Return the endpoints that take commands, oldest first."""
    return tuple(dict.fromkeys(endpoint_of(source) for source in sources if takes_commands(source.sighting)))


def judge(sources: Iterable[SourceRecord], known: frozenset[EndpointKey]) -> frozenset[EndpointKey]:
    """Mark the claimed announcements of a device; return the endpoints that are trusted now.

    Args:
        sources: The announcements, oldest first.
        known: The endpoints trusted so far, including those that are gone.
    """
    ordered = tuple(sources)
    endpoints = command_endpoints(ordered)
    proved = {endpoint_of(source) for source in ordered if source.sighting.authenticated}
    first = frozenset(endpoints[:1]) if not known and len(endpoints) > 1 else NOBODY_TRUSTED
    trusted = known | first | proved.intersection(endpoints)
    claimed = _find_claimed(ordered, endpoints, trusted) if trusted else ()
    for source in ordered:
        source.is_claimed = bool(claimed) and endpoint_of(source) in claimed and takes_commands(source.sighting)
    return trusted if len(trusted) <= MAX_TRUSTED else known


def _find_claimed(
    ordered: Iterable[SourceRecord], endpoints: Sequence[EndpointKey], trusted: frozenset[EndpointKey]
) -> Sequence[EndpointKey]:
    """Return the endpoints that are not trusted; if none is there that is, the oldest counts, unless it can hurt."""
    claimed = [endpoint for endpoint in endpoints if endpoint not in trusted]
    if not claimed or len(claimed) < len(endpoints):
        return claimed
    oldest = [source.sighting for source in ordered if endpoint_of(source) == claimed[0]]
    return claimed if can_hurt(oldest) else claimed[1:]


def can_hurt(sightings: Iterable[Sighting]) -> bool:
    """Return whether the announced device is of a type that can hurt."""
    return any(part.service_type in CAN_HURT for sighting in sightings for part in sighting.parts)


CHANGES_NEEDED = 3
"""Changes that both must report."""

WINDOW = 15.0
"""Seconds within which both must report a change, as some endpoints are polled every ten seconds; also the least time
between changes that count."""

_MAX_WAITING = 32
"""Most changes that wait for another endpoint; then the oldest counts as missed."""

Change: TypeAlias = tuple[int, str, PlainValue]
"""The number of a part, the capability, and the new value."""


@dataclass(slots=True)
class _Reported:
    """A change, and the endpoint that reported it."""

    at: float
    claimed: frozenset[EndpointKey]
    by_trusted: bool = False
    by_claimed: set[EndpointKey] = field(default_factory=set)

    @property
    def missed(self) -> frozenset[EndpointKey]:
        """The claimed endpoints that missed it, or were alone in reporting it."""
        return self.claimed - self.by_claimed if self.by_trusted else frozenset(self.by_claimed)


@final
class Agreement:
    """The recent changes reported by the endpoints of one device, and how often claimed ones agreed.

    An impostor does not know when the device changes. A single match may be a coincidence, and an endpoint that changes
    all the time is sometimes right. So both must report three changes, some time apart, and any change that only one of
    them reports restarts the count. Numbers do not count, because conventions round them differently. Devices of a type
    that can hurt are excluded, because their state may be visible from the street.
    """

    __slots__ = ("_counts", "_lately")

    def __init__(self) -> None:
        self._counts: dict[EndpointKey, tuple[int, float]] = {}
        self._lately: OrderedDict[Change, _Reported] = OrderedDict()

    def record(
        self, change: Change, endpoint: EndpointKey, claimed: Iterable[EndpointKey], now: float
    ) -> frozenset[EndpointKey]:
        """Record a change reported by *endpoint*.

        Returns:
            The claimed endpoints to be trusted from now on.
        """
        while self._lately and now - next(iter(self._lately.values())).at > WINDOW:
            self._close(self._lately.popitem(last=False)[1])
        waiting = frozenset(claimed)
        is_claimed = endpoint in waiting
        known = self._lately.get(change)
        if known is not None and (endpoint in known.by_claimed if is_claimed else known.by_trusted):
            self._close(self._lately.pop(change))  # it changed back in the meantime
            known = None
        known = known or self._begin(change, now, waiting)
        if is_claimed:
            known.by_claimed.add(endpoint)
            agreeing = frozenset({endpoint} if known.by_trusted else ())
        else:
            known.by_trusted = True
            agreeing = waiting & known.by_claimed
        return frozenset(
            [
                waiting_endpoint
                for waiting_endpoint in agreeing
                if self._count(waiting_endpoint, known.at, now) >= CHANGES_NEEDED
            ]
        )

    def _count(self, endpoint: EndpointKey, begun: float, now: float) -> int:
        """Count an agreement on a change, unless one was counted shortly before; return how many there are."""
        count, last = self._counts.get(endpoint, (0, begun - WINDOW))
        if now - last >= WINDOW:
            count += 1
            self._counts[endpoint] = count, now
        return count

    def _begin(self, change: Change, now: float, waiting: frozenset[EndpointKey]) -> _Reported:
        reported = self._lately[change] = _Reported(now, waiting)
        if len(self._lately) > _MAX_WAITING:
            self._close(self._lately.popitem(last=False)[1])
        return reported

    def _close(self, reported: _Reported) -> None:
        for endpoint in reported.missed:
            self._counts.pop(endpoint, None)
