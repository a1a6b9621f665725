"""Backpressure: a publisher is held back while a subscriber is slow, instead of losing messages. No I/O.

Meanwhile its packets wait here in order; if there are too many, its socket is not read. After ``limits.hold_time`` the
slow sessions are marked as overrun and the publisher continues; messages without room are refused. Before MQTT 5 they
cannot be refused, and wait as long as the slow session settles at least ``limits.max_inflight`` messages in that time;
otherwise its connection is closed.
"""

from collections import deque
from collections.abc import Callable, Iterable
from typing import final

from homebot.mqtt.broker.deadlines import Deadline
from homebot.mqtt.broker.ports import Transport
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.state import BrokerState, short
from homebot.mqtt.packets import Packet, Publish, ReasonCode


@final
class Backpressure:
    """The waiting packets of one publisher, and the sessions for which they wait.

    Args:
        go_on: Called, never from within another call, at the end of the wait; it handles the packets.

    Attributes:
        messages: The number of waiting messages at QoS 1 or 2.
        size: The bytes of their topics and payloads.
    """

    def __init__(self, state: BrokerState, link: Transport, go_on: Callable[[], None]) -> None:
        self.packets: deque[Packet] = deque()
        self.messages = 0
        self.size = 0
        self.reading = True
        self.paused = False
        self._state = state
        self._link = link
        self._go_on = go_on
        self._slow: dict[BrokerSession, int] = {}  # with the number of settled messages at the start of the wait
        self._is_endless = False
        self._end: Deadline | None = None

    @property
    def active(self) -> bool:
        """True if packets must wait: for a slow session, or behind waiting packets."""
        return self._end is not None or bool(self.packets) or self.paused

    def wait_for(self, slow: Iterable[BrokerSession], *, endless: bool = False) -> None:
        """Wait until all of *slow* have caught up or left.

        Args:
            endless: Wait beyond the time limit, except for sessions that make no progress.
        """
        self._is_endless = endless
        for session in slow:
            self._slow[session] = session.settled
            session.held_publishers[self.caught_up] = None
        if self._end is None:
            self._state.counters.holds += 1
            self._wait_on()

    def push_front(self, packet: Packet) -> None:
        """Queue *packet* before all others."""
        self.packets.appendleft(packet)
        self._count(packet, 1)

    def push(self, packet: Packet) -> None:
        """Queue *packet*."""
        self.packets.append(packet)
        self._count(packet, 1)
        limits = self._state.limits
        if self.reading and (len(self.packets) >= limits.max_held_packets or self.size >= limits.max_held_bytes):
            self.reading = False
            self._link.pause_reading()

    def pop(self) -> Packet | None:
        """Remove and return the oldest packet; None during the wait or if there is none."""
        if self._slow or self.paused or not self.packets:
            return None
        packet = self.packets.popleft()
        self._count(packet, -1)
        limits = self._state.limits
        has_room = len(self.packets) < limits.max_held_packets // 2 and self.size <= limits.max_held_bytes // 2
        if not self.reading and has_room:
            self.reading = True
            self._link.resume_reading()
        return packet

    def caught_up(self, session: BrokerSession) -> None:
        """Stop waiting for *session*, which has room again or has left."""
        self._slow.pop(session, None)
        if not self._slow and self._end is not None:
            self._end.cancel()
            self._end = self._state.deadlines.at(self._state.clock.monotonic(), self._over)

    def stop(self) -> None:
        """End the wait; the packets remain."""
        for session in self._slow:
            session.held_publishers.pop(self.caught_up, None)
        self._slow.clear()
        if self._end is not None:
            self._end.cancel()
            self._end = None

    def _count(self, packet: Packet, sign: int) -> None:
        if isinstance(packet, Publish):
            self.messages += sign * (packet.qos > 0)
            self.size += sign * (len(packet.topic) + len(packet.payload))

    def _wait_on(self) -> None:
        until = self._state.clock.monotonic() + self._state.limits.hold_time
        self._end = self._state.deadlines.at(until, self._time_is_up)

    def _time_is_up(self) -> None:
        if self._is_endless:
            self._close_stalled()
        else:
            for session in self._slow:
                session.overrun = True
                self._state.warn(
                    "broker.client_too_slow",
                    f"client {short(session.client_id)!r} is too slow: {session.queued} messages wait for it; "
                    "messages that do not fit are refused",
                    client_id=session.client_id,
                    queued=session.queued,
                )
            self.stop()
            self._go_on()

    def _close_stalled(self) -> None:
        state = self._state
        enough = state.limits.max_inflight
        stalled = [session for session, before in self._slow.items() if session.settled - before < enough]
        self._slow = {session: session.settled for session in self._slow}
        self._wait_on()
        for session in stalled:
            state.counters.clients_stalled += 1
            state.warn(
                "broker.client_stalled",
                f"the broker cut off client {short(session.client_id)!r}: {session.queued} messages wait for it, and "
                f"it acknowledged fewer than {enough} in {state.limits.hold_time:g} s",
                client_id=session.client_id,
                queued=session.queued,
            )
            state.peers[session.client_id].end(ReasonCode.QUOTA_EXCEEDED)

    def _over(self) -> None:
        if not self._slow:
            self._end = None
            self._go_on()
