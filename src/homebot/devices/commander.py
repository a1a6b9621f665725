"""Commands of a node: through the control layer, which verifies them; without one, straight to the gateway."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Final

from homebot.devices.batch import CURRENT_BATCH, in_batch
from homebot.devices.command_messages import (
    MAX_SETTINGS,
    CommandRequest,
    PerformCommand,
    SendText,
    SendTextRequest,
    SendTextResponse,
    Setting,
)
from homebot.devices.command_sender import CommandSender, TextSender
from homebot.devices.current_trigger import current_trigger
from homebot.devices.device import Device, DevicePart
from homebot.devices.gateway_messages import Command
from homebot.devices.hold import HoldBlock
from homebot.devices.names import PERFORM_COMMAND, RUNTIME_NODE, SEND_TEXT
from homebot.devices.outcomes import NO_CONTROL, Confirmed, Evidence, Gone, NoAnswer, Outcome, Refused
from homebot.devices.part import check_setting
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, ServiceError, ServiceUnavailableError, UnansweredError
from homebot.graph import Client, Node
from homebot.log import LogLimit, more_like_this

if TYPE_CHECKING:
    from homebot.devices.device_view import DeviceView
    from homebot.devices.hold import Hold

COMMAND_FAILED: Final = "app.command_failed"
_MAX_CODE: Final = 255
_MAX_WAIT_S: Final = 900.0
"""Seconds after which the control layer has answered: it limits its own waiting."""


class Commander:
    """Gives commands in the name of a node.

    A graph that was built by hand may have no control layer. Then a command goes to the gateway, and only its
    acknowledgement is known. A runtime never does this: nothing is sent while its control layer is away.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._control = node.create_client(PerformCommand, PERFORM_COMMAND)
        self._sender = CommandSender(node)
        self._limit = LogLimit(self._clock)

    async def perform(
        self,
        view: DeviceView,
        part_id: str,
        values: Mapping[str, PlainValue],
        transition: float = 0.0,
        code: str = "",
    ) -> Outcome:
        """Give a command, and return its outcome; a failure of a device or its network is not an error.

        A failure before the control layer is logged as ``app.command_failed``; the control layer logs all others.

        Args:
            view: The device; it is updated with the reported values as soon as they are known.
            values: The values by capability, in the vocabulary's units, in the order of sending; setpoints last.
            transition: Seconds that the change takes, if the device supports that.

        Raises:
            RefusedError: The part does not support one of these, or a value is out of range; nothing was sent.
        """
        try:
            outcome = await self._perform(view, part_id, values, transition, code)
        except RefusedError as exc:
            self._log_failure(view.device, part_id, str(exc))
            raise
        if not outcome.succeeded and not outcome.command_id:
            self._log_failure(view.device, part_id, outcome.text)
        return outcome

    @contextmanager
    def refusals_logged(self, device: Device, part_id: str) -> Iterator[None]:
        """Log a RefusedError of the block as ``app.command_failed``, and raise it."""
        try:
            yield
        except RefusedError as exc:
            self._log_failure(device, part_id, str(exc))
            raise

    def _log_failure(self, device: Device, part_id: str, problem: str) -> None:
        part = device.part(part_id)
        name = f"{device.name} {part.part.name if part else ''}".rstrip()
        if (held_back := self._limit.allows(f"{device.id}#{part_id}")) is not None:
            message = f"{name}: {problem}{more_like_this(held_back)}"
            self._node.log.warning(COMMAND_FAILED, message=message, device=device.id)

    async def _perform(
        self, view: DeviceView, part_id: str, values: Mapping[str, PlainValue], transition: float, code: str
    ) -> Outcome:
        part = None if view.is_gone else view.device.part(part_id)
        if part is None:
            return Gone()
        trigger = current_trigger()
        request = CommandRequest(
            device=view.device.id,
            part=part.id,
            settings=_check(view.device, part, values, transition, code),
            transition=float(transition),
            code=code,
            issuer=self._node.full_name,
            cause=trigger.id,
            trigger=trigger,
        )
        if CURRENT_BATCH.get() is not None:
            request = await in_batch(request)
        try:
            outcome = await self._control.call(request, timeout=_MAX_WAIT_S)
        except ServiceUnavailableError:
            if self._control.service_is_ready() or self._node.graph.get_node(RUNTIME_NODE) is not None:
                return NoAnswer(0.0, NO_CONTROL)
            return await self._send(view.device, part, request)
        except ServiceError as exc:
            return NoAnswer(0.0, str(exc))
        for capability, value in outcome.reported.items():
            view.record_result(part.id, capability, value, self._clock.now())
        return outcome

    async def send_text(self, device: Device, payload: str) -> tuple[str, ...]:
        """Send a raw text; see :meth:`homebot.devices.Devices.tell`."""
        request = SendTextRequest(
            device=device.id, payload=payload, issuer=self._node.full_name, trigger=current_trigger()
        )
        try:
            response = await self._texts.call(request, timeout=_MAX_WAIT_S)
        except ServiceError as exc:
            if isinstance(exc, ServiceUnavailableError) and not self._texts.service_is_ready():
                return await self._send_past_control(device, request)
            raise _not_sent(request, str(exc)) from exc
        if response.problem == "refused":
            raise RefusedError(f"a command to {device.id}", response.message)
        if not response.success:
            raise _not_sent(request, response.message)
        return response.others

    async def _send_past_control(self, device: Device, request: SendTextRequest) -> tuple[str, ...]:
        if self._node.graph.get_node(RUNTIME_NODE) is not None:
            raise LinkError(NO_CONTROL)
        try:
            target = self._text_sender.target(device, request.payload)
            await self._text_sender.send(target, request.issuer, request.trigger)
        except LinkError as exc:
            raise _not_sent(request, str(exc)) from exc
        return target.others

    def hold(self, view: DeviceView, part_id: str, word: str, by: str, ttl: float) -> AbstractAsyncContextManager[Hold]:
        """Return a context manager that holds a part; see :meth:`homebot.devices.handles.Handle.hold`."""
        return HoldBlock(self._node, view, part_id, word, by, ttl)

    @cached_property
    def _texts(self) -> Client[SendTextRequest, SendTextResponse]:
        return self._node.create_client(SendText, SEND_TEXT)

    @cached_property
    def _text_sender(self) -> TextSender:
        return TextSender(self._node)

    async def _send(self, device: Device, part: DevicePart, request: CommandRequest) -> Outcome:
        began = self._clock.monotonic()
        try:
            left: Sequence[Command] = [
                Command(
                    key="",
                    part="",
                    capability=setting.capability,
                    value=setting.value,
                    transition=request.transition,
                    code=request.code,
                )
                for setting in request.settings
            ]
            while left:
                _, left = await self._sender.send(device, part, left)
        except UnansweredError:
            return NoAnswer(self._clock.monotonic() - began, is_unacknowledged=True)
        except LinkError as exc:
            return NoAnswer(0.0, str(exc))
        except RefusedError as exc:
            return Refused("gateway", str(exc))
        return Confirmed(self._clock.monotonic() - began, Evidence.ACKNOWLEDGED)


def _check(
    device: Device, part: DevicePart, values: Mapping[str, PlainValue], transition: float, code: str
) -> tuple[Setting, ...]:
    target = f"{device.id}#{part.id}" if part.id else device.id
    if type(transition) not in (int, float) or not (0 <= transition < math.inf):
        raise RefusedError(f"a transition of {transition!r} s", "it must be a finite number of seconds, 0 or more")
    if not 0 < len(values) <= MAX_SETTINGS:
        raise RefusedError(f"{len(values)} settings of {target}", f"a command has 1 to {MAX_SETTINGS}")
    if type(code) is not str or len(code) > _MAX_CODE:
        raise RefusedError(f"a code for {target}", f"it must be a text of {_MAX_CODE} characters at most")
    settings = []
    for capability, value in values.items():
        check_setting(target, part.part, capability, value)
        settings.append(Setting.of(capability, value))
    return tuple(settings)


def _not_sent(request: SendTextRequest, why: str) -> LinkError:
    return LinkError(f"{request.payload!r} was not sent to {request.device}: {why}")
