"""One client of the door: what it may do, what it holds, and that all of it goes when the client goes.

Frames are handled in the order in which they come; service calls run side by side.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass
from functools import partial

import anyio
from anyio.abc import TaskGroup

from homebot.bridges.rosbridge.calls import call_service
from homebot.bridges.rosbridge.complaints import Complaints, deed
from homebot.bridges.rosbridge.protocol import (
    ActionOperation,
    Advertise,
    AdvertiseService,
    CallService,
    FrameError,
    Identifier,
    Level,
    Operation,
    Publish,
    ServiceResponse,
    SetLevel,
    Subscribe,
    Unadvertise,
    UnadvertiseService,
    Unsubscribe,
    action_refusal,
    parse_frame,
    service_failure,
    status_frame,
)
from homebot.bridges.rosbridge.provided import ProvidedServices
from homebot.bridges.rosbridge.publications import Publications
from homebot.bridges.rosbridge.settings import DoorSettings
from homebot.bridges.rosbridge.subscriptions import Subscriptions
from homebot.errors import HomebotError, LinkError, PeerError
from homebot.graph import Node
from homebot.messages.json import JsonObject

__all__ = ["Session"]

_SEVERITY: dict[Level, int] = {"none": 0, "error": 1, "warning": 2, "info": 3}
_NO_ACTIONS = "this homebot offers no actions"


class Session:
    """What one client does through the door.

    Args:
        node: The node that acts in the client's stead.
        settings: The limits.
        client: What to call the client in the log.
        send: Takes a frame to the client, waiting until there is room for it; LinkError when the client is gone.
        complaints: Where the log hears of what the client does wrong.

    Attributes:
        refused: Frames and requests of the client that were refused.
    """

    def __init__(
        self,
        node: Node,
        settings: DoorSettings,
        client: str,
        send: Callable[[JsonObject], Awaitable[None]],
        complaints: Complaints,
    ) -> None:
        self.refused = 0
        self._node = node
        self._settings = settings
        self._client = client
        self._send = send
        self._complaints = complaints
        self._level: Level = "none"
        self._calls = 0

    async def run(self, frames: AsyncIterator[str]) -> None:
        """Do what *frames* ask for until they end; then take back everything the client holds."""
        async with anyio.create_task_group() as tasks:
            holdings = _Holdings(
                Publications(self._node),
                Subscriptions(self._node, self._settings.queue_depth, self._send, tasks),
                ProvidedServices(self._node, self._settings.max_calls, self._send),
                tasks,
            )
            try:
                async for frame in frames:
                    await self._handle(frame, holdings)
            except LinkError:
                pass  # the client went while it was being answered
            finally:
                holdings.close()
                tasks.cancel_scope.cancel()

    async def _handle(self, frame: str, holdings: _Holdings) -> None:
        try:
            op = parse_frame(frame)
        except FrameError as exc:
            said = f": {_refusal(exc.op, exc.target, exc.problem)}" if exc.op else f" sent a frame that {exc.problem}"
            self._complain(said, exc.op or "frame", exc.problem)
            await self._answer(exc.op, exc.id, exc.target, str(exc))
            return
        try:
            await self._do(op, holdings)
        except HomebotError as exc:
            if isinstance(exc, LinkError):
                raise
            self._complain(f": {_refusal(op.op, op.name, str(exc))}", op.op, str(exc))
            await self._answer(op.op, op.id, op.name, str(exc))

    async def _do(self, op: Operation, holdings: _Holdings) -> None:
        match op:
            case Publish():
                if op.topic not in holdings.publications:
                    self._check_room(holdings)
                holdings.publications.publish(op)
            case CallService():
                self._start_call(op, holdings.tasks)
            case ServiceResponse():
                holdings.services.answer(op)
            case SetLevel():
                self._level = op.level
            case ActionOperation(op="send_action_goal"):
                await self._send(action_refusal(op.action, op.id, _NO_ACTIONS))
            case ActionOperation():
                raise PeerError(f"{op.action}: {_NO_ACTIONS}")
            case _:
                await self._register(op, holdings)

    async def _register(self, op: Operation, holdings: _Holdings) -> None:
        match op:
            case Advertise():
                self._check_room(holdings)
                holdings.publications.advertise(op)
            case Unadvertise():
                holdings.publications.unadvertise(op)
            case Subscribe():
                self._check_room(holdings)
                if (remark := await holdings.subscriptions.subscribe(op)) is not None:
                    await self._remark("warning", remark, op.id)
            case Unsubscribe():
                holdings.subscriptions.unsubscribe(op)
            case AdvertiseService():
                self._check_room(holdings)
                holdings.services.advertise(op)
            case UnadvertiseService():
                holdings.services.unadvertise(op)

    def _start_call(self, op: CallService, tasks: TaskGroup) -> None:
        if self._calls >= self._settings.max_calls:
            raise PeerError(f"{self._calls} calls of this client are under way already")
        self._calls += 1
        tasks.start_soon(partial(self._call, op))

    async def _call(self, op: CallService) -> None:
        try:
            await self._send(await call_service(self._node, op))
        except LinkError:
            pass  # nobody is left to answer; the session ends by itself
        finally:
            self._calls -= 1

    def _check_room(self, holdings: _Holdings) -> None:
        if len(holdings) >= self._settings.max_entities:
            raise PeerError(f"this client uses {len(holdings)} topics and services already, and may use no more")

    def _complain(self, said: str, op: str, problem: str) -> None:
        self.refused += 1
        self._complaints.say(
            f"refused {self._client.rpartition(':')[0]}",
            "door.refused",
            f"{self._client}{said}",
            client=self._client,
            op=op,
            problem=problem,
            refused=self.refused,
        )

    async def _answer(self, op: str, identifier: Identifier, target: str, problem: str) -> None:
        if op == "call_service":
            await self._send(service_failure(target, identifier, problem))
        elif op == "send_action_goal":
            await self._send(action_refusal(target, identifier, problem))
        else:
            await self._remark("error", problem, identifier)

    async def _remark(self, level: Level, text: str, identifier: Identifier) -> None:
        """Tell the client something, if it wants to hear things of this *level*."""
        if _SEVERITY[self._level] >= _SEVERITY[level]:
            await self._send(status_frame(level, text, identifier))


@dataclass(frozen=True, slots=True)
class _Holdings:
    """Everything that goes when the client goes."""

    publications: Publications
    subscriptions: Subscriptions
    services: ProvidedServices
    tasks: TaskGroup

    def __len__(self) -> int:
        return len(self.publications) + len(self.subscriptions) + len(self.services)

    def close(self) -> None:
        self.publications.close()
        self.subscriptions.close()
        self.services.close()


def _refusal(op: str, name: str, problem: str) -> str:
    return f"{deed(op, name)} was refused: {problem}"
