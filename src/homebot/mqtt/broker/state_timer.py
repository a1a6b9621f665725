"""Wakes a hub when one of its deadlines is due."""

from __future__ import annotations

import asyncio
from typing import final

from homebot.mqtt.broker.state import BrokerState

__all__ = ["HubTimer"]


@final
class HubTimer:
    """One timer of the running event loop, always set to the hub's earliest deadline; works from :meth:`start` on."""

    def __init__(self, hub: BrokerState) -> None:
        self._hub = hub
        self._timer: asyncio.TimerHandle | None = None

    def start(self) -> None:
        """Do what became due meanwhile, and wait for the next."""
        self._hub.deadlines.wake = self._wake_at
        self.tick()

    def tick(self) -> None:
        """Do what is due by the hub's clock."""
        hub = self._hub
        try:
            hub.deadlines.run(hub.clock.monotonic())
        finally:
            earliest = hub.deadlines.earliest
            if earliest is not None:
                self._wake_at(earliest)

    def stop(self) -> None:
        """Wake the hub no more."""
        self._hub.deadlines.wake = None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _wake_at(self, when: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        delay = max(0.0, when - self._hub.clock.monotonic())
        self._timer = asyncio.get_running_loop().call_later(delay, self.tick)
