"""The service ``send_command`` of a gateway, over one port."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import TypeAlias

import anyio.lowlevel

from homebot.devices.command_description import CommandDescription
from homebot.devices.gateway_messages import Command, RawCommand, SendCommand, SendCommandResponse
from homebot.devices.text.commands import decode_command
from homebot.devices.value import Value
from homebot.errors import HomebotError, LinkError, RefusedError, UnableError
from homebot.gateways.announced.announcement import AnnouncedPart
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.base import Gateway
from homebot.graph import Subscription

__all__ = ["CommandServer", "Perform"]

Perform: TypeAlias = Callable[[Command], Coroutine[object, object, None]]
"""The port: carries out a command of which it returns when the network has it.

It raises :class:`UnableError` where the part cannot do that as it is described and nothing was sent,
:class:`LinkError` where the device or its network cannot be reached now, and :class:`RefusedError` where one of them
says no.
"""


FindPart: TypeAlias = Callable[[str, str], AnnouncedPart]
"""Returns the part of a device, by the device's key and its own id; raises :class:`UnableError` for none."""


class CommandServer:
    """The service ``send_command`` of a gateway, and the way from texts to commands.

    Args:
        gateway: The gateway; one that only observes refuses every command.

    Attributes:
        raw: The raw commands: a later command does not overtake those that are still queued.
    """

    def __init__(self, gateway: Gateway, perform: Perform, find_part: FindPart, counters: GatewayCounters) -> None:
        self._gateway = gateway
        self._perform = perform
        self._find_part = find_part
        self._counters = counters
        self.raw: Subscription[RawCommand] | None = None
        gateway.node.create_service(SendCommand, gateway.names.send_command, self.serve, concurrent=True)

    async def serve(self, command: Command) -> SendCommandResponse:
        """Answer the service: carry *command* out, and return its outcome."""
        if not self._gateway.acts:
            self._counters.commands_refused += 1
            return SendCommandResponse(success=False, message=self._gateway.observes_because, problem="refused")
        limit = asyncio.timeout(command.expires_after or None)
        try:
            if command.approved:
                self._check_approved(command)
            raw = self.raw
            waits = raw is not None and (raw.mailbox.queue or raw.unbegun)
            perform = self._perform_after_raw if waits else self._perform
            async with limit:  # as while a radio connects: nothing happens late
                await perform(command)
        except LinkError as exc:
            return self._failed(str(exc))
        except HomebotError as exc:
            self._counters.commands_refused += 1
            is_unable = isinstance(exc, UnableError)
            return SendCommandResponse(success=False, message=str(exc), problem="refused", unable=is_unable)
        except TimeoutError:
            if not limit.expired():
                raise
            return self._failed(f"{command.key[:100]} was not reached within {command.expires_after:.2g} s")
        self._counters.commands += 1
        return SendCommandResponse(success=True, message="", problem="", unable=False)

    def _check_approved(self, command: Command) -> None:
        """Refuse a command if its part is described anew since the owner approved it."""
        template = self._find_part(command.key, command.part).stored.template
        part = next((one for one in template.parts if one.id == command.part), None)
        if part is None or CommandDescription.of(part, template.identifiers).digest != command.approved:
            raise RefusedError(f"a command to {command.key[:100]}", "it changed since the owner approved it")

    def _failed(self, problem: str) -> SendCommandResponse:
        self._counters.commands_failed += 1
        return SendCommandResponse(success=False, message=problem, problem="unreachable")

    async def tell(self, key: str, part_id: str, text: str, command_id: str = "") -> None:
        """Carry out the command that *text* means for a part; see :mod:`homebot.devices.text.commands`."""
        if not self._gateway.acts:
            raise RefusedError(f"a command to {key[:100]}", self._gateway.observes_because)
        capability, value = decode_command(text, self._find_part(key, part_id).described.part)
        await self._perform(Command(key=key, part=part_id, capability=capability, value=Value.of(value), id=command_id))

    async def _perform_after_raw(self, command: Command) -> None:
        """Carry *command* out once the sending of each raw command that is queued now has begun."""
        if self.raw is not None:
            mailbox = self.raw.mailbox
            for _ in range(len(mailbox.queue)):  # at each change one of them is taken out, or several
                if mailbox.queue:
                    await mailbox.wait_for_change()
            await anyio.lowlevel.checkpoint()  # the tasks of those that were taken begin
        await self._perform(command)
