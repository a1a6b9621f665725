"""SUBSCRIBE and UNSUBSCRIBE, taken a few filters at a time. No I/O."""

from __future__ import annotations

from collections.abc import Callable
from typing import final

from homebot.mqtt.broker.backpressure import Backpressure
from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.retained import Replay, RetainedMessages
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.packets import FilterRequest, ReasonCode, Suback, Subscribe, Unsuback, Unsubscribe

__all__ = ["FilterRequests"]


@final
class FilterRequests:
    """Carries out the SUBSCRIBE and UNSUBSCRIBE packets of one client, one after the other.

    Args:
        is_bridge: Whether the client is another broker, which is not sent what it published itself, and is told what is
            retained; before MQTT 5 it cannot ask for that.
    """

    def __init__(
        self,
        state: BrokerState,
        session: BrokerSession,
        outbound: Outbound,
        holding: Backpressure,
        go_on: Callable[[], None],
        *,
        is_bridge: bool = False,
    ) -> None:
        self._state = state
        self._session = session
        self._outbound = outbound
        self._holding = holding
        self._resume = go_on
        self._is_bridge = is_bridge
        self._current: _Subscribing | _Unsubscribing | None = None

    @property
    def active(self) -> bool:
        """True if a packet is under way."""
        return self._current is not None

    def subscribe(self, packet: Subscribe) -> None:
        """Begin with a SUBSCRIBE."""
        if self._is_bridge:
            packet = packet._replace(filters=tuple(map(_of_bridge, packet.filters)))
        self._current = _Subscribing(self._session, packet, self._state.exchange.retained)
        self._go_on()

    def unsubscribe(self, packet: Unsubscribe) -> None:
        """Begin with an UNSUBSCRIBE."""
        self._current = _Unsubscribing(self._session, packet)
        self._go_on()

    def stop(self) -> None:
        """Stop after the client has left; finished work stays."""
        self._current = None
        self._state.turn.forget(self._go_on)

    def _go_on(self) -> None:
        """Take as many filters as may be taken now."""
        if self._current is None:
            return
        answer = self._current.go_on(self._state)
        if answer is None:
            self._holding.paused = True
            self._state.turn.defer(self._go_on)
            return
        self._current = None
        self._outbound.send(answer)
        session = self._session
        session.pump()
        if session.congested and not session.overrun:
            self._holding.wait_for((session,))
        self._resume()


def _of_bridge(request: FilterRequest) -> FilterRequest:
    is_shared = request.filter.startswith("$share/")
    return request._replace(no_local=not is_shared, retain_as_published=True)


@final
class _Subscribing:
    """A SUBSCRIBE under way."""

    def __init__(self, session: BrokerSession, packet: Subscribe, retained: RetainedMessages) -> None:
        self._session = session
        self._packet = packet
        self._replay = Replay(retained, session.has)
        self._is_queued = False
        self._reasons: list[ReasonCode] = []

    def go_on(self, state: BrokerState) -> Suback | None:
        """Take as many filters as may be taken now; the answer, or None where some are left."""
        session, requests, reasons = self._session, self._packet.filters, self._reasons
        identifier = (*self._packet.properties.subscription_identifiers, 0)[0]
        while len(reasons) < len(requests):
            if not state.turn.has_time():
                self._queue()  # now, so that nothing that comes meanwhile overtakes it
                return None
            request = requests[len(reasons)]
            reason = state.policy.subscribe(session.client_id, request.filter)
            if not reason.failed:
                reason = state.exchange.subscribe(session, request, identifier, self._replay)
            reasons.append(reason)
        self._replay.complete = True
        if self._replay.size:
            self._queue()
        return Suback(self._packet.packet_id, tuple(reasons))

    def _queue(self) -> None:
        if self._is_queued:
            self._session.replay_grew(self._replay)
        else:
            self._session.replay(self._replay)
            self._is_queued = True


@final
class _Unsubscribing:
    """An UNSUBSCRIBE under way."""

    def __init__(self, session: BrokerSession, packet: Unsubscribe) -> None:
        self._session = session
        self._packet = packet
        self._reasons: list[ReasonCode] = []

    def go_on(self, state: BrokerState) -> Unsuback | None:
        """Take as many filters as may be taken now; the answer, or None where some are left."""
        names, reasons = self._packet.filters, self._reasons
        while len(reasons) < len(names):
            if not state.turn.has_time():
                return None
            name = names[len(reasons)]
            reasons.append(state.exchange.unsubscribe(self._session, name))
        return Unsuback(self._packet.packet_id, tuple(reasons))
