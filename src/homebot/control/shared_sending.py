"""One message to a group in place of one to each of its members."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

import anyio

from homebot.control.timeline.facts import GroupMessage
from homebot.devices.outcomes import AlreadySo, Outcome
from homebot.errors import HomebotError, LinkError, RefusedError, UnansweredError

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from homebot.control.timeline.progress import CommandProgress
    from homebot.devices import Device, DevicePart
    from homebot.devices.command_messages import Setting
    from homebot.devices.command_sender import CommandSender
    from homebot.devices.gateway_messages import Command
    from homebot.graph import Node

_MAX_WAIT_S: Final = 0.5
"""Seconds for which a command waits until the others are about to be sent too."""


@final
class SharedSending:
    """One message to a group, or a scene, in place of the first sending of the commands to its members.

    It is sent when each of these is about to be sent, or need not be, because its part is already so. If one is held
    back, or the group cannot be reached, each is sent by itself.

    Args:
        recall: The command that recalls the scene; None for a group, which gets the settings of its members.

    Attributes:
        device: The group, or the device that keeps the scene.
        part: Its part.
        name: Its name for the journal.
        progress: That of each command that it is sent for.
        message: The message to a group, as far as its bridge repeats it.
    """

    def __init__(
        self,
        node: Node,
        sender: CommandSender,
        group: tuple[Device, DevicePart],
        awaited: int,
        may_send: Callable[[], Awaitable[bool]],
        recall: Setting | None = None,
    ) -> None:
        self.device, self.part = group
        self.name = f"group {self.device.name}" if recall is None else f"scene {self.part.part.name}"
        self._recall = recall
        echoed = [capability.name for capability in self.part.part.capabilities if capability.echoed]
        self.message = GroupMessage(frozenset(echoed))
        self._node, self._sender, self._may_send = node, sender, may_send
        self._awaited = awaited
        self._orders: list[Sequence[Command]] = []
        self.progress: list[CommandProgress] = []
        self._on_sent: list[Callable[[], object]] = []
        self._decided, self._ended = anyio.Event(), anyio.Event()
        self._problem: HomebotError | None = LinkError("it was not sent")

    async def send_with_group(
        self, orders: Sequence[Command], progress: CommandProgress, on_sent: Callable[[], object]
    ) -> bool:
        """Wait for the other commands, have one message sent for all of them, and return whether it was.

        Args:
            orders: The same for each of the commands to a group, except for their times.
            progress: That of the command: none may be replaced by a newer one meanwhile.
            on_sent: Called when the one message is handed to the gateway.

        Raises:
            UnansweredError: It was sent, but its network has not acknowledged it.
        """
        self._orders.append(orders)
        self.progress.append(progress)
        self._on_sent.append(on_sent)
        self._send_if_complete()
        with anyio.move_on_after(_MAX_WAIT_S):
            await self._decided.wait()
        if not self._decided.is_set():
            self._abandon()
        await self._ended.wait()
        if isinstance(self._problem, UnansweredError):
            raise self._problem
        return self._problem is None

    def leave(self, outcome: Outcome) -> None:
        """Wait no longer for a command that has an *outcome*."""
        if self._decided.is_set():
            return
        if isinstance(outcome, AlreadySo):
            self._awaited -= 1
            self._send_if_complete()
        else:
            self._abandon()

    def _send_if_complete(self) -> None:
        if self._decided.is_set() or len(self._orders) < self._awaited:
            return
        if len(self._orders) < 2 and (self._recall is None or len(self._orders[0]) < 2):
            self._abandon()
            return
        self._decided.set()
        self._node.create_task(self._send)

    def _abandon(self) -> None:
        self._decided.set()
        self._ended.set()

    async def _send(self) -> None:
        try:
            if not await self._may_send() or any(command.superseded_by for command in self.progress):
                return
            for on_sent in self._on_sent:
                on_sent()
            own: dict[str, object] = {"id": ""}
            if self._recall is not None:
                own |= {"capability": self._recall.capability, "value": self._recall.value}
            orders = self._orders[0] if self._recall is None else self._orders[0][:1]
            left: Sequence[Command] = [order.model_copy(update=own) for order in orders]
            while left:
                _, left = await self._sender.send(self.device, self.part, left)
            self._problem = None
        except (LinkError, RefusedError, UnansweredError) as exc:
            self._problem = exc
        finally:
            self._ended.set()
