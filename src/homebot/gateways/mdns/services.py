"""The services on the network, each queried again when its SRV record expires.

One task follows each service: it waits until the SRV record expires, queries it again, and removes the service if it
does not answer (RFC 6762, section 5.2), unless its device is known to be there. Announcements of unknown services wait
in bounded queues, one for each sender, and are admitted at a limited rate, each sender in turn, so that a flood of one
does not block the others.
"""

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import count
from typing import Protocol

import anyio
from anyio.abc import TaskGroup

from homebot.clock import Clock
from homebot.conventions.dns_sd import FoundService
from homebot.gateways.mdns.network import ResolvedService, ServiceNetwork, ServiceNews
from homebot.support.bounded_map import BoundedMap
from homebot.support.isolation import isolated
from homebot.support.limits import RateLimit

ANSWER_WITHIN = 3.0
"""Seconds in which a service may answer; the query is sent four times."""

SHORTEST = 5.0
"""Seconds between two queries of one service at least, for any time to live."""

GRACE = 0.5
"""Seconds added to the time to live, so that the record has certainly expired."""

MAX_REMEMBERED = 1000
"""Removed services with remembered changes; the oldest is forgotten."""

MAX_ASKED = 32
"""Services that are queried at the same time."""

MAX_WAITING, MAX_WAITING_OF_ALL = 256, 1024
"""Services of one sender that wait for admission, and of all senders, which have equal shares of it; further ones are
dropped, counted, and asked for again later."""

BURST, PER_SECOND = 256.0, 20.0
"""Services that are admitted at once, and each second after that; none while :data:`MAX_ASKED` have not answered."""

PACE = 0.25
"""Seconds between two admissions while services wait; also how long to wait for the other records of a change."""

KEPT_AGAIN = 30.0
"""Seconds after which a service is queried again that did not answer and is kept."""

ASK_AGAIN, ALL_AGAIN = 30.0, 20
"""Seconds after which the types of dropped services are queried again; each 20th time all types are, because
announcements may have been lost."""

CHANGES_AT_ONCE, CHANGE_EVERY = 5.0, 10.0
"""Changes of one service that are handled at once, and seconds between further ones: each change may cause a new
connection."""

TRIES_AFTER_LOSS = 5
"""Queries of a known service after the network came back: wireless links take some time."""


class ServiceHandler(Protocol):
    """The port through which services are listed."""

    def publish(self, service: ResolvedService) -> None:
        """Take a service that is new, still there, or changed."""

    def confirm_connected(self, name: str) -> bool:
        """Keep a service that does not answer if its device is known to be there; return whether it is."""

    def drop(self, name: str, why: str) -> None:
        """Remove a service that is gone, if it was listed."""

    def refuse(self, name: str, why: str) -> None:
        """Count an announcement that is not followed."""

    def delay(self, name: str) -> None:
        """Count a delayed change of a service that changes too often."""


@dataclass(eq=False, slots=True)
class _Followed:
    service_type: str
    name: str
    tries: int = 1
    has_answered: bool = False
    changes: RateLimit = field(default_factory=lambda: RateLimit(1 / CHANGE_EVERY, CHANGES_AT_ONCE, most_ahead=1.0))
    news: anyio.Event = field(default_factory=anyio.Event)
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)


