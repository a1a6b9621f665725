"""The world of a gateway under test: its lamp, its neighbour, and the graph that it runs on."""

import asyncio
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, contextmanager

import anyio
import pytest

from homebot.gateways import Gateway
from homebot.graph import Graph, Node
from homebot.runtime.dry_run import MutedNode
from homebot.testing.gateway_contract.lamp import Lamp, Neighbour
from homebot.testing.pytest_loops import loop_of


@asynccontextmanager
async def running(gateway: Gateway) -> AsyncIterator[None]:
    """Run *gateway* inside the block."""
    async with anyio.create_task_group() as tasks:
        await tasks.start(gateway.serve)
        yield
        tasks.cancel_scope.cancel()


class HeldClock:
    """The time of the running event loop, which stands still while it is held; timers of the loop go on.

    A test holds it so that work is counted, and not the time that a slow machine takes for it.
    """

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._epoch = time.time() - self._loop.time()
        self._missed = 0.0
        self._held_at: float | None = None

    def monotonic(self) -> float:
        """Return seconds since an arbitrary start."""
        return self._loop.time() - self._missed if self._held_at is None else self._held_at

    def now(self) -> float:
        """Return seconds since the Unix epoch."""
        return self._epoch + self.monotonic()

    @contextmanager
    def held(self) -> Iterator[None]:
        """Let it stand still inside the block."""
        self._held_at = self.monotonic()
        try:
            yield
        finally:
            self._missed = self._loop.time() - self._held_at
            self._held_at = None


class GatewayWorld:
    """The base of the suites.

    Attributes:
        takes_commands: Whether devices of its protocol can be told anything; of others, all commands are refused.
    """

    name = "gateway"
    time_is_virtual = False
    takes_commands = True
    tells_goodbye = True

    @pytest.fixture(autouse=True)
    def _on_a_loop(self, request: pytest.FixtureRequest) -> None:
        loop_of(request, "GatewayContract")

    def lamp(self) -> AbstractAsyncContextManager[Lamp]:
        """Return a lamp in its world, which is there inside the block."""
        raise NotImplementedError

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        """Return a gateway to the world of *lamp*, with these *settings* beside those that lead there."""
        raise NotImplementedError

    def neighbour(self, lamp: Lamp) -> Neighbour | None:
        """Return another system in the world of *lamp*; None where homebot cannot expose anything there."""
        del lamp
        return None

    @asynccontextmanager
    async def house(self, *, is_muted: bool = False, **settings: object) -> AsyncIterator[tuple[Lamp, Node]]:
        """Run the gateway with its lamp, and another node on its graph with a :class:`HeldClock`."""
        graph = Graph(HeldClock())
        async with (
            self.lamp() as lamp,
            Node(graph, "watcher") as watcher,
            self.started(lamp, graph, settings, is_muted=is_muted),
        ):
            yield lamp, watcher

    @asynccontextmanager
    async def started(
        self, lamp: Lamp, graph: Graph, settings: dict[str, object], *, is_muted: bool = False
    ) -> AsyncIterator[None]:
        """Run a gateway to the world of *lamp*; *is_muted* as in a dry run, of which it does not know."""
        async with MutedNode(graph, self.name) if is_muted else Node(graph, self.name, namespace="/gateway") as node:
            lamp.gateway = self.gateway(lamp, node, settings)
            async with running(lamp.gateway):
                yield
