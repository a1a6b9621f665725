"""Reports of the link to the broker, to people and to the graph."""

from collections.abc import Sequence

import anyio

from homebot.gateways.base import UNAVAILABLE, Gateway
from homebot.log import LogLimit
from homebot.mqtt.connection import ConnectionState, LinkPhase, MqttConnection

CONNECTED = "gateway.connected"
LOST = "gateway.link_lost"
NOT_HEARD = "gateway.subscription_refused"
NO_ANSWER = "gateway.no_answer"

ANSWER_WAIT = 2.0
"""Seconds for which startup waits for the broker's answer; the gateway keeps trying after that."""

_MAX_NAMES = 10
_DOWN = frozenset({LinkPhase.WAITING, LinkPhase.REFUSED})

TRIES_EVERY = 600.0
"""Seconds between two log lines about failed attempts with one reason: a broker may be away for days."""

MAX_LOSSES = 5
"""Most log lines about a lost link in ten seconds."""


class LinkReport:
    """Logs and publishes the states of a connection.

    Args:
        listening_to: The subject of the subscriptions, for the log.
        filters: Subscriptions of which at least one must be granted for the gateway to receive anything.
    """

    def __init__(self, gateway: Gateway, connection: MqttConnection, listening_to: str, filters: Sequence[str]) -> None:
        self._gateway = gateway
        self._connection = connection
        self._listening_to = listening_to
        self._filters = filters
        self._tried = anyio.Event()
        self._was_up = False
        clock = gateway.node.graph.clock
        self._tries = LogLimit(clock, TRIES_EVERY)
        self._losses = LogLimit(clock, burst=MAX_LOSSES)

    async def wait_for_first_try(self) -> None:
        """Wait for the end of the first attempt to connect, for at most 2 s."""
        with anyio.move_on_after(ANSWER_WAIT):
            await self._tried.wait()
            return
        self._gateway.node.log.warning(
            NO_ANSWER,
            message=f"{self._connection.url} has not answered yet; still trying",
            broker=self._connection.url,
        )

    async def watch(self) -> None:
        """Report each state until the connection is closed."""
        async for state in self._connection.states():
            if state.phase is LinkPhase.CONNECTED:
                self._connected()
            elif state.phase in _DOWN or (self._was_up and state.phase is LinkPhase.CONNECTING):
                self._down(state)  # after a loss the next attempt starts at once, and may take ten seconds
            self._was_up = state.phase is LinkPhase.CONNECTED
            if state.phase is not LinkPhase.CONNECTING:
                self._tried.set()

    def _connected(self) -> None:
        if self._was_up:
            self._gateway.publish_state("unavailable", "the connection was lost")  # and restored at once
        url, refused = self._connection.url, self._connection.refused
        observing = "" if self._gateway.acts else " (observing only)"
        hears = f"listening to {self._listening_to}{observing}"
        if not refused:
            self._gateway.publish_state("active")
            self._gateway.node.log.info(CONNECTED, message=f"connected to {url}, {hears}", broker=url)
            return
        names = ", ".join(list(refused)[:_MAX_NAMES]) + (", …" if len(refused) > _MAX_NAMES else "")
        reason = f"the broker refused the subscription to {names}: {next(iter(refused.values()))}"
        is_deaf = all(one in refused for one in self._filters)
        self._gateway.publish_state("unavailable" if is_deaf else "active", reason)
        outcome = "it receives nothing" if is_deaf else hears
        self._gateway.node.log.warning(NOT_HEARD, message=f"connected to {url}, but {reason}; {outcome}", broker=url)

    def _down(self, state: ConnectionState) -> None:
        url = self._connection.url
        reason = state.reason.removeprefix(f"{url}: ")
        self._gateway.publish_state("unavailable", f"{url}: {reason}")
        event, limit = (LOST, self._losses) if self._was_up else (UNAVAILABLE, self._tries)
        if limit.allows(event if self._was_up else reason) is None:
            return
        what = f"lost the connection to {url}" if self._was_up else f"cannot connect to {url}"
        soon = "trying again" if not state.retry_in or state.retry_in < 2 else f"trying again in {state.retry_in:.0f} s"
        self._gateway.node.log.warning(event, message=f"{what}: {reason}; {soon}", broker=url, reason=reason)