class Services:
    """At most *max_services* on one network, and of one type half as many."""

    def __init__(self, handler: ServiceHandler, clock: Clock, max_services: int) -> None:
        self._handler = handler
        self._clock = clock
        self._most = max_services
        self._followed: dict[str, _Followed] = {}
        self._by_type: dict[str, int] = {}
        self._waiting: OrderedDict[str, OrderedDict[str, ServiceNews]] = OrderedDict()
        self._some_wait = anyio.Event()
        self._missed: set[str] = set()
        self._changes: BoundedMap[str, RateLimit] = BoundedMap(MAX_REMEMBERED)
        self._asking = anyio.CapacityLimiter(MAX_ASKED)

    def on_news(self, news: ServiceNews) -> None:
        """Handle news of a service."""
        key = news.name.lower()
        followed = self._followed.get(key)
        if news.kind == "gone":
            for line in self._waiting.values():
                line.pop(key, None)
            if followed is not None:
                followed.scope.cancel()
                self._leave(followed, "it said goodbye")
        elif followed is not None:
            followed.news.set()
        else:
            line = self._waiting.get(news.sender) or OrderedDict()
            if key in line:
                return
            if len(line) >= (most := min(MAX_WAITING, MAX_WAITING_OF_ALL // (len(self._waiting) + 1))):
                self._missed.add(news.service_type)
                self._handler.refuse(news.name, f"more than {most} new services of its sender at once")
                return
            line[key] = news
            self._waiting[news.sender] = line
            self._some_wait.set()

    async def follow(self, network: ServiceNetwork, known: Iterable[FoundService] = ()) -> None:
        """Follow the services on *network* until cancelled; *known* ones that do not answer now are dropped."""
        self._followed.clear()
        self._by_type.clear()
        async with anyio.create_task_group() as tasks:
            for service in known:
                self._begin(
                    tasks, network, _Followed(service.service_type, service.key, TRIES_AFTER_LOSS, has_answered=True)
                )
            tasks.start_soon(self._ask_again, network)
            newcomers = RateLimit(PER_SECOND, BURST)
            while True:
                await self._some_wait.wait()
                while self._may_admit() and newcomers.admits(self._clock.monotonic()):
                    news = self._next()
                    if len(self._followed) >= self._most or self._by_type.get(news.service_type, 0) >= self._most // 2:
                        self._missed.add(news.service_type)
                        self._handler.refuse(news.name, f"more than {self._most} services, or half as many of its type")
                    elif news.name.lower() not in self._followed:
                        self._begin(tasks, network, _Followed(news.service_type, news.name))
                if any(self._waiting.values()):
                    await anyio.sleep(PACE)
                else:
                    self._some_wait = anyio.Event()

    def _may_admit(self) -> bool:
        """Return whether a service waits, and not too many names without a service take the places of others."""
        return (
            any(self._waiting.values())
            and sum(not followed.has_answered for followed in self._followed.values()) < MAX_ASKED
        )

    def _next(self) -> ServiceNews:
        """Return the next service to admit, of each sender in turn the newest; one waits."""
        while True:
            sender, line = self._waiting.popitem(last=False)
            if line:
                self._waiting[sender] = line
                return line.popitem()[1]

    def _begin(self, tasks: TaskGroup, network: ServiceNetwork, one: _Followed) -> None:
        one.changes = self._changes.pop(one.name.lower(), one.changes)
        self._followed[one.name.lower()] = one
        self._by_type[one.service_type] = self._by_type.get(one.service_type, 0) + 1
        tasks.start_soon(self._follow_one, network, one)

    async def _follow_one(self, network: ServiceNetwork, one: _Followed) -> None:
        with isolated(one.name), one.scope:
            await anyio.sleep(self._wait_for_change(one))  # it may come and go all the time
            while True:
                one.news = anyio.Event()
                service = network.resolve_cached(one.service_type, one.name) or await self._ask(network, one)
                if service is not None:
                    one.tries, one.has_answered = 1, True
                    self._handler.publish(service)
                    again_after = max(service.left + GRACE, SHORTEST)
                elif self._handler.confirm_connected(one.name):
                    again_after = KEPT_AGAIN
                else:
                    network.forget(one.service_type, one.name)
                    if not one.has_answered:
                        self._handler.refuse(one.name, "it is announced, and does not answer")
                    self._leave(one, "its announcement has run out, and it does not answer")
                    return
                with anyio.move_on_after(again_after):
                    await one.news.wait()
                    await anyio.sleep(max(PACE, self._wait_for_change(one)))  # most come in several messages

    def _wait_for_change(self, one: _Followed) -> float:
        """Count a change; return the seconds to wait before reading it."""
        wait = one.changes.charge(self._clock.monotonic())
        if wait > 0:
            self._handler.delay(one.name)
        return wait

    async def _ask(self, network: ServiceNetwork, one: _Followed) -> ResolvedService | None:
        for _ in range(one.tries):
            async with self._asking:
                service = await network.resolve(one.service_type, one.name, ANSWER_WITHIN)
            if service is not None:
                return service
        return None

    def _leave(self, one: _Followed, why: str) -> None:
        if self._followed.pop(one.name.lower(), None) is not None:
            self._by_type[one.service_type] -= 1
            self._changes[one.name.lower()] = one.changes
            self._handler.drop(one.name, why)

    async def _ask_again(self, network: ServiceNetwork) -> None:
        for turn in count(1):
            await anyio.sleep(ASK_AGAIN)
            missed, self._missed = self._missed, set()
            await network.ask_again(missed if turn % ALL_AGAIN else None)
