"""The half of an MQTT client that does not depend on how a link speaks: checks, versions, the inbox, and the close."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Iterable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import replace
from typing import Final, Protocol

import anyio

from homebot.clock import Clock, LoopClock
from homebot.errors import HomebotError, LinkError, RefusedError, UsageError
from homebot.logger import get_logger
from homebot.mqtt.client.port import MqttCounters, MqttSubscription, PublishResult, SessionGrant
from homebot.mqtt.client.receiver import Receiver
from homebot.mqtt.client.refusals import reason_text
from homebot.mqtt.client.version_choice import MqttVersion, VersionChoice
from homebot.mqtt.message import NO_PROPERTIES, MessageProperties, MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import ReasonCode
from homebot.mqtt.topics import validate_filter, validate_topic

__all__ = ["BaseClient", "ClientLink", "check_granted"]

_GOODBYE: Final = 1.0
"""Seconds that a close in good order may take; the broker may be gone already."""

_FAILED: Final = ReasonCode.UNSPECIFIED_ERROR  # reason codes from here on say no
_OVERHEAD: Final = 12  # bytes of a PUBLISH besides topic, properties and payload, at most
_log = get_logger()


class ClientLink(Protocol):
    """One link from its login to its end."""

    @property
    def grant(self) -> SessionGrant:
        """The session as the broker granted it."""
        ...

    @property
    def is_alive(self) -> bool:
        """True if the link stands."""
        ...

    async def wait_lost(self) -> LinkError | RefusedError:
        """Wait for the end and say why."""
        ...

    async def publish(
        self, topic: str, payload: bytes, qos: int, properties: MessageProperties, *, retain: bool
    ) -> int:
        """Publish, and return the reason code of the answer."""
        ...

    async def subscribe(self, subscriptions: tuple[MqttSubscription, ...]) -> tuple[int, ...]:
        """Subscribe, and return the reason codes of the answer."""
        ...

    async def unsubscribe(self, filters: tuple[str, ...]) -> None:
        """Take back subscriptions."""
        ...

    def ack(self, messages: Iterable[MqttMessage]) -> None:
        """Acknowledge those of *messages* that came by this link."""
        ...

    async def close(self, *, ends_session: bool) -> None:
        """Say good-bye and wait until the link is closed; *ends_session* where the version has a word for it."""
        ...

    def cut(self, reason: LinkError | RefusedError) -> None:
        """End the link without a word because of *reason*; nothing where it has ended."""
        ...


class BaseClient(ABC):
    """The `MqttClient` port over links of some kind.

    Args:
        options: Broker, login and limits.
        clock: Paces log lines.

    Attributes:
        receive: Returns all messages that are there; see `MqttClient.receive`.
    """

    def __init__(self, options: MqttOptions, clock: Clock | None) -> None:
        self._options = options
        self._clock = LoopClock() if clock is None else clock
        self._receiver = Receiver(options, self._clock)
        self.receive = self._receiver.take
        self._choice = VersionChoice(options)
        self._link: ClientLink | None = None
        self._is_taken = False

    @property
    def counters(self) -> MqttCounters:
        """Counters of the events so far."""
        return self._receiver.counters

    @property
    def limits(self) -> tuple[str, ...]:
        """Promises of the port that it does not keep; see `MqttClient.limits`."""
        return ()

    def connected(self) -> AbstractAsyncContextManager[SessionGrant]:
        """Make the link; see `MqttClient.connected`."""
        return self._connected()

    async def wait_lost(self) -> LinkError | RefusedError:
        """Wait until the link is gone and say why."""
        return await self._need_link().wait_lost()

    async def publish(
        self,
        topic: str,
        payload: bytes = b"",
        *,
        qos: int = 0,
        retain: bool = False,
        properties: MessageProperties = NO_PROPERTIES,
    ) -> PublishResult:
        """Publish; see `MqttClient.publish`."""
        validate_topic(topic)
        if qos not in {0, 1, 2}:
            raise UsageError(f"QoS is 0, 1 or 2, not {qos}")
        link = self._link or self._need_link()
        reason = await link.publish(topic, payload, qos, properties, retain=retain)
        if reason >= _FAILED:
            raise RefusedError(f"the publish to {topic!r}", reason_text(reason), reason)
        return PublishResult(reason) if reason else _TAKEN

    async def subscribe(self, *subscriptions: MqttSubscription) -> tuple[int, ...]:
        """Subscribe; see `MqttClient.subscribe`."""
        for subscription in subscriptions:
            validate_filter(subscription.filter)
        if not subscriptions:
            return ()
        reasons = await self._need_link().subscribe(subscriptions)
        refused = [(each.filter, code) for each, code in zip(subscriptions, reasons, strict=False) if code >= _FAILED]
        if refused:
            names = ", ".join(repr(name) for name, _ in refused)
            raise RefusedError(f"the subscription to {names}", reason_text(refused[0][1]), refused[0][1])
        return reasons

    async def unsubscribe(self, *filters: str) -> None:
        """Take back subscriptions; see `MqttClient.unsubscribe`."""
        if filters:
            await self._need_link().unsubscribe(filters)

    def ack(self, messages: Iterable[MqttMessage]) -> None:
        """Acknowledge; see `MqttClient.ack`."""
        if self._link is not None:
            self._link.ack(messages)

    def drop(self) -> None:
        """Cut the link; see `MqttClient.drop`."""
        if self._link is not None:
            self._link.cut(LinkError("dropped"))

    @abstractmethod
    async def _open(self, options: MqttOptions, version: MqttVersion, receiver: Receiver) -> ClientLink:
        """Make a link.

        Raises:
            LinkError: The broker cannot be reached, is busy, or did not answer.
            RefusedError: The broker said no, or its certificate is not trusted.
            UsageError: A certificate or key file cannot be used.
        """

    @asynccontextmanager
    async def _connected(self) -> AsyncIterator[SessionGrant]:
        if self._is_taken:
            raise UsageError("this MQTT client is connected already")
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
        """End it as MQTT 3.1.1 has it: connect once more, with a clean session, and leave.

        Source: MQTT Version 3.1.1, section 3.1.2.4.
        """
        options = replace(self._options, session_expiry=0, will=None)
        try:
            link = await self._open(options, "3.1.1", Receiver(options, self._clock))
        except HomebotError as error:  # the broker is gone, and with it most likely the session
            _log.debug("mqtt.session_left", broker=options.url, reason=str(error))
            return
        await link.close(ends_session=False)

    def _need_link(self) -> ClientLink:
        if self._link is None:
            raise LinkError(f"not connected to {self._options.url}")
        return self._link


def check_granted(session: SessionGrant, topic: str, size: int, qos: int, *, retain: bool) -> None:
    """Refuse a publish that the broker would answer by closing the link.

    Args:
        session: What the broker granted.
        topic: Where to.
        size: Bytes of payload and properties.
        qos: 0, 1 or 2.
        retain: Whether the broker is to store it.

    Raises:
        RefusedError: The broker does not take such messages.
    """
    limit = session.maximum_packet_size
    if qos > session.maximum_qos:
        code = ReasonCode.QOS_NOT_SUPPORTED
    elif retain and not session.retain_available:
        code = ReasonCode.RETAIN_NOT_SUPPORTED
    elif limit is not None and len(topic.encode()) + size + _OVERHEAD > limit:
        code = ReasonCode.PACKET_TOO_LARGE
    else:
        return
    raise RefusedError(f"the publish to {topic!r}", reason_text(code), code)


_TAKEN: Final = PublishResult()
