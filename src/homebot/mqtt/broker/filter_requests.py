"""SUBSCRIBE and UNSUBSCRIBE, taken a few filters at a time. No I/O."""

from __future__ import annotations

from typing import Final, final

from homebot.mqtt.broker.hub import Hub
from homebot.mqtt.broker.replay import Replay
from homebot.mqtt.broker.retained import RetainedMessages
from homebot.mqtt.broker.session import Session
from homebot.mqtt.packets import ReasonCode, Suback, Subscribe, Unsuback, Unsubscribe

__all__ = ["Subscribing", "Unsubscribing"]

_COST: Final = 8  # units of work for a filter, and one for each level


@final
class Subscribing:
    """A SUBSCRIBE under way.

    Args:
        session: Whose.
        packet: What was asked for.
        retained: The retained messages, of which the client is owed some.
    """

    def __init__(self, session: Session, packet: Subscribe, retained: RetainedMessages) -> None:
        self._session = session
        self._packet = packet
        self._replay = Replay(retained, session.has)
        self._is_queued = False
        self._reasons: list[ReasonCode] = []

    def go_on(self, hub: Hub) -> Suback | None:
        """Take as many filters as may be taken now; the answer, or None where some are left."""
        session, requests, reasons = self._session, self._packet.filters, self._reasons
        identifier = (*self._packet.properties.subscription_identifiers, 0)[0]
        while len(reasons) < len(requests):
            if not hub.work.left:
                self._queue()  # now, so that nothing that comes meanwhile overtakes it
                return None
            request = requests[len(reasons)]
            reason = hub.policy.subscribe(session.client_id, request.filter)
            if not reason.failed:
                reason = hub.exchange.subscribe(session, request, identifier, self._replay)
            reasons.append(reason)
            hub.work.spend(_COST + request.filter.count("/"))
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
class Unsubscribing:
    """An UNSUBSCRIBE under way.

    Args:
        session: Whose.
        packet: What was asked for.
    """

    def __init__(self, session: Session, packet: Unsubscribe) -> None:
        self._session = session
        self._packet = packet
        self._reasons: list[ReasonCode] = []

    def go_on(self, hub: Hub) -> Unsuback | None:
        """Take as many filters as may be taken now; the answer, or None where some are left."""
        names, reasons = self._packet.filters, self._reasons
        while len(reasons) < len(names):
            if not hub.work.left:
                return None
            name = names[len(reasons)]
            reasons.append(hub.exchange.unsubscribe(self._session, name))
            hub.work.spend(_COST + name.count("/"))
        return Unsuback(self._packet.packet_id, tuple(reasons))
