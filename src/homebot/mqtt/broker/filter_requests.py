"""SUBSCRIBE and UNSUBSCRIBE, handled a few filters at a time. No I/O."""

from collections.abc import Callable, Generator
from typing import final

from homebot.mqtt.broker.backpressure import Backpressure
from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.retained import Replay
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.packets import MqttSubscription, Suback, Subscribe, Unsuback, Unsubscribe


@final
class FilterRequests:
    """The handler of one client's SUBSCRIBE and UNSUBSCRIBE packets, one after the other.

    Args:
        is_bridge: Whether the client is another broker: it is not sent its own messages, and the retain flag is kept;
            it cannot request that before MQTT 5.
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
        self._work: Generator[None, None, Suback | Unsuback] | None = None

    @property
    def active(self) -> bool:
        """True while a packet is being handled."""
        return self._work is not None

    def subscribe(self, packet: Subscribe) -> None:
        """Begin with a SUBSCRIBE."""
        if self._is_bridge:
            packet = packet._replace(filters=tuple(map(_of_bridge, packet.filters)))
        self._work = self._add_filters(packet)
        self._go_on()

    def unsubscribe(self, packet: Unsubscribe) -> None:
        """Begin with an UNSUBSCRIBE."""
        self._work = self._remove_filters(packet)
        self._go_on()

    def stop(self) -> None:
        """Stop after the client has left, keeping finished work."""
        self._work = None
        self._state.turn.forget(self._go_on)

    def _go_on(self) -> None:
        """Handle as many filters as this turn has time for."""
        if self._work is None:
            return
        try:
            next(self._work)
        except StopIteration as finished:
            answer: Suback | Unsuback = finished.value
        else:
            self._holding.paused = True
            self._state.turn.defer(self._go_on)
            return
        self._work = None
        self._outbound.send(answer)
        session = self._session
        session.pump()
        if session.congested and not session.overrun:
            self._holding.wait_for((session,))
        self._resume()

    def _add_filters(self, packet: Subscribe) -> Generator[None, None, Suback]:
        """Subscribe to each filter; pause when the turn has no more time."""
        session, state = self._session, self._state
        replay = Replay(state.exchange.retained, session.has)
        is_queued = False
        reasons = []
        identifier = (*packet.properties.subscription_identifiers, 0)[0]
        for request in packet.filters:
            while not state.turn.has_time():
                if is_queued:
                    session.replay_grew(replay)
                else:  # now, so that later messages do not overtake it
                    session.replay(replay)
                    is_queued = True
                yield
            reason = state.policy.subscribe(session.client_id, request.filter)
            if not reason.failed:
                reason = state.exchange.subscribe(session, request, identifier, replay)
            reasons.append(reason)
        replay.complete = True
        if is_queued:
            session.replay_grew(replay)
        elif replay.size:
            session.replay(replay)
        return Suback(packet.packet_id, tuple(reasons))

    def _remove_filters(self, packet: Unsubscribe) -> Generator[None, None, Unsuback]:
        """Unsubscribe from each filter; pause when the turn has no more time."""
        reasons = []
        for name in packet.filters:
            while not self._state.turn.has_time():
                yield
            reasons.append(self._state.exchange.unsubscribe(self._session, name))
        return Unsuback(packet.packet_id, tuple(reasons))


def _of_bridge(request: MqttSubscription) -> MqttSubscription:
    is_shared = request.filter.startswith("$share/")
    return request._replace(no_local=not is_shared, retain_as_published=True)
