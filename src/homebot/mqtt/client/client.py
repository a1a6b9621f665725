"""The MQTT client, independent of the library: its contract, and the common part of implementations."""

from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import Final

import anyio
from anyio.lowlevel import checkpoint

from homebot.clock import Clock, LoopClock
from homebot.errors import HomebotError, LinkError, RefusedError, UsageError
from homebot.mqtt.client.link import ClientLink
from homebot.mqtt.client.login import MqttVersion, SessionGrant, VersionChoice, reason_text
from homebot.mqtt.client.receiver import MqttCounters, Receiver
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import NO_PROPERTIES, MqttSubscription, Properties, ReasonCode
from homebot.mqtt.topics import validate_filter, validate_topic
from homebot.support.logger import get_logger

_GOODBYE: Final = 1.0
"""Seconds that a clean close may take, as the broker may be gone already."""

_FAILED: Final = ReasonCode.UNSPECIFIED_ERROR  # reason codes from here on are refusals
_log = get_logger()


class MqttClient(ABC):
    """A client of one broker, with a link that can be made repeatedly. Create it inside a running event loop.

    Messages arrive in the broker's order. Those of QoS 1 and 2 that are not acknowledged are sent again on the next
    link of a resumed session, so that those of QoS 1 may arrive twice. When the inbox is full, the oldest ones of QoS 0
    are dropped and counted.

    One task receives; any number may publish. Errors of the link do not name the broker: the caller does.

    Attributes:
        receive: Returns all received messages in order, and waits for the first; see `Inbox.receive`.
        ack: Acknowledges messages to the broker; see `Receiver.ack`.
    """

    def __init__(self, options: MqttOptions, clock: Clock | None = None) -> None:
        self._options = options
        self._clock = LoopClock() if clock is None else clock
        self._receiver = Receiver(options, self._clock)
        self.receive = self._receiver.receive
        self.ack: Callable[[Iterable[MqttMessage]], None] = self._receiver.ack
        self.counters: MqttCounters = self._receiver.counters
        self._choice = VersionChoice(options)
        self._link: ClientLink | None = None
        self._is_taken = False

    @asynccontextmanager
    async def connected(self) -> AsyncIterator[SessionGrant]:
        """Make the link; leaving the block disconnects. Can be used repeatedly.

        Raises:
            LinkError: The broker cannot be reached, is busy, or did not answer.
            RefusedError: The broker refused (login, client id, protocol), or its certificate is not trusted.
            UsageError: A certificate or key file cannot be used.
        """
        if self._is_taken:
            raise UsageError("this MQTT client is already connected")
        self._is_taken = True

        async def open_as(version: MqttVersion) -> ClientLink:
            return await self._open(self._options, version, self._receiver)

        try:
            self._link = link = await self._choice.open(open_as)
            try:
                yield link.grant
            finally:
                self._link = None
                await self._close(link)
        finally:
            self._is_taken = False

    async def wait_lost(self) -> LinkError | RefusedError:
        """Wait for the loss of the link and return its reason; RefusedError if the broker expelled this client."""
        return await self._need_link().wait_lost()

    def drop(self) -> None:
        """Cut the link without a DISCONNECT, as a power failure does, so that the broker publishes the will."""
        if self._link is not None:
            self._link.cut(LinkError("dropped"))

    async def publish(
        self,
        topic: str,
        payload: bytes = b"",
        *,
        qos: int = 0,
        retain: bool = False,
        properties: Properties = NO_PROPERTIES,
    ) -> int:
        """Publish, and return when the broker has accepted the message (QoS 0: when it is on the wire).

        A publish whose link is lost is not repeated on the next link, except that an open QoS 2 handshake of a resumed
        session is completed, as exactly-once delivery requires.

        Returns:
            The MQTT 5 reason code, below 0x80: 0x10 without subscribers. Always 0 for QoS 0 and MQTT 3.1.1.

        Raises:
            UsageError: The topic is invalid.
            RefusedError: The broker answered with a reason of 0x80 or more, or cannot take such a message.
            LinkError: There is no link, it was lost before the answer (reported at once; whether the broker has
                accepted the message is unknown), or the answer is overdue.
        """
        validate_topic(topic)
        if qos not in {0, 1, 2}:
            raise UsageError(f"QoS is 0, 1 or 2, not {qos}")
        try:
            reason = await (self._link or self._need_link()).publish(topic, payload, qos, properties, retain=retain)
        except LinkError:
            await checkpoint()  # a caller that retries in a loop would starve the reconnection
            raise
        if reason >= _FAILED:
            raise RefusedError(f"the publish to {topic!r}", reason_text(reason), reason)
        return reason

    async def subscribe(self, *subscriptions: MqttSubscription) -> tuple[int, ...]:
        """Subscribe with one request.

        Returns:
            The granted QoS, one for each subscription, in order.

        Raises:
            UsageError: A filter is not a topic filter.
            RefusedError: At least one was refused; the message names them. The others are valid.
            LinkError: As for `publish`.
        """
        for subscription in subscriptions:
            validate_filter(subscription.filter)
        if not subscriptions:
            return ()
        reasons = await (self._link or self._need_link()).subscribe(subscriptions)
        if max(reasons, default=0) >= _FAILED:
            answers = zip(subscriptions, reasons, strict=False)
            refused = [(subscription.filter, code) for subscription, code in answers if code >= _FAILED]
            names = ", ".join(repr(name) for name, _ in refused)
            raise RefusedError(f"the subscription to {names}", reason_text(refused[0][1]), refused[0][1])
        return reasons

    async def unsubscribe(self, *filters: str) -> None:
        """Unsubscribe; unknown filters are ignored.

        Raises:
            LinkError: As for `publish`.
        """
        if filters:
            await self._need_link().unsubscribe(filters)

    @abstractmethod
    async def _open(self, options: MqttOptions, version: MqttVersion, receiver: Receiver) -> ClientLink:
        """Make a link.

        Raises:
            LinkError: The broker cannot be reached, is busy, or did not answer.
            RefusedError: The broker refused, or its certificate is not trusted.
            UsageError: A certificate or key file cannot be used.
        """

    async def _close(self, link: ClientLink) -> None:
        options = self._options
        ends_session = link.is_alive and options.session_ends_on_close and options.session_expiry > 0
        with anyio.CancelScope(shield=True):
            with anyio.move_on_after(_GOODBYE):
                await link.close(ends_session=ends_session)
            link.cut(LinkError("closed"))
            if ends_session and link.grant.protocol == "3.1.1":
                with anyio.move_on_after(_GOODBYE):
                    await self._end_session()

    async def _end_session(self) -> None:
        """End the session as MQTT 3.1.1 requires: connect once more, with a clean session, and disconnect.

        Source: MQTT Version 3.1.1, section 3.1.2.4.
        """
        options = replace(self._options, session_expiry=0, will=None)
        try:
            link = await self._open(options, "3.1.1", Receiver(options, self._clock))
        except HomebotError as error:  # the broker is gone, most likely with the session
            _log.debug("mqtt.session_left", broker=options.url, reason=str(error))
            return
        await link.close(ends_session=False)

    def _need_link(self) -> ClientLink:
        if self._link is None:
            raise LinkError(f"not connected to {self._options.url}")
        return self._link
