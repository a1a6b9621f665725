"""The broker without sockets, from its parts. A carrier supplies links, bytes and the time.

Everything runs in order on one thread; no method waits.
"""

from collections.abc import Callable
from random import Random, SystemRandom
from typing import final

from homebot.clock import Clock
from homebot.log import LogLimit, more_like_this
from homebot.mqtt.broker.authentication import Authentication, LoginThrottle, WaitingLogins
from homebot.mqtt.broker.deadlines import BrokerTimers
from homebot.mqtt.broker.exchange import MessageRouter
from homebot.mqtt.broker.limits import BrokerLimits
from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.ports import BrokerPolicy, ConnectedClient, ConnectionHandler, RefusedFilters
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.sessions import Sessions
from homebot.mqtt.broker.stats import BrokerStats, Counters
from homebot.mqtt.packets import ReasonCode
from homebot.support.byte_account import ByteAccount
from homebot.support.logger import get_logger
from homebot.support.turn_budget import SHARE, TurnBudget

_WARNINGS = 20  # per event in ten seconds: enough to distinguish a few clients
_MAX_TEXT = 100  # a client may choose a name or topic of 65,535 bytes
_log = get_logger()


@final
class BrokerState:
    """The state that all connections of one broker share.

    Args:
        authentication: The check of logins; by default everyone may log in.
        policy: Rights to publish and subscribe; by default all.
        call_soon: Schedules a call in the next turn of the event loop; by default the next run of the deadlines.

    Attributes:
        deadlines: Scheduled work, which the carrier runs.
        turn: The budget of each turn of the event loop for all connections together.
        throttle: The delays after wrong passwords.
        queued: The bytes of messages waiting for sessions, each counted once.
        unread: The bytes of incomplete packets of logged-in clients.
        unread_logins: The same for connections before their login.
    """

    def __init__(
        self,
        clock: Clock,
        limits: BrokerLimits,
        authentication: Authentication | None = None,
        policy: BrokerPolicy | None = None,
        keep_alive: int | None = None,
        on_message: Callable[[BrokerMessage], None] | None = None,
        random: Random | None = None,
        call_soon: Callable[[Callable[[], None]], object] | None = None,
    ) -> None:
        self.clock = clock
        self.limits = limits
        self.authentication = authentication or Authentication()
        self.policy = policy or RefusedFilters()
        self.keep_alive = keep_alive
        self.random = random or SystemRandom()
        self.counters = Counters()
        self.deadlines = BrokerTimers()
        self.turn = TurnBudget(clock.monotonic, call_soon or self._call_at_next_run)
        self._on_message = on_message
        self.peers: dict[str, ConnectedClient] = {}
        self.waiting_logins = WaitingLogins(limits.max_waiting_logins)
        self.throttle = LoginThrottle(clock)
        self.queued = ByteAccount(
            limits.max_all_queued_bytes,
            lambda: (*self.sessions, *self.exchange.ended),
            lambda session: session.size,
            self._relieve,
        )
        self.queued.on_overrun = self._plan_relief
        self._is_relief_planned = False
        self.unread_logins = ByteAccount(
            max(limits.max_unread_login_bytes, limits.max_connect_size),
            lambda: self.waiting_logins,
            _unread,
            _refuse_unread,
        )
        self.unread = ByteAccount(
            max(limits.max_unread_bytes, limits.max_packet_size), self.peers.values, _unread, _refuse_unread
        )
        self._log_limit = LogLimit(clock, burst=_WARNINGS)
        self._clear()

    @property
    def stats(self) -> BrokerStats:
        """A snapshot of all counters."""
        return BrokerStats.of(
            self.counters,
            clients=len(self.peers),
            sessions=len(self.sessions),
            subscriptions=len(self.exchange.subscriptions),
            retained_messages=len(self.exchange.retained),
            retained_bytes=self.exchange.retained.size,
            queued_messages=self.sessions.queued,
            waiting_work=self.turn.waiting,
        )

    def forget(self) -> None:
        """Discard all sessions, wills and retained messages once no client is connected."""
        self.peers.clear()  # clients that have left may still have messages
        self.sessions.end_all()
        self._clear()

    def warn(self, event: str, message: str, **facts: object) -> None:
        """Log an event caused from outside: 20 lines per event in ten seconds, the rest counted.

        Args:
            facts: Further facts; texts are cut to 100 characters.
        """
        held_back = self._log_limit.allows(event)
        if held_back is None:
            return
        known = {key: short(fact) if isinstance(fact, str) else fact for key, fact in facts.items()}
        _log.warning(event, message=f"{message}{more_like_this(held_back)}", held_back=held_back, **known)

    def receive(self, peer: ConnectionHandler, data: bytes, address: str) -> None:
        """Pass *data* to *peer*; an error of the broker only costs this connection."""
        try:
            peer.receive(data)
        except Exception as error:  # noqa: BLE001 - it must not reach the other connections
            peer.end(ReasonCode.IMPLEMENTATION_SPECIFIC_ERROR)
            self.warn(
                "broker.internal_error",
                f"the broker failed on a packet from {peer.client_text} and disconnected it: {error!r}",
                address=address,
                error=repr(error),
                exc_info=True,
            )

    @property
    def will_bytes(self) -> int:
        """The size of the wills of all clients, delayed ones included."""
        return self.sessions.will_bytes + sum(peer.will_bytes for peer in self.peers.values())

    def _call_at_next_run(self, call: Callable[[], None]) -> None:
        self.deadlines.at(self.clock.monotonic(), call)

    def _plan_relief(self) -> None:
        """Schedule making room for a turn after the current flood."""
        if not self._is_relief_planned:
            self._is_relief_planned = True
            self.deadlines.at(self.clock.monotonic(), self._relieve_queues)

    def _relieve_queues(self) -> None:
        self._is_relief_planned = False
        ends = self.clock.monotonic() + SHARE
        if not self.queued.relieve(lambda: self.clock.monotonic() < ends):
            self._plan_relief()

    def _relieve(self, session: BrokerSession) -> bool:
        """Make room: a session loses its connection first, then its oldest messages; return True for the former."""
        if session.outbound is not None:
            self.counters.clients_stalled += 1
            self.warn(
                "broker.client_stalled",
                f"the broker cut off client {short(session.client_id)!r}: {session.queued} messages wait for it, "
                "more than for any other, and there is no room for the others",
                client_id=session.client_id,
                queued=session.queued,
            )
            self.peers[session.client_id].end(ReasonCode.QUOTA_EXCEEDED)
            return True
        if session.queued:
            session.shrink()
        elif session.has_ended or session.client_id in self.peers:  # it will close, but has not yet
            self.counters.dropped_offline += len(session.in_flight.clear())
        else:
            self.counters.sessions_evicted += 1
            self.sessions.end(session.client_id)
        return False

    def _clear(self) -> None:
        self.exchange = MessageRouter(self.clock, self.limits, self.counters, self.turn, self._on_message)
        self.sessions = Sessions(
            self.exchange, self.clock, self.deadlines, self.limits, self.counters, self.turn, self.queued.add
        )


def _unread(client: ConnectedClient) -> int:
    return client.unread


def _refuse_unread(client: ConnectedClient) -> None:
    client.refuse_unread()


def short(text: str) -> str:
    """Return *text*, cut to 100 characters."""
    return text if len(text) <= _MAX_TEXT else f"{text[: _MAX_TEXT - 1]}…"
