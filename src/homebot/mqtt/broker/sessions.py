"""The sessions of all clients: opened, kept while a client is away, resumed, ended. No I/O."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import inf
from typing import final

from homebot.clock import Clock
from homebot.mqtt.broker.deadlines import BrokerTimers, Deadline
from homebot.mqtt.broker.exchange import MessageRouter
from homebot.mqtt.broker.limits import BrokerLimits
from homebot.mqtt.broker.message import BrokerMessage, size_of
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.stats import Counters
from homebot.mqtt.packets import Will
from homebot.support.turn_budget import TurnBudget


@final
class Sessions:
    """All sessions by client id, with their planned ends."""

    def __init__(
        self,
        exchange: MessageRouter,
        clock: Clock,
        deadlines: BrokerTimers,
        limits: BrokerLimits,
        counters: Counters,
        turn: TurnBudget,
        count_bytes: Callable[[int], None],
    ) -> None:
        self._exchange = exchange
        self._clock = clock
        self._deadlines = deadlines
        self._limits = limits
        self._counters = counters
        self._turn = turn
        self._count_bytes = count_bytes
        self._sessions: dict[str, BrokerSession] = {}
        self._away: dict[str, _Absence] = {}  # in order of leaving

    def __iter__(self) -> Iterator[BrokerSession]:
        return iter(self._sessions.values())

    def __len__(self) -> int:
        return len(self._sessions)

    @property
    def queued(self) -> int:
        """Number of waiting messages of all sessions."""
        return sum(session.queued for session in self._sessions.values())

    @property
    def will_bytes(self) -> int:
        """The size of the delayed wills."""
        return sum(will_size(absence.will) for absence in self._away.values())

    def open(self, client_id: str, *, clean_start: bool, host: str = "") -> tuple[BrokerSession, bool]:
        """Return the session for a client that has just connected, and whether it already existed.

        The caller has already detached an earlier connection with the same id.
        """
        if clean_start:
            self.end(client_id)
        absence = self._away.pop(client_id, None)
        if absence is not None:
            absence.over()
            return self._sessions[client_id], True
        if len(self._sessions) >= self._limits.max_sessions and self._away:
            self._counters.sessions_evicted += 1
            hosts = [self._sessions[client_id].host for client_id in self._away]
            most = Counter(hosts).most_common(1)[0][0]
            self.end(next(client_id for client_id, host in zip(self._away, hosts, strict=True) if host == most))
        session = BrokerSession(
            client_id,
            self._clock,
            self._limits,
            self._counters,
            self._turn,
            self._exchange.crowded,
            self._count_bytes,
            host,
        )
        self._sessions[client_id] = session
        return session, False

    def detach(self, session: BrokerSession, will: Will | None) -> None:
        """Keep or end the *session* of a client that has left.

        Args:
            will: The will to publish after its delay or at the end of the session, or None.
        """
        absence = _Absence(will)
        self._away[session.client_id] = absence
        if session.expiry <= 0:
            self.end(session.client_id)
            return
        now = self._clock.monotonic()
        if session.expiry < inf:
            absence.end = self._plan(now + session.expiry, session.client_id, lambda: self.end(session.client_id))
        delay = will.properties.will_delay_interval if will is not None else None
        if will is not None and not delay:
            self._publish_will(session.client_id, absence)
        elif delay and delay < session.expiry:
            absence.will_due = self._plan(
                now + delay, session.client_id, lambda: self._publish_will(session.client_id, absence)
            )

    def end(self, client_id: str) -> None:
        """End the session of an absent client, and publish a delayed will now."""
        absence = self._away.pop(client_id, None)
        if absence is None:
            return
        absence.over()
        session = self._sessions.pop(client_id)
        self._exchange.forget(session)
        self._publish_will(client_id, absence)

    def end_all(self) -> None:
        """Discard all sessions, without publishing their wills."""
        for absence in self._away.values():
            absence.over()
        for session in self._sessions.values():
            self._exchange.forget(session)

    def _plan(self, when: float, client_id: str, act: Callable[[], None]) -> Deadline:
        """Schedule *act* for the first turn with time from *when* on, unless the client returns before."""
        absence = self._away[client_id]

        def steps() -> Iterator[None]:
            if self._away.get(client_id) is absence:
                act()
            yield

        return self._deadlines.at(when, lambda: self._turn.run(steps()))

    def _publish_will(self, client_id: str, absence: _Absence) -> None:
        will, absence.will = absence.will, None
        if will is None:
            return
        properties = replace(will.properties, will_delay_interval=None)
        interval = properties.message_expiry_interval
        expires_at = None if interval is None else self._clock.monotonic() + interval
        self._exchange.publish(
            BrokerMessage(will.topic, will.payload, will.qos, will.retain, properties, client_id, expires_at)
        )


def will_size(will: Will | None) -> int:
    """Return the estimated bytes of *will*."""
    return 0 if will is None else len(will.topic) + len(will.payload) + size_of(will.properties)


class _Absence:
    """The deadlines of an absent client: the end of its session, and its will."""

    __slots__ = ("end", "will", "will_due")

    def __init__(self, will: Will | None) -> None:
        self.will = will
        self.end: Deadline | None = None
        self.will_due: Deadline | None = None

    def over(self) -> None:
        for deadline in (self.end, self.will_due):
            if deadline is not None:
                deadline.cancel()
