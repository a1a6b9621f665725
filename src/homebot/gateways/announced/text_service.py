"""The raw side of a gateway: the topic ``out`` and the service ``subscribe_to_topic``, for texts and raw messages."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Protocol

from homebot.devices import RawCommand, RawMessage, SubscribeToTopic
from homebot.devices.names import TEXT_SCHEME, read_text_address
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.errors import HomebotError, LinkError, RefusedError
from homebot.gateways.announced.announcement import AnnouncedPart, StoredAnnouncement
from homebot.gateways.announced.command_server import CommandServer
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.base import Gateway
from homebot.gateways.raw_delivery import RawDelivery, begin_of

__all__ = ["RawMessages", "TextService"]

COMMAND_REFUSED = "gateway.command_refused"
COMMAND_FAILED = "gateway.command_failed"

_OUT_DEPTH = 1000


class RawMessages(Protocol):
    """The port to the raw messages of a protocol; an address of its own is never a text address."""

    def send_raw(self, command: RawCommand) -> Awaitable[object]:
        """Send a raw command to the address that it names, once awaited.

        Raises:
            RefusedError: It cannot be sent there.
            LinkError: There is no link.
        """
        ...

    def find_source(self, address: str) -> tuple[str, str]:
        """Return key and name of the device that reports raw messages on *address*, known or not yet.

        Raises:
            RefusedError, WireError: Listening there is not allowed.
            InvalidNameError: It is no address.
        """
        ...

    def missed_by(self, address: str, since: float) -> tuple[RawMessage, ...]:
        """Return the messages on *address* since *since*, on the monotonic clock, for a new listener."""
        ...


class TextService:
    """Delivers texts and raw messages of devices, and takes texts and raw commands for them.

    Args:
        keeps_states: See :meth:`homebot.gateways.announced.engine.GatewayEngine.serve`.
    """

    def __init__(
        self,
        gateway: Gateway,
        devices: Mapping[str, StoredAnnouncement],
        commands: CommandServer,
        listeners: RawDelivery,
        counters: GatewayCounters,
        raw: RawMessages,
        log: Callable[[str, str, str], None],
        *,
        keeps_states: bool,
    ) -> None:
        self._gateway = gateway
        self._devices = devices
        self._commands = commands
        self._listeners = listeners
        self._counters = counters
        self._raw = raw
        self._log = log
        self._keeps_states = keeps_states
        self._clock = gateway.node.graph.clock
        node, names = gateway.node, gateway.names
        out = node.create_subscription(RawCommand, names.out, self._send, _OUT_DEPTH, concurrent=True)
        commands.raw = out
        node.create_service(SubscribeToTopic, names.subscribe, self.subscribe)

    def subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        """Answer the service: deliver all further messages on an address."""
        try:
            part = read_text_address(request.topic)
            key, name = self._raw.find_source(request.topic) if part is None else self._device_of(part[0])
            is_new = not self._listeners.has(request.topic, request.listener)
            publisher = self._listeners.add(request.topic, key, name, request.listener)
        except RefusedError as exc:
            return SubscribeToTopicResponse(success=False, message=exc.reason, data_topic="")
        except HomebotError as exc:
            return SubscribeToTopicResponse(success=False, message=str(exc), data_topic="")
        missed: tuple[RawMessage, ...] = ()
        if is_new:
            since = begin_of(request.since, self._clock)
            missed = self._raw.missed_by(request.topic, since) if part is None else self._missed_texts(*part, since)
        return SubscribeToTopicResponse(success=True, message="", data_topic=publisher.topic_name, missed=missed)

    async def _send(self, command: RawCommand) -> None:
        address = command.address
        try:
            if address.startswith(TEXT_SCHEME) and (part := read_text_address(address)) is not None:
                await self._commands.tell(*part, command.payload, command.command_id)
            elif not self._gateway.acts:
                raise RefusedError("the command", self._gateway.observes_because)
            else:
                await self._raw.send_raw(command)
            self._counters.commands += 1
        except LinkError as exc:
            self._counters.commands_failed += 1
            self._log(COMMAND_FAILED, f"not sent to {address[:100]}: {exc}", address)
        except HomebotError as exc:
            self._counters.commands_refused += 1
            self._log(COMMAND_REFUSED, f"not sent to {address[:100]}: {exc}", address)

    def _device_of(self, key: str) -> tuple[str, str]:
        """Return key and name; a listener from before the gateway's restart asks before its devices are found."""
        stored = self._devices.get(key)
        return key, key if stored is None else stored.described.name

    def _missed_texts(self, key: str, part_id: str, since: float) -> tuple[RawMessage, ...]:
        stored = self._devices.get(key)
        part: AnnouncedPart | None = None if stored is None else stored.parts.get(part_id)
        if part is None:
            return ()
        recent = part.missed_by(since, self._clock.monotonic())
        if recent or not self._keeps_states or not part.kept:
            return recent
        return (part.kept[-1][1].model_copy(update={"retained": True}),)
