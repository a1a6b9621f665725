"""The commands, texts and raw messages of a gateway, over the ports of its protocol."""

import asyncio
from collections.abc import Awaitable, Callable, Collection, Coroutine
from typing import Any, Literal, Protocol, TypeAlias

import anyio.lowlevel

from homebot.devices import RawCommand, RawMessage, SubscribeToTopic
from homebot.devices.approval_messages import DescribeCommands, DescribeCommandsRequest, DescribeCommandsResponse
from homebot.devices.gateway_messages import (
    Command,
    RefreshPart,
    RefreshRequest,
    RefreshResponse,
    SendCommand,
    SendCommandResponse,
)
from homebot.devices.health import GetHealth, HealthResponse
from homebot.devices.names import ONLY_OBSERVES, TEXT_SCHEME, read_text_address
from homebot.devices.part import CommandDescription
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.devices.text.commands import decode_command
from homebot.devices.value import Value
from homebot.errors import HomebotError, LinkError, RefusedError, UnableError
from homebot.gateways.announced.announcement import AnnouncedPart
from homebot.gateways.announced.engine import GatewayEngine
from homebot.gateways.raw_delivery import begin_of
from homebot.support.unanswered import SENT_REQUESTS, SentRequests

COMMAND_REFUSED = "gateway.command_refused"
COMMAND_FAILED = "gateway.command_failed"

_OUT_DEPTH = 1000
_CARRIED_OUT = SendCommandResponse(success=True, message="", problem="", unable=False)

Perform: TypeAlias = Callable[[Command], Coroutine[object, object, Collection[str] | None]]
"""The port of a protocol: sends a command, and returns when the network has it.

It returns the capabilities of :attr:`Command.also` that went along in the same message; None or empty for none.
It raises :class:`UnableError` if the part as described cannot do that and nothing was sent,
:class:`LinkError` if the device or its network cannot be reached now, and :class:`RefusedError` if one of them
refuses. It waits for an answer inside :func:`homebot.support.unanswered.awaiting_answer`.
"""


Refresh: TypeAlias = Callable[[str, str], Awaitable[object]]
"""The port of a protocol with values that can be asked for: asks the part of a key, and a group's members.

It raises :class:`UnableError` if the part cannot be asked, and :class:`LinkError` if it cannot be reached now.
"""


class RawMessages(Protocol):
    """The port to the raw messages of a protocol; its addresses are never text addresses."""

    def send_raw(self, command: RawCommand) -> Awaitable[object]:
        """Send a raw command to its address; nothing is sent before the result is awaited.

        Raises:
            RefusedError: It cannot be sent there.
            LinkError: There is no link.
        """

    def find_source(self, address: str, *, undeclared: bool) -> tuple[str, str]:
        """Return key and name of the device with raw messages on *address*, even if it is not known yet.

        Args:
            undeclared: Whether an address without a device may be listened to, where the protocol has such.

        Raises:
            RefusedError, WireError: Listening there is not allowed.
            InvalidNameError: It is not an address.
        """

    def missed_by(self, address: str, since: float) -> tuple[RawMessage, ...]:
        """Return the kept messages on *address* since *since*, on the monotonic clock, for a new listener."""


