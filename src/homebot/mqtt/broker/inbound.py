"""The messages one client publishes: topic aliases, packet ids, and the answers. No I/O."""

from __future__ import annotations

from dataclasses import replace
from typing import final

from homebot.mqtt.broker.exchange import Receipt
from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.outbound import Outbound
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.packets import (
    NO_PROPERTIES,
    PacketError,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    ReasonCode,
)

__all__ = ["Inbound"]

_REFUSED = Receipt(ReasonCode.NOT_AUTHORIZED)


@final
class Inbound:
    """The reading half of one connection, as far as messages go.

    Attributes:
        gone: The client has left: a message without room is not answered, so that it is sent again.
        refusable: The client can be sent the reason why a message was not taken; from MQTT 5 on.
    """

    def __init__(self, state: BrokerState, session: BrokerSession, outbound: Outbound) -> None:
        self._state = state
        self._session = session
        self._outbound = outbound
        self._aliases: dict[int, str] = {}
        self._alias_text = 0
        self._open: set[int] = set()  # QoS 2 ids taken on this connection and not released
        self._is_v5 = self.refusable = outbound.version is ProtocolVersion.V5
        self.gone = False
        self._max_levels = state.limits.max_topic_levels

    def check_quota(self, packet: Publish, waiting: int) -> None:
        """Make sure that an MQTT 5 client keeps to the broker's Receive Maximum.

        Args:
            waiting: How many QoS 1 and 2 messages of the client the broker has not looked at yet.

        Raises:
            PacketError: 0x93.
        """
        if not self._is_v5 or not packet.qos:
            return
        if waiting + len(self._open) >= self._state.limits.receive_maximum:
            if packet.packet_id in self._open:
                return
            raise PacketError(
                f"more than {self._state.limits.receive_maximum} unacknowledged messages",
                code=ReasonCode.RECEIVE_MAXIMUM_EXCEEDED,
            )

    def must_wait_for(self, packet: Publish) -> tuple[BrokerSession, ...]:
        """Return the sessions that need room before *packet* can be taken; none where the client can be refused it.

        Raises:
            PacketError: The client must not have sent this.
        """
        if not packet.qos:
            return ()
        full = self._state.exchange.without_room(self._resolve(packet))
        return tuple(session for session in full if not (self.refusable and session.overrun))

    def publish(self, packet: Publish) -> tuple[BrokerSession, ...]:
        """Take a PUBLISH, answer it, and return the sessions that are now too slow for more.

        Raises:
            PacketError: The client must not have sent this.
        """
        self._state.counters.messages_received += 1
        qos = packet.qos
        if qos == 2:
            return self._publish_qos2(packet)
        receipt = self._forward(packet)
        if qos and not (self.gone and receipt.reason is ReasonCode.QUOTA_EXCEEDED):
            packet_id = packet.packet_id or 0
            if self._is_v5 and receipt.reason:
                self._outbound.send(Puback(packet_id, receipt.reason))
            else:
                self._outbound.link.write(b"\x40\x02" + packet_id.to_bytes(2, "big"))
        return receipt.slow

    def release(self, packet: Pubrel) -> None:
        """Take a PUBREL and answer it."""
        known = packet.packet_id in self._session.received
        self._session.received.discard(packet.packet_id)
        self._open.discard(packet.packet_id)
        reason = ReasonCode.SUCCESS if known else ReasonCode.PACKET_IDENTIFIER_NOT_FOUND
        self._outbound.send(Pubcomp(packet.packet_id, reason))

    def _publish_qos2(self, packet: Publish) -> tuple[BrokerSession, ...]:
        packet_id = packet.packet_id or 0
        session = self._session
        if packet_id in session.received:  # sent again: it was forwarded the first time
            self._resolve(packet)
            self._open.add(packet_id)
            self._outbound.send(Pubrec(packet_id))
            return ()
        receipt = self._forward(packet)
        if self.gone and receipt.reason is ReasonCode.QUOTA_EXCEEDED:
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
        """Return the topic a PUBLISH means, noting a topic alias."""
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
