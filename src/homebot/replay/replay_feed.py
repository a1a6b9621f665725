"""Feed of a replay: passes recorded messages to the gateways at their recorded times."""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Awaitable, Callable
from typing import Final, TypeAlias, final

import anyio

from homebot.clock import Clock
from homebot.devices.places_messages import OwnerRequest
from homebot.messages.message import Message
from homebot.recording.recording import Recording

__all__ = ["ReplayFeed", "Tell"]

_MOMENT: Final = 1e-6
"""Seconds within which messages are of one moment; the time of a line is given to this much."""

Tell: TypeAlias = Callable[[Message], Awaitable[None]]
"""Publishes a message as its gateway."""


@final
class ReplayFeed:
    """The messages of gateways in a recording, each at its time.

    Messages of one moment are published together, as a burst from the network is, unless a command or a statement of
    the owner was in between: later messages may be its effect. Messages at the moment of a timer come after the timer.

    Args:
        settle: Returns when everything has happened that is due now.
    """

    def __init__(self, recording: Recording, clock: Clock, settle: Callable[[], Awaitable[None]]) -> None:
        self._recording = recording
        self._clock = clock
        self._settle = settle
        self._began = clock.monotonic()
        self._gateways: dict[str, Tell] = {}

    @property
    def now(self) -> float:
        """Seconds since the start of the recording."""
        return self._clock.monotonic() - self._began

    async def open(self, gateway: str, tell: Tell) -> None:
        """Publish the messages of *gateway* before the recording, and from now on the recorded ones."""
        for message in self._recording.before:
            if _gateway(message) == gateway:
                await tell(message)
        self._gateways[gateway] = tell

    async def play(self, ask_directory: Callable[[OwnerRequest], Awaitable[None]]) -> None:
        """Publish all events, and call *ask_directory* with the owner's requests; return the end of the recording."""
        given = sorted(one.line for one in self._recording.commands)
        before, moment = 0, -math.inf
        for event in self._recording.events:
            is_effect = bisect(given, before) != bisect(given, event.line)
            is_asked = isinstance(event.message, OwnerRequest)
            if is_effect or is_asked or event.at - moment > _MOMENT:
                await self._wait_until(event.at)
                moment = event.at
            if isinstance(event.message, OwnerRequest):
                await ask_directory(event.message)
                moment = -math.inf
            else:
                await self._publish(event.message)
            before = event.line
        await self._wait_until(self._recording.ends_at)

    async def _publish(self, message: Message) -> None:
        if (tell := self._gateways.get(_gateway(message))) is not None:
            await tell(message)

    async def _wait_until(self, at: float) -> None:
        """Wait for a moment, and until everything has happened that is due then."""
        await anyio.sleep(max(0.0, at - self.now))
        await self._settle()


def _gateway(message: Message) -> str:
    return str(getattr(message, "gateway", ""))
