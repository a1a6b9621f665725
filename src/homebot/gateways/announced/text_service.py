"""The raw side of a gateway: the topic ``out`` and the service ``subscribe_to_topic``, for texts and raw messages."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TypeAlias

from homebot.devices import RawCommand, RawMessage, SubscribeToTopic
from homebot.devices.names import read_text_address
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.errors import HomebotError, LinkError, RefusedError
from homebot.gateways.announced.command_server import CommandServer
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.announced.device_table import PublishedDeviceTable
from homebot.gateways.announced.last_messages import PartTexts, missed
from homebot.gateways.base import Gateway
from homebot.gateways.raw_delivery import RawDelivery, begin_of
from homebot.log import LogLimit

__all__ = ["FindSource", "SendRaw", "TextService"]

COMMAND_REFUSED = "gateway.command_refused"
COMMAND_FAILED = "gateway.command_failed"

SendRaw: TypeAlias = Callable[[RawCommand], Awaitable[None]]
"""Sends a raw command to the address that it names; raises :class:`RefusedError` or :class:`LinkError`."""

FindSource: TypeAlias = Callable[[str], tuple[str, str]]
"""Returns key and name of the device that reports raw messages on an address, known or not yet.

It raises :class:`RefusedError` where nobody may listen.
"""

_OUT_DEPTH = 1000


class TextService:
    """Delivers texts and raw messages of devices, and takes texts and raw commands for them.

    Args:
        gateway: The gateway.
        devices: Its devices.
        commands: Carries out what a text means.
        counters: Its counters.
        send_raw: Sends raw commands; None where the protocol has none.
        find_source: Says whose an address is before its device is known; see :data:`FindSource`.
        inboxes: Whether nodes get inboxes, rather than a topic for each device.
    """

    def __init__(
        self,
        gateway: Gateway,
        devices: PublishedDeviceTable,
        commands: CommandServer,
        counters: GatewayCounters,
        send_raw: SendRaw | None,
        find_source: FindSource | None,
        *,
        inboxes: bool,
    ) -> None:
        self._gateway = gateway
        self._devices = devices
        self._commands = commands
        self._counters = counters
        self._send_raw = send_raw
        self._find_source = find_source or _unknown
        self._clock = gateway.node.graph.clock
        self._listeners = RawDelivery(gateway.node, gateway.names, inboxes=inboxes)
        self._limit = LogLimit(self._clock)
        node, names = gateway.node, gateway.names
        node.create_subscription(RawCommand, names.out, self._send, _OUT_DEPTH, concurrent=True)
        node.create_service(SubscribeToTopic, names.subscribe, self._subscribe)
        node.create_task(self._listeners.watch_nodes)

    async def deliver(self, message: RawMessage) -> None:
        """Deliver *message* to who listens to its address."""
        await self._listeners.deliver(message, wait_if_full=True)

    async def _send(self, command: RawCommand) -> None:
        try:
            if (part := read_text_address(command.address)) is not None:
                await self._commands.tell(*part, command.payload)
            elif not self._gateway.acts:
                raise RefusedError("the command", self._gateway.observes_because)
            elif self._send_raw is None:
                raise RefusedError("the command", "this protocol takes no raw commands; use a text address")
            else:
                await self._send_raw(command)
            self._counters.commands += 1
        except LinkError as exc:
            self._counters.commands_failed += 1
            self._warn(COMMAND_FAILED, command.address, exc)
        except HomebotError as exc:
            self._counters.commands_refused += 1
            self._warn(COMMAND_REFUSED, command.address, exc)

    def _subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        try:
            key, name = self._source(request.topic)
            is_new = not self._listeners.has(request.topic, request.listener)
            publisher = self._listeners.add(request.topic, key, name, request.listener)
        except RefusedError as exc:
            return SubscribeToTopicResponse(success=False, message=exc.reason, data_topic="")
        except HomebotError as exc:
            return SubscribeToTopicResponse(success=False, message=str(exc), data_topic="")
        kept = self._missed(request.topic, begin_of(request.since, self._clock)) if is_new else ()
        return SubscribeToTopicResponse(success=True, message="", data_topic=publisher.topic_name, missed=kept)

    def _source(self, address: str) -> tuple[str, str]:
        """Return key and name of the device that reports on *address*.

        Whoever listened before the gateway was restarted asks again before its devices are found.
        """
        text = read_text_address(address)
        if text is None:
            return self._find_source(address)
        device = self._devices.get(text[0])
        return text[0], text[0] if device is None else device.device.name

    def _missed(self, address: str, since: float) -> tuple[RawMessage, ...]:
        if (text := read_text_address(address)) is not None:
            device = self._devices.get(text[0])
            texts = None if device is None else device.texts.get(text[1])
            return () if texts is None else self._last_of(texts, since)
        device = self._devices.at(address)
        return () if device is None else missed(device.raw, since)

    def _last_of(self, texts: PartTexts, since: float) -> tuple[RawMessage, ...]:
        """Return what came from *since* on, or the last state: no broker keeps it, so the gateway does."""
        recent = texts.missed_by(since, self._clock.monotonic())
        if recent or not texts.kept:
            return recent
        return (texts.kept[-1][1].model_copy(update={"retained": True}),)

    def _warn(self, event: str, address: str, problem: HomebotError) -> None:
        if self._limit.allows(f"{event} {address[:100]}") is not None:
            self._gateway.node.log.warning(event, message=f"not sent to {address[:100]}: {problem}")


def _unknown(address: str) -> tuple[str, str]:
    return address, address
