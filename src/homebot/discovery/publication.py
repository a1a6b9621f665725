"""Publication of the changes in an index: of devices in portions, of states with them, of settings twice a second."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping, Sized
from functools import partial
from itertools import islice
from typing import Final, Protocol, final

import anyio
import anyio.lowlevel

from homebot.clock import Clock
from homebot.devices import DEVICE_CHANGES, DEVICE_STATES, DeviceChange, StateChange
from homebot.devices.device import ChangedSettings, ChangeKind
from homebot.devices.names import DEVICE_SETTINGS
from homebot.discovery.index import DeviceIndex
from homebot.graph import Node, QoSProfile
from homebot.log import LogLimit, more_like_this
from homebot.support.isolation import isolated

__all__ = ["Burst", "ChangePublisher"]

BURST = 50
"""Lines of each kind of change in ten seconds; a flood of devices is counted rather than logged."""

FEW = 25
"""Changes published, and devices made findable, between two turns of all others: some 1 ms of work, as many as the MQTT
gateway announces in one of its own."""

_STATES_PER_CHANGE = 10
"""States that are published in the time of one change, about."""

_GROWTH_PAUSE = 0.1
"""Seconds without an announcement after which devices have grown: programs announce a device in up to a hundred
messages, and a broker sends those of all devices mixed."""

_QUIET_TURNS = 10
"""Turns of the loop without an announcement after which a burst of them is over: a gateway that reads one announces
something in every third."""

_MANY_STATES = 1000
"""States that wait behind the changes of a burst at most."""

_SETTINGS_PAUSE = 0.5
"""Seconds in which changed settings are gathered: to look at them together costs a busy house next to nothing."""

_LONGEST: Final = 10.0
"""Seconds for which the end of a burst is waited for at first: 4,000 devices announce themselves in about as many."""

_LONGEST_AGAIN: Final = 60.0
"""The same in a burst that goes on: the wait doubles up to this, as on a slow computer each description is dear."""

_WAITING_PER_SECOND: Final = 50
"""Devices that wait for each second in which the end of a burst is waited for, up to that: to describe a large house in
the midst of it takes seconds, and each device is described again at the end."""

_STATES_QOS = QoSProfile(depth=1)


class AnnouncementCounter(Protocol):
    """A counter of announcements."""

    @property
    def announced(self) -> int:
        """The number of announcements so far."""
        ...


@final
class Burst:
    """Wait for the end of a burst of announcements: a house that comes at once is described once, not per message.

    Args:
        pause: Waits for the time without an announcement after which a burst is over.
    """

    def __init__(
        self,
        clock: Clock,
        counter: AnnouncementCounter,
        pause: Callable[[], Awaitable[object]],
        waiting: Callable[[], Sized] = tuple,
    ) -> None:
        self._clock = clock
        self._counter = counter
        self._pause = pause
        self._waiting = waiting
        self._seen = 0
        self._longest = _LONGEST

    async def wait(self, is_urgent: Callable[[], bool] = lambda: False) -> None:
        """Wait while announcements keep coming, unless that *is_urgent*; return at once if none came since."""
        began = self._clock.monotonic()
        while (announced := self._counter.announced) != self._seen:
            if is_urgent():
                return
            waited = self._clock.monotonic() - began
            if waited >= self._longest and waited >= min(len(self._waiting()) / _WAITING_PER_SECOND, _LONGEST_AGAIN):
                self._longest = min(2 * self._longest, _LONGEST_AGAIN)
                return
            self._seen = announced
            await self._pause()
        self._longest = _LONGEST


@final
class ChangePublisher:
    """Publisher of an index: changes soon after a burst of announcements, each device once; states at once."""

    def __init__(self, node: Node, index: DeviceIndex) -> None:
        clock = node.graph.clock
        self._node = node
        self._index = index
        self._queue = index.changes
        self._changes = node.create_publisher(DeviceChange, DEVICE_CHANGES, 10)
        self._states = node.create_publisher(StateChange, DEVICE_STATES, _STATES_QOS)
        self._settings = node.create_publisher(ChangedSettings, DEVICE_SETTINGS, 10)
        self._is_idle = True
        self._happened = asyncio.Event()  # cleared again and again, where anyio's would be made anew
        self._growing = asyncio.Event()
        self._settings_changed = asyncio.Event()
        self._burst = Burst(clock, self._queue, _quiet_turns, lambda: self._queue.pending)
        self._growth = Burst(clock, self._queue, partial(anyio.sleep, _GROWTH_PAUSE), lambda: self._queue.growing)
        self._limit = LogLimit(clock, burst=BURST)

    def collect(self) -> None:
        """Collect changed states and settings from now on if there are subscribers."""
        self._queue.collects_states = self._states.subscription_count > 0
        self._queue.collects_settings = self._settings.subscription_count > 0

    def wake(self) -> None:
        """Publish the states of a few reports, as after nearly all; wake the tasks that have more to do now."""
        queue = self._queue
        if queue.states and not queue.pending:
            self._publish_states(FEW)
        if self._is_idle and (queue.pending or queue.states or self._index.table.outdated):
            self._is_idle = False
            self._happened.set()
        if queue.growing:
            self._growing.set()
        if self._index.settings.waiting:
            self._settings_changed.set()

    async def publish_changes(self) -> None:
        """Publish changes, and sort them in for queries, while nothing else is to be done."""
        with isolated(self._node.full_name):
            while True:
                await self._happened.wait()
                self._happened.clear()
                self._is_idle = True
                is_busy = True
                while is_busy and (self._queue.pending or self._queue.states or self._index.table.outdated):
                    await self._burst.wait(lambda: len(self._queue.states) >= _MANY_STATES)
                    is_busy = await self._publish_waiting()

    async def publish_growth(self) -> None:
        """Publish devices that were announced further once no more announcements come: each of them once."""
        while True:
            await self._growing.wait()
            await self._growth.wait()
            self._growing.clear()
            self._queue.end_growth()
            self.wake()

    async def publish_settings(self) -> None:
        """Publish the settings that changed, twice a second: there is no hurry."""
        while True:
            await self._settings_changed.wait()
            await anyio.sleep(_SETTINGS_PAUSE)
            self._settings_changed.clear()
            changed = self._index.settings.pop()
            while some := tuple(islice(changed, FEW)):
                self._settings.publish(ChangedSettings(changes=some))
                await anyio.lowlevel.checkpoint()

    def publish_some(self, at_most: int) -> bool:
        """Publish so many changes and, after the last one, new states; return whether more may wait."""
        queue = self._queue
        changes = queue.pop(at_most)
        for change in changes:
            self._changes.publish(change)
            if change.sequence not in queue.of_links:  # one line tells of all devices of a link
                self._log(change)
        if len(changes) >= at_most:
            return True
        if not queue.states:
            return False
        self._publish_states(at_most * _STATES_PER_CHANGE)
        return bool(queue.states)

    async def _publish_waiting(self) -> bool:
        """Publish the changes that wait now, or sort a few devices in; return whether more may be left."""
        for _ in range(len(self._queue.pending) // FEW + 1):
            if not (self.publish_some(FEW) or await self._sort_some()):
                return False
            await anyio.lowlevel.checkpoint()
        return True

    async def _sort_some(self) -> bool:
        """Make a few devices findable, unless more was heard, perhaps of them; return whether some are left.

        A query meanwhile makes all findable first; see :meth:`DeviceIndex.find`.
        """
        if not self._index.table.outdated:  # as after most reports: a new value is found where the one before was
            return False
        await anyio.lowlevel.checkpoint()  # messages that the gateway is handling now come first
        return not self._happened.is_set() and self._index.sort(FEW)

    def _publish_states(self, at_most: int) -> None:
        for state in self._queue.pop_states(at_most):
            self._states.publish(state)

    def _log(self, change: DeviceChange) -> None:
        event = f"discovery.{change.kind}"
        held_back = self._limit.allows(event)
        if held_back is None:
            return
        device = change.device
        gateway = device.endpoints[0].gateway
        self._node.log.info(
            event,
            message=_WORDS[change.kind].format(id=device.id, gateway=gateway, why=change.why)
            + more_like_this(held_back),
            device=device.id,
            service_type=device.service_type,
            gateway=gateway,
            why=change.why,
            other=change.other,
            held_back=held_back,
        )


async def _quiet_turns() -> None:
    """Wait for ten turns of the loop by a chain of callbacks: to resume a task in each would take far longer."""
    is_over = asyncio.Event()
    step: Callable[[], object] = is_over.set
    for _ in range(_QUIET_TURNS):
        step = partial(asyncio.get_running_loop().call_soon, step)
    step()
    await is_over.wait()


_WORDS: Final[Mapping[ChangeKind, str]] = {
    "appeared": "found {id} on {gateway}: {why}",
    "changed": "{id} changed: {why}",
    "stale": "{id} is stale: {why}",
    "returned": "{id} is back: {why}",
    "removed": "{id} is gone: {why}",
    "merged": "{id} was merged: {why}",
    "unmerged": "{id} was split: {why}",
    "conflict": "{id} is disputed: {why}",
    "resolved": "{id} is no longer disputed: {why}",
}
