"""The base of the brokers on a TCP port and in memory: state, deadlines, starting and stopping."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from random import Random
from types import TracebackType
from typing import Self

from homebot.clock import Clock, LoopClock
from homebot.errors import UsageError
from homebot.mqtt.broker.authentication import Authentication
from homebot.mqtt.broker.limits import BrokerLimits, checked_keep_alive
from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.ports import BrokerPolicy
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.broker.stats import BrokerStats
from homebot.support.logger import get_logger

_log = get_logger()


class EmbeddedBroker(ABC):
    """A broker in this process and event loop; ``async with broker:`` runs it inside the block.

    Sessions and retained messages survive a stop and start; nothing is written to disk.

    Args:
        clock: The clock; by default that of the loop.
        credentials: Passwords by user name; None admits everyone.
        keep_alive: The longest keep-alive interval of MQTT 5 clients in seconds; a longer one, or none,
            is replaced.
        on_message: Called with each message that is forwarded, wills included; must not raise.
        random: Source of assigned client ids; by default unpredictable.

    Raises:
        UsageError: An argument is out of its range.
    """

    def __init__(
        self,
        clock: Clock | None = None,
        limits: BrokerLimits | None = None,
        credentials: Mapping[str, str] | None = None,
        keep_alive: int | None = None,
        policy: BrokerPolicy | None = None,
        on_message: Callable[[BrokerMessage], None] | None = None,
        random: Random | None = None,
    ) -> None:
        self._clock = clock
        self._limits = limits or BrokerLimits()
        self._authentication = Authentication(credentials)
        self._keep_alive = checked_keep_alive(keep_alive)
        self._policy = policy
        self._on_message = on_message
        self._random = random
        self._state: BrokerState | None = None
        self._timer: asyncio.TimerHandle | None = None  # set to the earliest deadline
        self._is_running = False

    @property
    @abstractmethod
    def url(self) -> str:
        """Address for clients, such as ``mqtt://127.0.0.1:1883``."""

    @abstractmethod
    async def _open(self, state: BrokerState) -> None:
        """Accept connections."""

    @abstractmethod
    async def _close(self, *, abrupt: bool) -> None:
        """Stop accepting connections, and end the open ones."""

    @property
    def running(self) -> bool:
        """True while it accepts connections."""
        return self._is_running

    @property
    def stats(self) -> BrokerStats:
        """A snapshot of the counters, which continue across restarts.

        Raises:
            UsageError: The broker was never started.
        """
        return self.state.stats

    @property
    def state(self) -> BrokerState:
        """The broker's state, which survives restarts.

        Raises:
            UsageError: The broker was never started.
        """
        if self._state is None:
            raise UsageError("the broker was never started")
        return self._state

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.stop()

    async def start(self) -> None:
        """Accept connections, with the sessions and retained messages of the last run. Idempotent."""
        if self._is_running:
            return
        if self._state is None:
            self._state = BrokerState(
                self._clock or LoopClock(),
                self._limits,
                self._authentication,
                self._policy,
                self._keep_alive,
                self._on_message,
                self._random,
                _call_soon,
            )
        await self._open(self._state)
        self._is_running = True
        self._state.deadlines.wake = self._wake_at
        self.tick()
        _log.debug("broker.listening", url=self.url)

    async def stop(self, *, abrupt: bool = False) -> None:
        """Close all connections; sessions and retained messages are kept for the next start.

        Wills of the closed clients are not published, as there are no receivers left.

        Args:
            abrupt: As if the process were killed: no DISCONNECT, buffers discarded. Otherwise MQTT 5 clients
                get a DISCONNECT with 0x8B.
        """
        if not self._is_running:
            return
        self._is_running = False
        await self._close(abrupt=abrupt)
        self.state.deadlines.wake = None
        if self._timer is not None:
            self._timer.cancel()
        _log.debug("broker.stopped", url=self.url)

    async def restart(self, *, keep_sessions: bool, abrupt: bool = False) -> None:
        """Stop and start again at the same address.

        Args:
            keep_sessions: Whether to keep sessions, their queues and the retained messages.
            abrupt: As in :meth:`stop`.
        """
        await self.stop(abrupt=abrupt)
        if not keep_sessions and self._state is not None:
            self._state.forget()
        await self.start()

    def tick(self) -> None:
        """Run the work that is due; needed only with a manual clock."""
        deadlines = self.state.deadlines
        try:
            deadlines.run(self.state.clock.monotonic())
        finally:
            if deadlines.earliest is not None:
                self._wake_at(deadlines.earliest)

    def _wake_at(self, when: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        delay = max(0.0, when - self.state.clock.monotonic())
        self._timer = asyncio.get_running_loop().call_later(delay, self.tick)


def _call_soon(call: Callable[[], None]) -> None:
    asyncio.get_running_loop().call_soon(call)
