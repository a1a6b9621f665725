"""Block of code that holds a value of a part."""

import itertools
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, suppress
from types import TracebackType
from typing import Final

import anyio

from homebot.devices.capabilities import MOMENTARY
from homebot.devices.command_messages import Setting
from homebot.devices.current_trigger import current_trigger
from homebot.devices.device_view import DeviceView
from homebot.devices.lease_messages import (
    MAX_TTL,
    SHORTEST_TTL,
    HolderRequest,
    HoldPart,
    HoldRequest,
    LeaseState,
    ReleaseLease,
    RenewLease,
)
from homebot.devices.names import HOLD_PART, RELEASE_LEASE, RENEW_LEASE
from homebot.devices.outcomes import NO_CONTROL, Gone, NoAnswer, Outcome
from homebot.devices.text.commands import decode_command
from homebot.devices.value import Value
from homebot.errors import RefusedError, ServiceError, UsageError
from homebot.graph import Node

_MAX_WAIT_S: Final = 900.0
"""Seconds after which the control layer has answered: it limits its own waiting."""

_RELEASE: Final = 5.0
_NUMBERS = itertools.count(1)


class Hold:
    """Value that a block holds; see :meth:`homebot.devices.handles.Handle.hold`.

    Attributes:
        outcome: The outcome of the command, updated by each renewal: `Contradicted` once a person's hand has changed
            the device, `Refused` if another holder holds another value.
        is_held: Whether it is held, according to the last answer.
    """

    def __init__(self) -> None:
        self.outcome: Outcome = NoAnswer(0.0, NO_CONTROL)
        self.is_held = False

    @property
    def succeeded(self) -> bool:
        """True if it is held, and the device had the held value at the last answer."""
        return self.is_held and self.outcome.succeeded


class HoldBlock(AbstractAsyncContextManager[Hold]):
    """A block that holds a part; Python warns if it is never entered, just as for a command that is never awaited.

    See :meth:`homebot.devices.handles.Handle.hold`.
    """

    def __init__(self, node: Node, view: DeviceView, part_id: str, word: str, by: str, ttl: float) -> None:
        self._block = _hold(node, view, part_id, word, by, ttl)
        self._entering = _enter(self._block)

    async def __aenter__(self) -> Hold:
        return await self._entering

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> bool | None:
        return await self._block.__aexit__(kind, error, traceback)


async def _enter(block: AbstractAsyncContextManager[Hold]) -> Hold:
    return await block.__aenter__()


_enter.__qualname__ = "Handle.hold.__aenter__"  # the name in the warning


@asynccontextmanager
async def _hold(node: Node, view: DeviceView, part_id: str, word: str, by: str, ttl: float) -> AsyncIterator[Hold]:
    setting = _setting(view, part_id, word)
    if type(by) is not str or not by.strip():
        raise UsageError("a holder needs a name: by='robot'")
    if type(ttl) not in (int, float) or not (SHORTEST_TTL <= ttl <= MAX_TTL):
        raise UsageError(f"a ttl of {ttl!r} s is out of range: {SHORTEST_TTL:g} to {MAX_TTL:g} s")
    if setting is None:
        hold = Hold()
        hold.outcome = Gone()
        yield hold
        return
    request = HoldRequest(
        device=view.device.id,
        part=part_id,
        setting=setting,
        lease=f"block-{next(_NUMBERS)}",
        by=by,
        ttl=ttl,
        issuer=node.full_name,
        trigger=current_trigger(),
    )
    holder = _BlockHolder(node, request)
    error: Exception | None = None
    try:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(holder.renew)
            try:
                await holder.begin()
                yield holder.hold
            except Exception as exc:  # noqa: BLE001 - raised below, as itself rather than in the group of the tasks
                error = exc
            tasks.cancel_scope.cancel()
    finally:
        await holder.end()
    if error is not None:
        raise error


class _BlockHolder:
    """Begins, renews and ends the lease of one block."""

    def __init__(self, node: Node, request: HoldRequest) -> None:
        self.hold = Hold()
        self._request = request
        self._key = HolderRequest(lease=request.lease, by=request.by, issuer=request.issuer)
        self._begin = node.create_client(HoldPart, HOLD_PART)
        self._renew = node.create_client(RenewLease, RENEW_LEASE)
        self._release = node.create_client(ReleaseLease, RELEASE_LEASE)
        self._is_beginning = True
        self._may_begin = True

    async def begin(self) -> None:
        """Start to hold, and wait until the outcome of the command is known."""
        self._is_beginning = True
        try:
            self._record(await self._begin.call(self._request, timeout=_MAX_WAIT_S))
        except ServiceError as exc:
            self._record(LeaseState(held=False, outcome=NoAnswer(0.0, str(exc))))
        finally:
            self._is_beginning = False
        self._may_begin = not self.hold.outcome.is_final

    async def renew(self) -> None:
        """Renew until cancelled, even while the first command is pending; start again if the lease was lost."""
        while True:
            await anyio.sleep(self._request.ttl / 3)
            if not self._may_begin:
                return
            try:
                answer = await self._renew.call(self._key, timeout=self._request.ttl)
            except ServiceError as exc:
                if not self._is_beginning:
                    self._record(LeaseState(held=False, outcome=NoAnswer(0.0, str(exc))))
                continue
            if self._is_beginning:
                continue
            if answer.held:
                self._record(answer)
            else:
                await self.begin()

    async def end(self) -> None:
        """End the hold; without an answer, the lease expires."""
        self.hold.is_held = False
        with anyio.CancelScope(shield=True), suppress(ServiceError):
            await self._release.call(self._key, timeout=_RELEASE)
        for client in (self._begin, self._renew, self._release):
            client.close()

    def _record(self, state: LeaseState) -> None:
        self.hold.is_held, self.hold.outcome = state


def _setting(view: DeviceView, part_id: str, word: str) -> Setting | None:
    """Return the setting that *word* means; None if the device or the part is gone."""
    if type(word) is not str:
        raise UsageError(f"hold() takes a word, such as 'on' or '0.4', not {word!r:.60}")
    part = None if view.is_gone else view.device.part(part_id)
    if part is None:
        return None
    capability, value = decode_command(word, part.part)
    if capability in MOMENTARY or value == "stopped":
        raise RefusedError(f"holding {word!r}", "its effect does not last")
    return Setting(capability=capability, value=Value.of(value))