class CommandServer:
    """The services that all gateways share, and the topic ``out``; see :mod:`homebot.gateways.base`.

    Args:
        health: Returns the health report of the protocol, which the engine's counters complete.
        keeps_states: Whether a new listener to the texts of a part gets its last state as a retained message;
            False if the network itself retains states.
        refresh: Asks a part for its values; None if the protocol cannot.
    """

    def __init__(
        self,
        engine: GatewayEngine[Any],
        perform: Perform,
        raw: RawMessages,
        health: Callable[[], HealthResponse],
        *,
        keeps_states: bool,
        refresh: Refresh | None = None,
    ) -> None:
        self._gateway = engine.gateway
        self._perform = perform
        self._find_part = engine.find_part
        self._devices = engine.devices
        self._listeners = engine.listeners
        self._counters = engine.counters
        self._raw = raw
        self._log = engine.quarantine.log_limited
        self._keeps_states = keeps_states
        node, names = self._gateway.node, self._gateway.names
        self._clock = node.graph.clock
        node.create_service(SendCommand, names.send_command, self.serve, concurrent=True)
        node.create_service(SubscribeToTopic, names.subscribe, self.subscribe)
        node.create_service(GetHealth, names.health, lambda _: engine.health(health()))
        node.create_service(DescribeCommands, names.describe_commands, self.describe_commands, concurrent=True)
        self._refresh = refresh
        if refresh is not None:
            node.create_service(RefreshPart, names.refresh, self.refresh, concurrent=True)
        self._out = node.create_subscription(RawCommand, names.out, self._send, _OUT_DEPTH, concurrent=True)

    async def serve(self, command: Command) -> SendCommandResponse:
        """Carry out *command*, and return its outcome."""
        if not self._gateway.acts:
            self._counters.commands_refused += 1
            why = self._gateway.observes_because
            return SendCommandResponse(success=False, message=why, problem="refused", unable=why == ONLY_OBSERVES)
        limit = asyncio.timeout(command.expires_after or None)
        requests = SentRequests()
        token = SENT_REQUESTS.set(requests)
        try:
            async with limit:  # so that nothing happens late, for example after a radio has connected
                if self._out.mailbox.queue or self._out.unbegun:
                    # every raw command queued so far begins to be sent first
                    mailbox = self._out.mailbox
                    for _ in range(len(mailbox.queue)):  # each change takes out at least one
                        if mailbox.queue:
                            await mailbox.wait_for_change()
                    await anyio.lowlevel.checkpoint()  # their tasks begin
                if command.approved:
                    self._check_approved(command)
                along = await self._perform(command)
        except LinkError as exc:
            return self._report_failure(str(exc), requests)
        except HomebotError as exc:
            self._counters.commands_refused += 1
            is_unable = isinstance(exc, UnableError)
            return SendCommandResponse(success=False, message=str(exc), problem="refused", unable=is_unable)
        except TimeoutError:
            if not limit.expired():
                raise
            what = "did not answer" if requests.is_unanswered else "was not reached"
            return self._report_failure(f"{command.key[:100]} {what} within {command.expires_after:.2g} s", requests)
        finally:
            SENT_REQUESTS.reset(token)
        self._counters.commands += 1
        return _CARRIED_OUT.model_copy(update={"along": tuple(along)}) if along and command.also else _CARRIED_OUT

    async def refresh(self, request: RefreshRequest) -> RefreshResponse:
        """Ask a part for its values, and return whether it was asked."""
        if self._refresh is None or not self._gateway.acts:
            return RefreshResponse(success=False, message=self._gateway.observes_because)
        try:
            await self._refresh(request.key, request.part)
        except HomebotError as exc:
            return RefreshResponse(success=False, message=str(exc))
        return RefreshResponse(success=True, message="")

    def subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        """Deliver all further messages on an address."""
        try:
            part = read_text_address(request.topic)
            key, name = (
                self._raw.find_source(request.topic, undeclared=request.undeclared and bool(request.listener))
                if part is None
                else self._device_of(part[0])
            )
            is_new = not self._listeners.has(request.topic, request.listener)
            publisher = self._listeners.add(request.topic, key, name, request.listener)
        except HomebotError as exc:
            reason = exc.reason if isinstance(exc, RefusedError) else str(exc)
            return SubscribeToTopicResponse(success=False, message=reason, data_topic="")
        missed: tuple[RawMessage, ...] = ()
        if is_new:
            since = begin_of(request.since, self._clock)
            missed = self._raw.missed_by(request.topic, since) if part is None else self._missed_texts(*part, since)
        return SubscribeToTopicResponse(success=True, message="", data_topic=publisher.topic_name, missed=missed)

    async def describe_commands(self, request: DescribeCommandsRequest) -> DescribeCommandsResponse:
        """Return the messages that commands to a device would send, as text."""
        from homebot.gateways.announced.sent_commands import sent_commands  # noqa: PLC0415 - asked before an approval

        stored, lines = self._devices.get(request.key), list[str]()
        for part in () if stored is None else stored.described.parts:
            for line in sent_commands(part):
                lines.append(line)
                await anyio.lowlevel.checkpoint()  # a stranger's template may take milliseconds
        return DescribeCommandsResponse(commands=tuple(lines))

    def _check_approved(self, command: Command) -> None:
        """Refuse a command to a part whose description has changed since the owner approved it."""
        template = self._find_part(command.key, command.part).stored.template
        part = next((template_part for template_part in template.parts if template_part.id == command.part), None)
        if part is None or CommandDescription.of(part, template.identifiers).digest != command.approved:
            raise RefusedError(f"a command to {command.key[:100]}", "it changed since the owner approved it")

    def _report_failure(self, message: str, requests: SentRequests) -> SendCommandResponse:
        self._counters.commands_failed += 1
        problem: Literal["unanswered", "unreachable"] = "unanswered" if requests.is_unanswered else "unreachable"
        return SendCommandResponse(success=False, message=message, problem=problem)

    async def _send(self, command: RawCommand) -> None:
        address, requests = command.address, SentRequests()
        SENT_REQUESTS.set(requests)  # for this task alone
        try:
            if address.startswith(TEXT_SCHEME) and (part := read_text_address(address)) is not None:
                await self._send_text(*part, command)
            elif not self._gateway.acts:
                raise RefusedError("the command", self._gateway.observes_because)
            else:
                await self._raw.send_raw(command)
            self._counters.commands += 1
        except LinkError as exc:
            self._counters.commands_failed += 1
            what = "not acknowledged by" if requests.is_unanswered else "not sent to"
            self._log(COMMAND_FAILED, f"{what} {address[:100]}: {exc}", address)
        except HomebotError as exc:
            self._counters.commands_refused += 1
            self._log(COMMAND_REFUSED, f"not sent to {address[:100]}: {exc}", address)

    async def _send_text(self, key: str, part_id: str, text: RawCommand) -> None:
        """Carry out the command that *text* means for a part; see :mod:`homebot.devices.text.commands`."""
        if not self._gateway.acts:
            raise RefusedError(f"a command to {key[:100]}", self._gateway.observes_because)
        part = self._find_part(key, part_id).described.part
        capability, value = decode_command(text.payload, part)
        (known,) = (candidate for candidate in part.capabilities if candidate.name == capability)
        value = known.nearest(value) if isinstance(value, float) else value
        command = Command(
            key=key,
            part=part_id,
            capability=capability,
            value=Value.of(value),
            id=text.command_id,
            approved=text.approved,
            topics=text.topics,
        )
        if command.approved:
            self._check_approved(command)
        await self._perform(command)

    def _device_of(self, key: str) -> tuple[str, str]:
        """Return key and name; after a restart of the gateway, listeners ask before the device is found again."""
        stored = self._devices.get(key)
        return key, (stored.described.name if stored is not None else "") or key

    def _missed_texts(self, key: str, part_id: str, since: float) -> tuple[RawMessage, ...]:
        stored = self._devices.get(key)
        part: AnnouncedPart | None = None if stored is None else stored.parts.get(part_id)
        if part is None:
            return ()
        recent = part.missed_by(since, self._clock.monotonic())
        if recent or not self._keeps_states or not part.kept:
            return recent
        return (part.kept[-1][1].model_copy(update={"retained": True}),)
