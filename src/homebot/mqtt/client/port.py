"""The port of MQTT clients, independent of the library."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.message import NO_PROPERTIES, MessageProperties, MqttMessage

__all__ = ["MqttClient", "MqttCounters", "MqttSubscription", "PublishResult", "SessionGrant"]


class MqttSubscription(NamedTuple):
    """One topic filter and how its messages should come.

    Attributes:
        filter: Topic filter; ``+`` is one level, a final ``#`` is the rest.
        qos: Highest delivery level wanted, 0 to 2.
        no_local: Exclude this client's own publications. MQTT 5; ignored by 3.1.1.
        retain_as_published: Keep the sender's retain flag on live messages. MQTT 5; ignored by 3.1.1.
        retain_handling: Stored messages come 0: always, 1: only with a new subscription, 2: never.
            MQTT 5; ignored by 3.1.1, which always sends them.

    Source: MQTT Version 5.0, section 3.8.3.1.
    """

    filter: str
    qos: int = 0
    no_local: bool = False
    retain_as_published: bool = False
    retain_handling: Literal[0, 1, 2] = 0


class SessionGrant(NamedTuple):
    """The session as the broker granted it when the link was made.

    Attributes:
        resumed: The broker still knew this client: its subscriptions stand, and unacknowledged messages follow.
        receive_maximum: Most publishes of QoS 1 and 2 that the broker wants to have open.
        maximum_packet_size: Largest packet that the broker takes, in bytes; None is without limit.
    """

    resumed: bool
    protocol: Literal["5", "3.1.1"]
    maximum_qos: int = 2
    retain_available: bool = True
    receive_maximum: int = 65535
    maximum_packet_size: int | None = None


class PublishResult(NamedTuple):
    """The broker has taken the message.

    Attributes:
        reason: MQTT 5 reason code below 0x80: 0 is success, 0x10 means no subscribers.
            Always 0 for QoS 0 and MQTT 3.1.1.
    """

    reason: int = 0


@dataclass(slots=True)
class MqttCounters:
    """Counters over all links of one client since it was made.

    Attributes:
        dropped_overflow: Messages of QoS 0 dropped because the inbox was full.
        dropped_oversize: Packets dropped because they were larger than the limit.
    """

    received: int = 0
    dropped_overflow: int = 0
    dropped_oversize: int = 0
    dropped_malformed: int = 0


class MqttClient(Protocol):
    """One client of one broker; its link can be made, lost and made again.

    Delivery: messages come in the broker's order. Those of QoS 1 and 2 stay the broker's until they are
    acknowledged; without that they come again on the next link of a resumed session. Those of QoS 1 may therefore come
    twice. Those of QoS 0 are dropped, oldest first and counted, when the inbox is full.

    One task reads (`receive`); any number publish. Errors of the link do not name the broker: the caller does.
    """

    @property
    def counters(self) -> MqttCounters:
        """Counters of the events so far."""
        ...

    @property
    def limits(self) -> tuple[str, ...]:
        """Promises of this port that the client does not keep, each in words for people; empty where it keeps all."""
        ...

    def connected(self) -> AbstractAsyncContextManager[SessionGrant]:
        """Make the link; leaving the block says good-bye and drops it. Can be used again afterwards.

        Raises:
            LinkError: The broker cannot be reached, is busy, or did not answer.
            RefusedError: The broker said no: login, client id, protocol, or its certificate is not trusted.
            UsageError: A certificate or key file cannot be used.
        """
        ...

    async def wait_lost(self) -> LinkError | RefusedError:
        """Wait until the link is gone and say why; RefusedError where the broker threw this client out."""
        ...

    def drop(self) -> None:
        """Cut the link without a word, as a power failure does: the broker publishes the will. Without one nothing."""
        ...

    async def publish(
        self,
        topic: str,
        payload: bytes = b"",
        *,
        qos: int = 0,
        retain: bool = False,
        properties: MessageProperties = NO_PROPERTIES,
    ) -> PublishResult:
        """Publish, and return when the broker has taken it (QoS 0: when it is on the wire).

        A publish whose link drops is not repeated on the next link, except that a QoS 2 handshake that a resumed
        session still holds open is brought to its end, as exactly-once demands.

        Raises:
            UsageError: The topic cannot be published to.
            RefusedError: The broker answered with a reason of 0x80 or more, or cannot take such a message.
            LinkError: There is no link, it dropped before the answer (at once, not after the time limit; whether
                the broker took the message is then unknown), or the answer is overdue.
        """
        ...

    async def subscribe(self, *subscriptions: MqttSubscription) -> tuple[int, ...]:
        """Subscribe to all of them with one request.

        Returns:
            The granted QoS, one for each subscription, in order.

        Raises:
            UsageError: A filter is not a topic filter.
            RefusedError: At least one was refused; the text names them. The others stand.
            LinkError: As for `publish`.
        """
        ...

    async def unsubscribe(self, *filters: str) -> None:
        """Take back subscriptions; a filter that was never subscribed to is no error.

        Raises:
            LinkError: As for `publish`.
        """
        ...

    async def receive(self) -> list[MqttMessage]:
        """Return all messages that are there, in order; wait for the first.

        Raises:
            LinkError: There is no link and no message.
        """
        ...

    def ack(self, messages: Iterable[MqttMessage]) -> None:
        """Acknowledge these messages to the broker; those of QoS 0 are passed over.

        A message from an earlier link is passed over too: the broker sends it again if it still has it.
        """
        ...
