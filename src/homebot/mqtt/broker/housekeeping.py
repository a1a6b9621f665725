"""Chores of a broker on sockets, every few seconds."""

from __future__ import annotations

import asyncio
from typing import Final, final

from homebot.mqtt.broker.losses import LossReport
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.memory import MemoryKeeper

__all__ = ["Housekeeping"]

_EVERY: Final = 10.0
_MESSAGES: Final = 1000  # so many may have held memory worth to be given back


@final
class Housekeeping:
    """A timer of the running loop, from :meth:`start` to :meth:`stop`."""

    def __init__(self, hub: BrokerState) -> None:
        self._hub = hub
        self._losses = LossReport(hub.counters)
        self._memory = MemoryKeeper()
        self._timer: asyncio.TimerHandle | None = None

    @property
    def losses(self) -> str:
        """Losses of the last ten minutes, as text."""
        return self._losses.lately

    def start(self) -> None:
        """Begin."""
        self._timer = asyncio.get_running_loop().call_later(_EVERY, self._run)

    def stop(self) -> None:
        """End."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _run(self) -> None:
        counters = self._hub.counters
        if lost := self._losses.take():
            self._hub.warn("broker.dropped", f"the broker dropped {lost} in the last {_EVERY:g} s")
        self._memory.look(counters.connections_closed + counters.messages_received // _MESSAGES)
        self.start()
