"""The session of one client id: its stored messages and their delivery. No I/O.

The number of messages in flight is bounded; the others wait in the queue. When the client resumes its session,
everything in flight is sent again before the queue.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final, final

from homebot.clock import Clock
from homebot.mqtt.broker.in_flight import InFlight
from homebot.mqtt.broker.limits import BrokerLimits
from homebot.mqtt.broker.message import BULKY
from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.queue import REFUSED, SLOW, TAKEN, DeliveryResult, MessageQueue, QueuedMessage
from homebot.mqtt.broker.retained import Replay
from homebot.mqtt.broker.session_subscription import SessionSubscription
from homebot.mqtt.broker.stats import Counters
from homebot.mqtt.packets import ReasonCode
from homebot.support.turn_budget import TurnBudget

_UNCHECKED: Final = 16  # messages sent before the clock is read


@final
class BrokerSession:
    """The state of one client id, whether connected or not.

    Attributes:
        expiry: Seconds for which it outlives the connection; may be infinite.
        outbound: The writer to the client; None while it is away.
        received: Packet ids of QoS 2 messages received from the client and not released.
        held_publishers: Called once the session has room again or has ended.
        overrun: Whether the client has been too slow for too long, so that its queue accepts no more than fits.

    Args:
        crowded: Receives the session when its queue is three quarters full and its client connected; its reader
            removes it.
    """

    def __init__(
        self,
        client_id: str,
        clock: Clock,
        limits: BrokerLimits,
        counters: Counters,
        turn: TurnBudget,
        crowded: dict[BrokerSession, None] | None = None,
        count_bytes: Callable[[int], None] = lambda _: None,
        host: str = "",
    ) -> None:
        self.client_id = client_id
        self.expiry = 0.0
        self.outbound: Outbound | None = None
        self.subscriptions: dict[str, SessionSubscription] = {}
        self.received: set[int] = set()
        self.has_ended = False
        self.overrun = False
        self.held_publishers: dict[Callable[[BrokerSession], None], None] = {}  # ordered, for reproducible runs
        self._congested = {} if crowded is None else crowded
        self._turn = turn
        self._clock = clock
        self._limits = limits
        self._counters = counters
        self._queue = MessageQueue(limits.max_queued_messages, limits.max_queued_bytes, count_bytes)
        self.host = host
        self.in_flight = InFlight(limits.max_inflight, count_bytes)
        self._settled = 0

    @property
    def queued(self) -> int:
        """Number of waiting messages."""
        return len(self._queue)

    @property
    def size(self) -> int:
        """The bytes of its waiting messages, and of large unacknowledged ones."""
        return self._queue.size + self.in_flight.size

    @property
    def settled(self) -> int:
        """Total number of messages acknowledged by the client, or sent to it from the queue at QoS 0."""
        return self.in_flight.settled + self._settled

    @property
    def congested(self) -> bool:
        """True if the client is connected and too slow."""
        return self.outbound is not None and self._queue.high

    @property
    def full(self) -> bool:
        """True if the client is connected and its queue is full."""
        return self.outbound is not None and self._queue.full

    @property
    def backlogged(self) -> bool:
        """True if more than half of the queue is used."""
        return not self._queue.low

    @property
    def delivery_priority(self) -> int:
        """The rank for shared messages, lowest first: 0 connected, 1 connected but slow, 2 without room, 3 away."""
        if self.outbound is None:
            return 3
        if self._queue.full:
            return 2
        return int(self.in_flight.full or self.outbound.link.write_blocked)

    def deliver(self, queued: QueuedMessage) -> DeliveryResult:
        """Send a message or keep it for later.

        QoS 0: dropped while the client is away or its socket is full. QoS 1 and 2: queued; if the queue is full, the
        oldest message makes room while the client is away, and the new one is refused while it is connected.
        """
        outbound = self.outbound
        queue = self._queue
        if not queued[1]:  # by index, as by name it takes longer than everything else here
            if outbound is None:
                return TAKEN
            if queue.holds_qos0 and not queue.full:
                queue.append(queued)  # not past the retained message it replaces
            elif queue.holds_qos0 or outbound.link.write_blocked:
                self._counters.dropped_qos0 += 1
            else:
                outbound.publish(queued)
            return TAKEN
        if outbound is None:
            return self._enqueue_offline(queued)
        in_flight = self.in_flight
        if not queue.messages and len(in_flight.messages) < in_flight.window and not outbound.link.write_blocked:
            in_flight.send(outbound, queued)
            return TAKEN
        outcome = queue.offer(queued)
        if outcome is TAKEN:
            return TAKEN
        if outcome is REFUSED:
            self._counters.dropped_overrun += 1
            return REFUSED
        self._congested[self] = None
        return TAKEN if self.overrun else SLOW

    def deliver_large(self, queued: QueuedMessage) -> DeliveryResult:
        """Like :meth:`deliver`, for a message of at least ``BULKY`` bytes, whose copies take time."""
        if self.outbound is None or self._queue:
            return self.deliver(queued)
        if self._turn.has_time():
            return self.deliver(queued)
        self._queue.append(queued)
        self._turn.defer(self.pump)
        return TAKEN

    def replay(self, replay: Replay) -> None:
        """Queue the retained messages for new subscriptions, QoS 0 included; :meth:`pump` finds and sends them.

        The queue's limit does not apply, since they are not stored in it; but an overrun client gets them only while
        its queue has room.
        """
        if self.overrun and self._queue.full:
            self._counters.dropped_overrun += 1
        else:
            self._queue.append_replay(replay)
            self._mark_congested()

    def replay_grew(self, replay: Replay) -> None:
        """Update the size of *replay*, the last one queued, after filters were added to it."""
        self._queue.count_again(replay)
        self._mark_congested()

    def has(self, subscription: SessionSubscription) -> bool:
        """Return whether *subscription* still exists."""
        return self.subscriptions.get(subscription.name) is subscription

    def resume(self, outbound: Outbound, receive_maximum: int) -> None:
        """Repeat messages in flight to the connected client, then send the queue."""
        self.outbound = outbound
        self.in_flight.resume(outbound, min(receive_maximum, self._limits.max_inflight))
        self._mark_congested()
        self.pump()

    def detach(self) -> None:
        """Detach the client that has left: drop waiting QoS 0 messages, and release waiting publishers."""
        self.outbound = None
        self.overrun = False
        self._queue.drop_qos0()
        self._release_publishers()

    def pump(self) -> None:
        """Send queued messages, as far as the client and this turn allow."""
        outbound, queue, in_flight = self.outbound, self._queue, self.in_flight
        messages, sent, resend, window = queue.messages, in_flight.messages, in_flight.resend, in_flight.window
        unchecked = _UNCHECKED
        while outbound is not None and not outbound.link.write_blocked:
            unchecked -= 1
            if unchecked < 0 and not self._turn.has_time():
                self._turn.defer(self.pump)
                break
            if resend and len(sent) - len(resend) < window:
                in_flight.send_again(outbound)
            elif not messages:
                break
            elif type(first := messages[0]) is Replay:
                if not self._go_on_with(outbound, first):
                    break
            else:
                if first.qos and len(sent) >= window:
                    break
                if first.message.size >= BULKY:
                    unchecked = 0
                queue.popleft()
                self._send(outbound, first)
        self._catch_up()

    def taken(self, packet_id: int, reason: ReasonCode) -> ReasonCode:
        """Handle a PUBREC; see :meth:`InFlight.received`."""
        answer = self.in_flight.received(packet_id, reason)
        if reason.failed:
            self.pump()
        return answer

    def completed(self, packet_id: int) -> None:
        """Handle a PUBCOMP."""
        self.in_flight.completed(packet_id)
        self.pump()

    def unsent(self) -> Iterator[QueuedMessage]:
        """Remove and yield all messages that this client has not acknowledged."""
        yield from self.in_flight.clear()
        yield from self._queue.clear()

    def shrink(self) -> None:
        """Drop the oldest quarter of the queue of an absent client."""
        wanted = self._queue.size * 3 // 4
        while self._queue and self._queue.size > wanted:
            self._queue.popleft()
            self._counters.dropped_offline += 1

    def _enqueue_offline(self, queued: QueuedMessage) -> DeliveryResult:
        while self._queue and self._queue.full:
            self._queue.popleft()
            self._counters.dropped_offline += 1
        self._queue.append(queued)
        return TAKEN

    def _go_on_with(self, outbound: Outbound, replay: Replay) -> bool:
        """Send a message of *replay*, or remove it if it is over; return False if it has to wait."""
        owed = replay.first(self._turn, self._clock.monotonic())
        if owed is None:
            if replay.is_over:
                self._queue.popleft()
                return True
            if replay.complete:
                self._turn.defer(self.pump)
            return False
        message, subscription = owed
        qos = min(message.qos, subscription.qos)
        if qos and self.in_flight.full:
            return False
        replay.popleft()
        identifiers = (subscription.identifier,) if subscription.identifier else ()
        queued = QueuedMessage(message, qos, retain=True, identifiers=identifiers)
        self._send(outbound, queued)
        return True

    def _send(self, outbound: Outbound, queued: QueuedMessage) -> None:
        """Send a message, or drop it if it has expired."""
        message, qos, _, _, _ = queued
        if message.expires_at is not None and message.expired(self._clock.monotonic()):
            self._counters.dropped_expired += 1
        elif qos:
            self.in_flight.send(outbound, queued)
        else:
            outbound.publish(queued)
            self._settled += 1

    def _mark_congested(self) -> None:
        if self._queue.high:
            self._congested[self] = None

    def _catch_up(self) -> None:
        """Release the waiting publishers once half of the queue is free."""
        if (self.overrun or self.held_publishers) and self._queue.low:
            self.overrun = False
            self._release_publishers()

    def _release_publishers(self) -> None:
        publishers, self.held_publishers = self.held_publishers, {}
        for caught_up in publishers:
            caught_up(self)
