"""The packets of one logged-in client: its messages, with their aliases and answers. No I/O.

Packets are handled in order. While a publisher is held back for a slow subscriber, its acknowledgements and pings are
still handled; everything else waits in order.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final, final

from homebot.mqtt.broker.backpressure import Backpressure
from homebot.mqtt.broker.exchange import Receipt
from homebot.mqtt.broker.filter_requests import FilterRequests
from homebot.mqtt.broker.login import expiry_of
from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.packets import (
    NO_PROPERTIES,
    Auth,
    Disconnect,
    Packet,
    PacketError,
    PacketReader,
    Pingreq,
    Pingresp,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    ReasonCode,
    Subscribe,
    Unsubscribe,
)

_REFUSED: Final = Receipt(ReasonCode.NOT_AUTHORIZED)
_UNCHECKED: Final = 8  # packets handled before the clock is read


@final
class ClientPackets:
    """The handler of a client's packets.

    Args:
        on_disconnect: Called when the client disconnects, with whether to publish its will; it calls
            :meth:`stop`.
        on_failure: Called with the error of a packet that had to wait.
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
        self._aliases: dict[int, str] = {}
        self._alias_text = 0
        self._open: set[int] = set()  # QoS 2 ids received on this connection and not released
        self._is_v5 = outbound.version is ProtocolVersion.V5
        self._max_levels = state.limits.max_topic_levels
        self._holding = Backpressure(state, outbound.link, self._go_on)
        self._filters = FilterRequests(state, session, outbound, self._holding, self._resume, is_bridge=is_bridge)

    @property
    def reading(self) -> bool:
        """True if the client's socket is read."""
        return self._holding.reading

    def handle_all(self, reader: PacketReader) -> bool:
        """Handle the complete packets; consecutive PUBACKs share one call of ``pump``.

        Returns:
            False if this turn had no time for all of them.

        Raises:
            PacketError: The client must not have sent this.
        """
        pop, acknowledged = reader.pop, self._session.in_flight.acknowledged
        has_time = self._state.turn.has_time
        freed, unchecked = False, _UNCHECKED
        while (packet := pop()) is not None:
            if type(packet) is Puback:  # there is one for each message sent, and it never waits
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
                self._check_quota(packet)
            self._holding.push(packet)
        else:
            self._act(packet)

    def stop(self) -> None:
        """End with the connection, leaving the messages held back to :meth:`forward_held`."""
        self._stopped = True
        self._holding.stop()
        self._holding.paused = False
        self._state.turn.forget(self._go_on)
        self._filters.stop()

    def forward_held(self) -> Iterator[None]:
        """Forward the messages held back, one in each step, as far as there is room.

        Their publisher has left and can no longer wait.

        Raises:
            PacketError: The client must not have sent one of them.
        """
        while (packet := self._holding.pop()) is not None:
            yield
            if isinstance(packet, Publish):
                self._publish(packet)

    def _act(self, packet: Packet) -> None:
        if type(packet) is Publish:
            if packet.qos:
                self._check_quota(packet)
            if self._state.exchange.crowded and self._wait_for_room(packet):
                return
            slow = self._publish(packet)
            if slow:
                self._holding.wait_for(slow)
        else:
            self._act_on_rare(packet)

    def _act_on_rare(self, packet: Packet) -> None:
        match packet:
            case Pubrel():
                self._release(packet)
            case Pubrec():
                reason = self._session.taken(packet.packet_id, packet.reason)
                if not packet.reason.failed:
                    self._outbound.send(Pubrel(packet.packet_id, reason))
            case Pubcomp():
                self._session.completed(packet.packet_id)
            case Pingreq():
                self._outbound.send(Pingresp())
            case Subscribe():
                self._filters.subscribe(packet)
            case Unsubscribe():
                self._filters.unsubscribe(packet)
            case Disconnect():
                seconds = packet.properties.session_expiry_interval
                if seconds is not None:
                    if seconds and not self._session.expiry:
                        raise _protocol_error("a session that ends with its connection cannot be extended")
                    self._session.expiry = expiry_of(seconds)
                self._on_disconnect(packet.reason is not ReasonCode.SUCCESS)
            case Auth():
                raise PacketError("extended authentication is not supported", code=ReasonCode.BAD_AUTHENTICATION_METHOD)
            case _:
                raise _protocol_error(f"a client must not send {type(packet).__name__}")

    def _wait_for_room(self, packet: Publish) -> bool:
        """Return whether *packet* must wait for a full queue; before MQTT 5 it cannot be refused."""
        full = self._state.exchange.without_room(self._resolve(packet)) if packet.qos else ()
        slow = tuple(session for session in full if not (self._is_v5 and session.overrun))
        if slow:
            self._holding.push_front(packet)
            self._holding.wait_for(slow, endless=not self._is_v5)
        return bool(slow)

    def _check_quota(self, packet: Publish) -> None:
        """Check that an MQTT 5 client respects the broker's Receive Maximum, waiting messages included."""
        if not self._is_v5 or not packet.qos:
            return
        if self._holding.messages + len(self._open) >= self._state.limits.receive_maximum:
            if packet.packet_id in self._open:
                return
            raise PacketError(
                f"more than {self._state.limits.receive_maximum} unacknowledged messages",
                code=ReasonCode.RECEIVE_MAXIMUM_EXCEEDED,
            )

    def _publish(self, packet: Publish) -> tuple[BrokerSession, ...]:
        """Handle and answer a PUBLISH; return the sessions that are now too slow for more."""
        self._state.counters.messages_received += 1
        qos = packet.qos
        if qos == 2:
            return self._publish_qos2(packet)
        receipt = self._forward(packet)
        if qos and not (self._stopped and receipt.reason is ReasonCode.QUOTA_EXCEEDED):
            packet_id = packet.packet_id or 0
            if self._is_v5 and receipt.reason:
                self._outbound.send(Puback(packet_id, receipt.reason))
            else:
                self._outbound.link.write(b"\x40\x02" + packet_id.to_bytes(2, "big"))
        return receipt.slow

    def _release(self, packet: Pubrel) -> None:
        known = packet.packet_id in self._session.received
        self._session.received.discard(packet.packet_id)
        self._open.discard(packet.packet_id)
        reason = ReasonCode.SUCCESS if known else ReasonCode.PACKET_IDENTIFIER_NOT_FOUND
        self._outbound.send(Pubcomp(packet.packet_id, reason))

    def _publish_qos2(self, packet: Publish) -> tuple[BrokerSession, ...]:
        packet_id = packet.packet_id or 0
        session = self._session
        if packet_id in session.received:  # a repetition: it was forwarded the first time
            self._resolve(packet)
            self._open.add(packet_id)
            self._outbound.send(Pubrec(packet_id))
            return ()
        receipt = self._forward(packet)
        if self._stopped and receipt.reason is ReasonCode.QUOTA_EXCEEDED:
            return ()
        if not receipt.reason.failed or not self._is_v5:
            session.received.add(packet_id)
            self._open.add(packet_id)
        self._outbound.send(Pubrec(packet_id, receipt.reason))
        return receipt.slow

    def _forward(self, packet: Publish) -> Receipt:
        topic, payload, qos, retain, _, _, properties = packet
        state = self._state
        expires_at = None
        if properties is not NO_PROPERTIES:
            topic = self._resolve(packet)
            if properties.topic_alias is not None:
                properties = replace(properties, topic_alias=None)
            if properties.message_expiry_interval is not None:
                expires_at = state.clock.monotonic() + properties.message_expiry_interval
        if topic.count("/") >= self._max_levels:
            raise PacketError("the topic has too many levels", code=ReasonCode.TOPIC_NAME_INVALID)
        verdict = state.policy.publish(self._session.client_id, topic)
        if verdict:
            state.counters.dropped_refused += 1
            return _REFUSED if verdict is ReasonCode.NOT_AUTHORIZED else Receipt(verdict)
        return state.exchange.publish(
            BrokerMessage(topic, payload, qos, retain, properties, self._session.client_id, expires_at)
        )

    def _resolve(self, packet: Publish) -> str:
        """Return the topic of a PUBLISH, and record its topic alias."""
        properties = packet.properties
        if properties.subscription_identifiers:
            raise PacketError("a client must not send a subscription identifier", code=ReasonCode.PROTOCOL_ERROR)
        alias = properties.topic_alias
        if alias is None:
            return packet.topic
        if alias > self._state.limits.topic_alias_maximum:
            raise PacketError(f"topic alias {alias} is too high", code=ReasonCode.TOPIC_ALIAS_INVALID)
        if packet.topic:
            self._alias_text += len(packet.topic) - len(self._aliases.get(alias, ""))
            if self._alias_text > self._state.limits.max_alias_text:
                raise PacketError("the topics of its aliases are too long", code=ReasonCode.QUOTA_EXCEEDED)
            self._aliases[alias] = packet.topic
        elif alias not in self._aliases:
            raise PacketError(f"topic alias {alias} was not set", code=ReasonCode.PROTOCOL_ERROR)
        return self._aliases[alias]

    def _resume(self) -> None:
        """Handle the packets that waited behind a long one."""
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
