"""The packets of one client that has logged in, without a socket.

Order: packets are handled one after the other as they come. While a publisher is held back for a slow subscriber,
its acknowledgements and pings are still handled, everything else waits in its order.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, final

from homebot.mqtt.broker.backpressure import Backpressure
from homebot.mqtt.broker.filter_requests import FilterRequests
from homebot.mqtt.broker.inbound import Inbound
from homebot.mqtt.broker.login import expiry_of
from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.packets import (
    Auth,
    Disconnect,
    Packet,
    PacketError,
    PacketReader,
    Pingreq,
    Pingresp,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    ReasonCode,
    Subscribe,
    Unsubscribe,
)

__all__ = ["ClientPackets"]

_UNCHECKED: Final = 8  # packets that are handled before the clock is read


@final
class ClientPackets:
    """Carries out each packet.

    Args:
        on_disconnect: Called when the client takes its leave, with whether its will is to be published; it calls
            :meth:`stop`.
        on_failure: Called with the fault of a packet that had to wait.
    """

    def __init__(
        self,
        state: BrokerState,
        session: BrokerSession,
        outbound: Outbound,
        on_disconnect: Callable[[bool], None],
        on_failure: Callable[[PacketError], None],
        *,
        is_bridge: bool = False,
    ) -> None:
        self._state = state
        self._session = session
        self._outbound = outbound
        self._on_disconnect = on_disconnect
        self._on_failure = on_failure
        self._stopped = False
        self._inbound = Inbound(state, session, outbound)
        self._holding = Backpressure(state, outbound.link, self._go_on)
        self._filters = FilterRequests(state, session, outbound, self._holding, self._resume, is_bridge=is_bridge)

    @property
    def reading(self) -> bool:
        """True if the client's socket is read."""
        return self._holding.reading

    def handle_all(self, reader: PacketReader) -> bool:
        """Handle the packets that are complete; one call of ``pump`` is for all PUBACK that follow each other.

        Returns:
            False if there was no time for all of them in this turn.

        Raises:
            PacketError: The client must not have sent this.
        """
        pop, acknowledged = reader.pop, self._session.in_flight.acknowledged
        has_time = self._state.turn.has_time
        freed, unchecked = False, _UNCHECKED
        while (packet := pop()) is not None:
            if type(packet) is Puback:  # comes once for each message sent, and never waits
                acknowledged(packet[0])
                freed = True
                continue
            if freed:
                self._session.pump()
                freed = False
            self.handle(packet)
            if self._stopped:
                return True
            unchecked -= 1
            if not unchecked:
                if not has_time():
                    break
                unchecked = _UNCHECKED
        if freed:
            self._session.pump()
        return packet is None

    def handle(self, packet: Packet) -> None:
        """Handle one packet.

        Raises:
            PacketError: The client must not have sent it.
        """
        if type(packet) is Puback:
            self._session.in_flight.acknowledged(packet.packet_id)
            self._session.pump()
        elif self._holding.active and not isinstance(packet, _NEVER_HELD):
            if isinstance(packet, Publish):
                self._inbound.check_quota(packet, self._holding.messages)
            self._holding.push(packet)
        else:
            self._act(packet)

    def stop(self) -> PacketError | None:
        """End with the connection: forward the messages that were held back, as far as there is room.

        The publisher cannot wait any more.

        Returns:
            The fault of one of them, or None.
        """
        self._stopped = True
        self._holding.stop()
        self._holding.paused = False
        self._state.turn.forget(self._go_on)
        self._filters.stop()
        self._inbound.gone = True
        try:
            while (packet := self._holding.pop()) is not None:
                if isinstance(packet, Publish):
                    self._inbound.publish(packet)
        except PacketError as error:
            return error
        finally:
            self._holding.packets.clear()
        return None

    def _act(self, packet: Packet) -> None:
        if type(packet) is Publish:
            if packet.qos:
                self._inbound.check_quota(packet, self._holding.messages)
            if self._state.exchange.crowded and self._wait_for_room(packet):
                return
            slow = self._inbound.publish(packet)
            if slow:
                self._holding.wait_for(slow)
        else:
            self._act_on_rare(packet)

    def _act_on_rare(self, packet: Packet) -> None:
        match packet:
            case Pubrel():
                self._inbound.release(packet)
            case Pubrec():
                self._taken(packet)
            case Pubcomp():
                self._session.completed(packet.packet_id)
            case Pingreq():
                self._outbound.send(Pingresp())
            case Subscribe():
                self._filters.subscribe(packet)
            case Unsubscribe():
                self._filters.unsubscribe(packet)
            case Disconnect():
                self._disconnect(packet)
            case Auth():
                raise PacketError("extended authentication is not supported", code=ReasonCode.BAD_AUTHENTICATION_METHOD)
            case _:
                raise _protocol_error(f"a client must not send {type(packet).__name__}")

    def _wait_for_room(self, packet: Publish) -> bool:
        """Return whether *packet* has to wait because a queue is full."""
        full = self._inbound.must_wait_for(packet)
        if full:
            self._holding.push_front(packet)
            self._holding.wait_for(full, endless=not self._inbound.refusable)
        return bool(full)

    def _taken(self, packet: Pubrec) -> None:
        reason = self._session.taken(packet.packet_id, packet.reason)
        if not packet.reason.failed:
            self._outbound.send(Pubrel(packet.packet_id, reason))

    def _disconnect(self, packet: Disconnect) -> None:
        seconds = packet.properties.session_expiry_interval
        if seconds is not None:
            if seconds and not self._session.expiry:
                raise _protocol_error("a session that ends with its connection cannot be extended")
            self._session.expiry = expiry_of(seconds)
        self._on_disconnect(packet.reason is not ReasonCode.SUCCESS)

    def _resume(self) -> None:
        """Handle the packets that waited behind one that took long."""
        if self._holding.paused and not self._filters.active:
            self._holding.paused = False
            self._go_on()

    def _go_on(self) -> None:
        try:
            while not self._stopped and self._holding.packets:
                if not self._state.turn.has_time():
                    self._state.turn.defer(self._go_on)
                    return
                packet = self._holding.pop()
                if packet is None:
                    return
                self._act(packet)
        except PacketError as error:
            self._on_failure(error)


_NEVER_HELD = (Pubrec, Pubrel, Pubcomp, Pingreq)


def _protocol_error(problem: str) -> PacketError:
    return PacketError(problem, code=ReasonCode.PROTOCOL_ERROR)
