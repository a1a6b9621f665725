"""The end of a service that reached none of its networks: its manager starts it anew."""

from __future__ import annotations

from collections.abc import Collection
from typing import final

import anyio

from homebot.devices import GatewayNames, GatewayState
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.support.logger import get_logger

__all__ = ["CONNECTS_WITHIN", "FirstConnection"]

NEVER_CONNECTED = "runtime.never_connected"

CONNECTS_WITHIN = 300.0
"""Seconds in which a gateway must have been active once; a router takes two minutes after a power cut."""

_log = get_logger(node="/homebot")


@final
class FirstConnection:
    """Waits until one of the *gateways* is active.

    Attributes:
        is_missing: Whether none was in time.
    """

    def __init__(self, graph: Graph, gateways: Collection[str]) -> None:
        self.is_missing = False
        self._graph = graph
        self._gateways = gateways

    async def wait_in_vain(self) -> None:
        """Return if no gateway became active in time; wait for ever otherwise, also without gateways."""
        if self._gateways and not await self._is_made():
            self.is_missing = True
            minutes = f"{CONNECTS_WITHIN / 60:g} minutes"
            _log.critical(
                NEVER_CONNECTED,
                message=f"no gateway was connected within {minutes} ({', '.join(self._gateways)}); "
                "the service ends, so that it is started anew; homebot doctor --offline --reach looks for the cause",
            )
            return
        await anyio.sleep_forever()

    async def _is_made(self) -> bool:
        connected = anyio.Event()

        def check(state: GatewayState) -> None:
            if state.state == "active":
                connected.set()

        async with Node(self._graph, "first_connection", namespace="/homebot") as node:
            for name in self._gateways:
                node.create_subscription(GatewayState, GatewayNames(name).state, check, qos_profile_latched)
            with anyio.move_on_after(CONNECTS_WITHIN):
                await connected.wait()
        return connected.is_set()
