"""What the broker keeps for one client id, and the delivery of messages to it. No I/O.

A message at QoS 1 or 2 is *in flight* from the moment it is written until the client has acknowledged it; the
number in flight is bounded by the client's Receive Maximum, the others wait in the queue. When the client comes
back to its session, everything in flight is sent again, in the first order, before the queue.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Final, Protocol, final

from homebot.clock import Clock
from homebot.mqtt.broker.deadlines import Deadlines
from homebot.mqtt.broker.delivery import REFUSED, SLOW, TAKEN, Delivery
from homebot.mqtt.broker.limits import BrokerLimits
from homebot.mqtt.broker.message import BULKY
from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.queue import MessageQueue, Parcel
from homebot.mqtt.broker.queue_pool import QueuePool
from homebot.mqtt.broker.replay import Replay
from homebot.mqtt.broker.stats import Counters
from homebot.mqtt.broker.subscription import Subscription
from homebot.mqtt.broker.work import WorkBudget
from homebot.mqtt.packets import PacketError, Pubrel, ReasonCode

__all__ = ["HeldPublisher", "Session"]

_SENT: Final = 6  # units of work to send a retained message,
_BYTES: Final = 1000  # and bytes of it that are one more
_COPIED: Final = 4000  # bytes that are copied for one unit
_SMALL: Final = 1024  # bytes; messages up to this are not counted while they are in flight, where there are few


class HeldPublisher(Protocol):
    """A publisher that waits for slow sessions."""

    def caught_up(self, session: Session) -> None:
        """*session* has room again, or has gone."""
        ...


@final
class Session:
    """The state of one client id, while connected and in between.

    Attributes:
        client_id: Whose it is.
        expiry: Seconds it is kept after the connection ends; infinite for ever.
        outbound: Where messages go, None while the client is away.
        subscriptions: By the filter as the client gave it.
        received: Packet ids of QoS 2 messages taken from the client and not released.
        overrun: The client stayed too slow for too long; its queue takes no more than it has room for.
        held_publishers: Those who wait for this session to catch up.
        settled: How many messages the client has acknowledged, or taken from the queue at QoS 0, ever.

    Args:
        client_id: As above.
        clock: For expiry.
        limits: Bounds of the queue and of what is in flight.
        counters: Counts what is dropped.
        crowded: Where a session notes itself when its queue is three quarters full and its client connected; who
            reads it strikes it out.
        work: How much may be done for it now.
        pool: Counts what waits for all sessions.
        host: Where its client is.
    """

    def __init__(
        self,
        client_id: str,
        clock: Clock,
        limits: BrokerLimits,
        counters: Counters,
        crowded: dict[Session, None] | None = None,
        work: WorkBudget | None = None,
        pool: QueuePool | None = None,
        host: str = "",
    ) -> None:
        self.client_id = client_id
        self.expiry = 0.0
        self.outbound: Outbound | None = None
        self.subscriptions: dict[str, Subscription] = {}
        self.received: set[int] = set()
        self.overrun = False
        self.held_publishers: dict[HeldPublisher, None] = {}  # in their order, so that runs are alike
        self.settled = 0
        self._crowded = {} if crowded is None else crowded
        self._work = WorkBudget(clock, Deadlines()) if work is None else work
        self._clock = clock
        self._limits = limits
        self._counters = counters
        self._pool = QueuePool(limits.max_all_queued_bytes) if pool is None else pool
        self._queue = MessageQueue(limits.max_queued_messages, limits.max_queued_bytes, self._pool)
        self._unacknowledged = 0  # bytes of large messages in flight
        self.host = host
        self._in_flight: dict[int, Parcel | None] = {}  # None once PUBREC has come
        self._resend: deque[int] = deque()
        self._window = limits.max_inflight
        self._last_id = 0

    @property
    def queued(self) -> int:
        """Number of messages that wait."""
        return len(self._queue)

    @property
    def size(self) -> int:
        """The bytes of what waits for it, or is large and not acknowledged."""
        return self._queue.size + self._unacknowledged

    @property
    def congested(self) -> bool:
        """Whether the client is connected and too slow for what is sent to it."""
        return self.outbound is not None and self._queue.high

    @property
    def full(self) -> bool:
        """Whether the client is connected and its queue takes no more."""
        return self.outbound is not None and self._queue.full

    @property
    def backlogged(self) -> bool:
        """Whether more than half of the queue is used."""
        return not self._queue.low

    @property
    def reluctance(self) -> int:
        """How little a shared message is welcome: 0 connected, 1 connected but slow, 2 without room, 3 away."""
        if self.outbound is None:
            return 3
        if self._queue.full:
            return 2
        return int(len(self._in_flight) >= self._window or self.outbound.link.choked)

    def deliver(self, parcel: Parcel) -> Delivery:
        """Send a message or keep it for later.

        QoS 0: dropped while the client is away or its socket is full. QoS 1 and 2: queued; while the client is
        away the oldest makes room, while it is connected a message without room is refused.
        """
        outbound = self.outbound
        queue = self._queue
        if not parcel[1]:  # by place: by name it takes longer than all else that is asked here
            if outbound is None:
                return TAKEN
            if queue.holds_qos0 and not queue.full:
                queue.append(parcel)  # not past the retained message it replaces
            elif outbound.link.choked or queue.holds_qos0:
                self._counters.dropped_qos0 += 1
            else:
                outbound.publish(parcel)
            return TAKEN
        if outbound is None:
            return self._keep(parcel)
        if not queue.parcels and len(self._in_flight) < self._window and not outbound.link.choked:
            self._send(outbound, parcel)
            return TAKEN
        outcome = queue.offer(parcel)
        if outcome is TAKEN:
            return TAKEN
        if outcome is REFUSED:
            self._counters.dropped_overrun += 1
            return REFUSED
        self._crowded[self] = None
        return TAKEN if self.overrun else SLOW

    def deliver_large(self, parcel: Parcel) -> Delivery:
        """As :meth:`deliver`, for a message of at least ``BULKY`` bytes, of which each copy takes its time."""
        if self.outbound is None or self._queue:
            return self.deliver(parcel)
        if self._work.left:
            self._work.spend(parcel.message.size // _COPIED)
            return self.deliver(parcel)
        self._queue.append(parcel)
        self._work.later(self.pump)
        return TAKEN

    def replay(self, replay: Replay) -> None:
        """Queue the retained messages for new subscriptions, also those at QoS 0; :meth:`pump` finds and sends them.

        The queue's bound does not count here, since they are not in it; but a client that is overrun gets them only
        while its queue has room.
        """
        if self.overrun and self._queue.full:
            self._counters.dropped_overrun += 1
        else:
            self._queue.append_replay(replay)
            self._note_crowd()

    def replay_grew(self, replay: Replay) -> None:
        """More filters were added to *replay*, the one that was queued last."""
        self._queue.count_again(replay)
        self._note_crowd()

    def has(self, subscription: Subscription) -> bool:
        """Whether *subscription* still stands."""
        return self.subscriptions.get(subscription.name) is subscription

    def resume(self, outbound: Outbound, receive_maximum: int) -> None:
        """The client is connected: send what is in flight again, then what waited."""
        self.outbound = outbound
        self._window = min(receive_maximum, self._limits.max_inflight)
        self._resend.clear()
        for packet_id, parcel in self._in_flight.items():
            if parcel is None:
                outbound.send(Pubrel(packet_id))
            else:
                self._resend.append(packet_id)
        self._note_crowd()
        self.pump()

    def detach(self) -> None:
        """The client is gone; QoS 0 messages that wait are dropped, no publisher has to wait any more."""
        self.outbound = None
        self.overrun = False
        self._queue.drop_qos0()
        self._release_publishers()

    def pump(self) -> None:
        """Send what waits, as far as the client takes it."""
        outbound, queue, resend = self.outbound, self._queue, self._resend
        parcels, in_flight, window = queue.parcels, self._in_flight, self._window
        while outbound is not None and not outbound.link.choked:
            if resend and len(in_flight) - len(resend) < window:
                self._send_again(outbound, resend.popleft())
            elif not parcels:
                break
            elif type(first := parcels[0]) is Replay:
                if not self._go_on_with(outbound, first):
                    break
            else:
                message, qos, _, _, _ = parcel = first
                if qos and len(in_flight) >= window:
                    break
                if message.size >= BULKY:
                    if not self._work.left:
                        self._work.later(self.pump)
                        break
                    self._work.spend(message.size // _COPIED)
                queue.popleft()
                if message.expires_at is not None and message.expires_at <= self._clock.monotonic():
                    self._counters.dropped_expired += 1
                elif qos:
                    self._send(outbound, parcel)
                else:
                    outbound.publish(parcel)
                    self.settled += 1
        if (self.overrun or self.held_publishers) and queue.low:
            self.overrun = False
            self._release_publishers()

    def acknowledged(self, packet_id: int) -> None:
        """PUBACK came; what has room now is left to :meth:`pump`, once for all that came together.

        Raises:
            PacketError: 0x82, the message was not sent at QoS 1.
        """
        if packet_id not in self._in_flight:
            return
        parcel = self._in_flight[packet_id]
        if parcel is None or parcel[1] != 1:
            raise PacketError("PUBACK for a message at QoS 2", code=ReasonCode.PROTOCOL_ERROR)
        del self._in_flight[packet_id]
        self.settled += 1
        if parcel[0].size > _SMALL:
            self._count_in_flight(parcel, -1)
        if self._resend:
            self._not_again(packet_id)

    def taken(self, packet_id: int, reason: ReasonCode) -> ReasonCode:
        """PUBREC came; returns the reason that PUBREL is to carry: 0, or 0x92 for an id nobody knows.

        Raises:
            PacketError: 0x82, the message was not sent at QoS 2.
        """
        if packet_id not in self._in_flight:
            return ReasonCode.PACKET_IDENTIFIER_NOT_FOUND
        parcel = self._in_flight[packet_id]
        if parcel is not None and parcel.qos != 2:
            raise PacketError("PUBREC for a message at QoS 1", code=ReasonCode.PROTOCOL_ERROR)
        if reason.failed:
            self._forget(packet_id)
        else:
            self._in_flight[packet_id] = None
            if parcel is not None:
                self._count_in_flight(parcel, -1)
            self._not_again(packet_id)
        return ReasonCode.SUCCESS

    def completed(self, packet_id: int) -> None:
        """PUBCOMP came."""
        if packet_id in self._in_flight:
            self._forget(packet_id)

    def unsent_shares(self) -> Iterator[Parcel]:
        """Take all messages of shared subscriptions that this client has not acknowledged, for the others."""
        parcels = [each for each in self._in_flight.values() if each is not None]
        for parcel in parcels:
            self._count_in_flight(parcel, -1)
        parcels += self._queue.clear()
        self._in_flight.clear()
        self._resend.clear()
        return (each for each in parcels if each.share is not None and each.qos)

    def shrink(self) -> None:
        """Drop the oldest of what waits for an absent client, a quarter of it."""
        wanted = self._queue.size * 3 // 4
        while self._queue and self._queue.size > wanted:
            self._queue.popleft()
            self._counters.dropped_offline += 1

    def _count_in_flight(self, parcel: Parcel, sign: int) -> None:
        message = parcel.message
        if message.size > _SMALL:
            self._unacknowledged += sign * message.size
            if sign > 0:
                self._pool.hold(message)
            else:
                self._pool.release(message)

    def _keep(self, parcel: Parcel) -> Delivery:
        while self._queue and self._queue.full:
            self._queue.popleft()
            self._counters.dropped_offline += 1
        self._queue.append(parcel)
        return TAKEN

    def _go_on_with(self, outbound: Outbound, replay: Replay) -> bool:
        """Send a message of *replay*, or strike it out when it is over; False where it has to wait."""
        work = self._work
        owed = replay.first(work, self._clock.monotonic())
        if owed is None:
            if replay.is_over:
                self._queue.popleft()
                return True
            if replay.complete:
                work.later(self.pump)
            return False
        message, subscription = owed
        qos = min(message.qos, subscription.qos)
        if qos and len(self._in_flight) >= self._window:
            return False
        if not work.left:
            work.later(self.pump)
            return False
        replay.popleft()
        work.spend(_SENT + message.size // _BYTES)
        identifiers = (subscription.identifier,) if subscription.identifier else ()
        parcel = Parcel(message, qos, retain=True, identifiers=identifiers)
        if qos:
            self._send(outbound, parcel)
        else:
            outbound.publish(parcel)
            self.settled += 1
        return True

    def _note_crowd(self) -> None:
        if self._queue.high:
            self._crowded[self] = None

    def _send(self, outbound: Outbound, parcel: Parcel) -> None:
        packet_id = self._last_id
        while True:
            packet_id = packet_id % 65_535 + 1
            if packet_id not in self._in_flight:
                break
        self._last_id = packet_id
        if outbound.publish(parcel, packet_id):
            self._in_flight[packet_id] = parcel
            if parcel[0].size > _SMALL:
                self._count_in_flight(parcel, 1)

    def _send_again(self, outbound: Outbound, packet_id: int) -> None:
        parcel = self._in_flight[packet_id]
        if parcel is not None and not outbound.publish(parcel, packet_id, dup=True):
            del self._in_flight[packet_id]
            self._count_in_flight(parcel, -1)

    def _forget(self, packet_id: int) -> None:
        self.settled += 1
        parcel = self._in_flight.pop(packet_id)
        if parcel is not None and parcel.message.size > _SMALL:
            self._count_in_flight(parcel, -1)
        if self._resend:
            self._not_again(packet_id)
        if self._queue or self._resend:
            self.pump()
        elif self.held_publishers:
            self._release_publishers()

    def _not_again(self, packet_id: int) -> None:
        if packet_id in self._resend:  # it was answered before it was sent again
            self._resend.remove(packet_id)

    def _release_publishers(self) -> None:
        publishers, self.held_publishers = self.held_publishers, {}
        for publisher in publishers:
            publisher.caught_up(self)
