"""The publisher of changes in an index: devices in portions, states with them, settings twice a second."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping, Sized
from functools import partial
from itertools import islice
from operator import attrgetter
from typing import Final, final

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

BURST = 50
"""Most log lines per kind of change in ten seconds; the rest of a flood is counted."""

MAX_CHANGES_PER_TURN = 25
"""Changes published, or postings updated, per turn: about 1 ms of work, and as many as the MQTT gateway announces per
turn."""

_STATES_PER_CHANGE = 10
"""States that are published in about the time of one change."""

_GROWTH_PAUSE = 0.1
"""Seconds without an announcement after which devices count as complete: programs announce a device in up to a hundred
messages, and a broker interleaves those of all devices."""

_QUIET_TURNS = 10
"""Turns of the loop without an announcement that end a burst: a gateway that reads one makes an announcement in every
third turn."""

_MANY_STATES = 1000
"""Most states that wait behind the changes of a burst."""

_SETTINGS_PAUSE = 0.5
"""Seconds for which changed settings are collected; together they cost a busy house next to nothing."""

_MAX_BURST_S: Final = 10.0
"""First limit, in seconds, of the wait for the end of a burst: 4,000 devices take about that long to announce."""

_MAX_AGAIN: Final = 60.0
"""Limit up to which the wait doubles in a long burst, as describing devices is expensive on slow computers."""

_WAITING_PER_SECOND: Final = 50
"""Waiting devices per second of waiting, up to that limit: describing a large house during a burst takes seconds, and
has to be repeated at its end."""

_STATES_QOS = QoSProfile(depth=1)


@final
class Burst:
    """The wait for the end of a burst of announcements, so that a house is described once, not per message.

    Args:
        announced: Returns the number of announcements so far.
        pause: Waits for the time without an announcement after which a burst is over.
    """

    def __init__(
        self,
        clock: Clock,
        announced: Callable[[], int],
        pause: Callable[[], Awaitable[object]],
        waiting: Callable[[], Sized] = tuple,
    ) -> None:
        self._clock = clock
        self._announced = announced
        self._pause = pause
        self._waiting = waiting
        self._seen = 0
        self._longest = _MAX_BURST_S

    async def wait(self, is_urgent: Callable[[], bool] = lambda: False) -> None:
        """Wait while announcements keep coming, unless *is_urgent*; return at once if there were none."""
        began = self._clock.monotonic()
        while (announced := self._announced()) != self._seen:
            if is_urgent():
                return
            waited = self._clock.monotonic() - began
            if waited >= self._longest and waited >= min(len(self._waiting()) / _WAITING_PER_SECOND, _MAX_AGAIN):
                self._longest = min(2 * self._longest, _MAX_AGAIN)
                return
            self._seen = announced
            await self._pause()
        self._longest = _MAX_BURST_S


@final
class ChangePublisher:
    """Publishes an index: states at once; changes of devices after a burst of announcements, each device once."""

    def __init__(self, node: Node, index: DeviceIndex) -> None:
        clock = node.graph.clock
        self._node = node
        self._index = index
        self._queue = index.changes
        self._changes = node.create_publisher(DeviceChange, DEVICE_CHANGES, 10)
        self._states = node.create_publisher(StateChange, DEVICE_STATES, _STATES_QOS)
        self._settings = node.create_publisher(ChangedSettings, DEVICE_SETTINGS, 10)
        self._is_idle = True
        self._happened = asyncio.Event()  # can be cleared, unlike anyio's
        self._growing = asyncio.Event()
        self._settings_changed = asyncio.Event()
        announced = partial(attrgetter("announced"), self._queue)
        self._burst = Burst(clock, announced, _quiet_turns, lambda: self._queue.pending)
        self._growth = Burst(clock, announced, partial(anyio.sleep, _GROWTH_PAUSE), lambda: self._queue.growing)
        self._limit = LogLimit(clock, burst=BURST)

    def collect(self) -> None:
        """Collect changed states and settings if there are subscribers."""
        self._queue.collects_states = self._states.subscription_count > 0
        self._queue.collects_settings = self._settings.subscription_count > 0

    def wake(self) -> None:
        """Publish the states of a few reports, which is nearly always all; wake the tasks with more to do."""
        queue = self._queue
        if queue.states and not queue.pending:
            self._publish_states(MAX_CHANGES_PER_TURN)
        if self._is_idle and (queue.pending or queue.states or self._index.table.outdated):
            self._is_idle = False
            self._happened.set()
        if queue.growing:
            self._growing.set()
        if self._index.settings.waiting:
            self._settings_changed.set()

    async def publish_changes(self) -> None:
        """Publish changes, and update postings while there is nothing else to do."""
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
        """Publish each device with further announcements once when no more arrive."""
        while True:
            await self._growing.wait()
            await self._growth.wait()
            self._growing.clear()
            self._queue.end_growth()
            self.wake()

    async def publish_settings(self) -> None:
        """Publish changed settings twice a second."""
        while True:
            await self._settings_changed.wait()
            await anyio.sleep(_SETTINGS_PAUSE)
            self._settings_changed.clear()
            changed = self._index.settings.pop()
            while some := tuple(islice(changed, MAX_CHANGES_PER_TURN)):
                self._settings.publish(ChangedSettings(changes=some))
                await anyio.lowlevel.checkpoint()

    def publish_some(self, at_most: int) -> bool:
        """Publish up to *at_most* changes and, after the last one, new states; return whether more may wait."""
        queue = self._queue
        changes = queue.pop(at_most)
        for change in changes:
            self._changes.publish(change)
            if change.sequence not in queue.of_links:  # one log line covers all devices of a link
                self._log(change)
        if len(changes) >= at_most:
            return True
        if not queue.states:
            return False
        self._publish_states(at_most * _STATES_PER_CHANGE)
        return bool(queue.states)

    async def _publish_waiting(self) -> bool:
        """Publish the waiting changes, or update a few postings; return whether more may be left.

        A query in the meantime updates all postings first; see :meth:`DeviceIndex.find`.
        """
        for _ in range(len(self._queue.pending) // MAX_CHANGES_PER_TURN + 1):
            if not self.publish_some(MAX_CHANGES_PER_TURN):
                if not self._index.table.outdated:  # usual for reports: a new value keeps its posting
                    return False
                await anyio.lowlevel.checkpoint()  # messages that the gateway is handling come first
                if self._happened.is_set() or not self._index.sort(MAX_CHANGES_PER_TURN):
                    return False
            await anyio.lowlevel.checkpoint()
        return True

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
        message = _WORDS[change.kind].format(id=device.id, gateway=gateway, why=change.why)
        self._node.log.info(
            event,
            message=message + more_like_this(held_back) if held_back else message,
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
