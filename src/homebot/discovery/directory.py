"""The node of the discovery layer: hears every gateway, keeps the index, publishes changes, and answers.

Sightings and reports are taken in as they come; the changes are published in portions soon after, each device
once.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TypeVar

import anyio
import anyio.lowlevel
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict, Field

from homebot.clock import SLICE
from homebot.devices import (
    DEVICE_CHANGES,
    DEVICE_STATES,
    DeviceChange,
    GatewayNames,
    Sighting,
    StateChange,
    gateway_of,
)
from homebot.devices.device import ChangedSettings
from homebot.devices.gateway_messages import Report
from homebot.devices.names import DEVICE_SETTINGS
from homebot.devices.services import IndexRow
from homebot.discovery.burst import Burst
from homebot.discovery.index import MAX_DEVICES, DeviceIndex
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.persistence import IndexPersistence
from homebot.discovery.services import DirectoryServices
from homebot.errors import TypeMismatchError
from homebot.graph import DurabilityPolicy, EndpointInfo, EntityKind, Node, QoSProfile, Subscription
from homebot.log import LogLimit, more_like_this
from homebot.support.isolation import isolated, run_as
from homebot.units import Seconds

__all__ = ["Directory", "DirectorySettings"]

APPEARED = "discovery.appeared"
CHANGED = "discovery.changed"
STALE = "discovery.stale"
RETURNED = "discovery.returned"
REMOVED = "discovery.removed"
MERGED = "discovery.merged"
UNMERGED = "discovery.unmerged"
CONFLICT = "discovery.conflict"
RESOLVED = "discovery.resolved"
REJECTED = "discovery.index_full"
NOT_FOLLOWED = "discovery.source_not_followed"
FOREIGN = "discovery.foreign_sighting"

BURST = 50
"""Lines of each kind of change in ten seconds; a flood of devices is counted rather than logged."""

_FEW = 25
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

_SOURCES_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_STATES_QOS = QoSProfile(depth=1)

MessageT = TypeVar("MessageT", Sighting, Report)


class DirectorySettings(BaseModel):
    """The table ``[discovery]``.

    Attributes:
        forget_after: Seconds for which a stale device stays listed before it is removed; a week by default, since many
            lamps say nothing for days.
        max_devices: How many devices are listed; further ones are counted and logged.
        persist: Whether devices are remembered in a file over a restart, where the program has a place for it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    forget_after: Seconds = Field(default=604_800.0)
    max_devices: int = Field(default=MAX_DEVICES, ge=1)
    persist: bool = True


class Directory:
    """Listens to the sightings and reports of every gateway, present and to come.

    It takes only messages of a gateway's own node, on that gateway's own topics; messages that
    another program publishes there are ignored.

    Args:
        node: The node that it is on the graph.
        settings: How long it remembers.
        file: Where it keeps the index over a restart; None for nowhere.
        owner: The owner's statements on devices in the configuration; by default none.
        needs_approval: Whether a device that can hurt waits for the owner's approval.
        known: The devices known at the start if it has no *file*.

    Attributes:
        index: The index of devices.
    """

    def __init__(
        self,
        node: Node,
        settings: DirectorySettings,
        file: Path | None = None,
        owner: OwnerFacts | None = None,
        *,
        needs_approval: bool = True,
        known: Sequence[IndexRow] = (),
    ) -> None:
        self._node = node
        clock = node.graph.clock
        # Microseconds: a directory that was restarted goes on above the numbers of the one before.
        self.index = DeviceIndex(
            forget_after=settings.forget_after,
            first_sequence=round(node.graph.steady_now() * 1e6) + 1,
            max_devices=settings.max_devices,
            owner=owner,
        )
        self.index.postings.needs_approval = needs_approval
        self._clock = clock
        self._changes = node.create_publisher(DeviceChange, DEVICE_CHANGES, 10)
        self._states = node.create_publisher(StateChange, DEVICE_STATES, _STATES_QOS)
        self._settings = node.create_publisher(ChangedSettings, DEVICE_SETTINGS, 10)
        self._persistence = IndexPersistence(node, self.index, file if settings.persist else None, known)
        self._services = DirectoryServices(node, self.index, self._persistence, self._publish_some)
        self._sources: dict[str, Subscription[Sighting] | Subscription[Report]] = {}
        self._wakes_at = math.inf
        self._rejected = 0
        self._earlier_deadline = anyio.Event()
        self._happened = asyncio.Event()  # cleared again and again, where anyio's would be made anew
        self._settings_changed = anyio.Event()
        self._growing = anyio.Event()
        self._burst = Burst(clock, lambda: self.index.announced, _quiet_turns)
        self._growth = Burst(clock, lambda: self.index.announced, partial(anyio.sleep, _GROWTH_PAUSE))
        self._is_idle = True
        self._limit = LogLimit(clock)
        self._change_limit = LogLimit(clock, burst=BURST)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Keep the index until cancelled.

        It answers as soon as it has taken in its file and the messages that gateways keep for late joiners, so that a
        client of a restarted directory does not see an empty house.
        """
        await self._persistence.load()
        with self._node.graph.watch() as changes:
            self._follow_all()
            self._services.register()
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._publish_changes)
                for work in (self._persistence.run, self._expire, self._publish_settings, self._publish_growth):
                    tasks.start_soon(run_as, self._node.full_name, work)
                task_status.started()
                lost = 0
                async for change in changes:
                    if changes.lost > lost:
                        lost = changes.lost
                        while changes.take() is not None:
                            pass
                        self._follow_all()
                    elif change.change == "added" and change.entity.kind is EntityKind.PUBLISHER:
                        self._follow(change.entity)

    def _follow_all(self) -> None:
        """Follow all topics, sightings first: a report of an unannounced device has no meaning."""
        endpoints = self._node.graph.get_endpoints(kind=EntityKind.PUBLISHER)
        for kind in (Sighting, Report):
            for endpoint in endpoints:
                if endpoint.ros_type == kind.ros_type:
                    self._follow(endpoint)

    def _follow(self, publisher: EndpointInfo) -> None:
        gateway = gateway_of(publisher.node)
        names = GatewayNames(gateway)
        if not gateway or publisher.name in self._sources:
            return
        if (publisher.name, publisher.ros_type) == (names.received_topics, Sighting.ros_type):
            self._listen(Sighting, publisher, partial(self._observe, gateway))
        elif (publisher.name, publisher.ros_type) == (names.readings, Report.ros_type):
            self._listen(Report, publisher, partial(self._report, gateway))

    def _listen(
        self, kind: type[MessageT], publisher: EndpointInfo, take: Callable[[float, Iterator[MessageT]], None]
    ) -> None:
        topic = publisher.name
        try:
            source = self._node.create_subscription(kind, topic, qos_profile=_SOURCES_QOS, from_node=publisher.node)
        except TypeMismatchError as exc:
            self._node.log.warning(NOT_FOLLOWED, message=str(exc), topic=topic)
            return
        self._sources[topic] = source
        take(math.inf, iter(source.take, None))
        self._node.create_task(partial(source.run_batches, partial(take, SLICE)))

    def _reject_foreign(self, gateway: str, message: Sighting | Report) -> None:
        """Log that *gateway* published in the name of another, which is not believed."""
        if self._limit.allows(FOREIGN) is not None:
            self._node.log.warning(
                FOREIGN,
                message=f"gateway {gateway} published {message.key[:100]!r} in the name of {message.gateway[:100]!r}; "
                "a gateway may publish only its own devices",
                gateway=gateway,
            )

    def _observe(self, gateway: str, slice_of: float, sightings: Iterator[Sighting]) -> None:
        """Take in *sightings* for *slice_of* seconds, or all."""
        monotonic = self._clock.monotonic
        now = monotonic()
        until = now + slice_of
        try:
            for sighting in sightings:
                if sighting.gateway == gateway:
                    self.index.observe(sighting, _heard_at(sighting, now))
                    if self.index.counters.rejected > self._rejected:
                        self._log_rejected(sighting)
                else:
                    self._reject_foreign(gateway, sighting)
                if (now := monotonic()) >= until:
                    break
        finally:
            if self.index.is_growing and not self._growing.is_set():
                self._growing.set()
            self._publish_or_wake()

    def _report(self, gateway: str, slice_of: float, reports: Iterator[Report]) -> None:
        """Take in *reports* for *slice_of* seconds, or all."""
        index, monotonic = self.index, self._clock.monotonic
        collects_settings = self._settings.subscription_count > 0
        index.collect(states=self._states.subscription_count > 0, settings=collects_settings)
        now = monotonic()
        until = now + slice_of
        try:
            for report in reports:
                if report.gateway == gateway:
                    index.report(report, _heard_at(report, now))
                else:
                    self._reject_foreign(gateway, report)
                if (now := monotonic()) >= until:
                    break
        finally:
            if collects_settings and index.settings and not self._settings_changed.is_set():
                self._settings_changed.set()
            self._publish_or_wake()

    def _publish_or_wake(self) -> None:
        """Publish the states of a few reports, as after nearly all; wake the tasks that have more to do now."""
        if self.index.has_states and not self.index.has_changes:
            self._publish_states(_FEW)
        if self._is_idle and self.index.is_behind:
            self._is_idle = False
            self._happened.set()
        if self.index.is_due_before(self._wakes_at):
            self._earlier_deadline.set()

    async def _publish_changes(self) -> None:
        """Publish changes, and sort them in for queries, while nothing else is to be done."""
        with isolated(self._node.full_name):
            while True:
                await self._happened.wait()
                self._happened.clear()
                self._is_idle = True
                is_busy = True
                while is_busy and self.index.is_behind:
                    await self._burst.wait(lambda: self.index.waiting_states >= _MANY_STATES)
                    is_busy = await self._publish_waiting()

    async def _publish_waiting(self) -> bool:
        """Publish the changes that wait now, or sort a few devices in; return whether more may be left."""
        for _ in range(self.index.waiting_changes // _FEW + 1):
            if not (self._publish_some(_FEW) or await self._sort_some()):
                return False
            await anyio.lowlevel.checkpoint()
        return True

    async def _sort_some(self) -> bool:
        """Make a few devices findable, unless more was heard, perhaps of them; return whether some are left.

        A query meanwhile makes all findable first; see :meth:`DeviceIndex.find`.
        """
        if self.index.is_sorted:  # as after most reports: a new value is found where the one before was
            return False
        await anyio.lowlevel.checkpoint()  # messages that the gateway is handling now come first
        return not self._happened.is_set() and self.index.sort(_FEW)

    async def _expire(self) -> None:
        while True:
            deadline = self.index.next_deadline()
            self._wakes_at = math.inf if deadline is None else deadline
            self._earlier_deadline = anyio.Event()
            with anyio.move_on_after(max(0.0, self._wakes_at - self._clock.monotonic())):
                await self._earlier_deadline.wait()
            while self.index.expire(self._clock.monotonic(), at_most=_FEW):
                while self._publish_some(_FEW):
                    await anyio.lowlevel.checkpoint()
                await anyio.lowlevel.checkpoint()

    async def _publish_growth(self) -> None:
        """Publish devices that were announced further once no more announcements come: each of them once."""
        while True:
            await self._growing.wait()
            await self._growth.wait()
            self._growing = anyio.Event()
            self.index.end_growth()
            self._publish_or_wake()

    async def _publish_settings(self) -> None:
        """Publish the settings that changed, twice a second: there is no hurry."""
        while True:
            await self._settings_changed.wait()
            await anyio.sleep(_SETTINGS_PAUSE)
            self._settings_changed = anyio.Event()
            changed = self.index.settings.pop()
            while some := tuple(islice(changed, _FEW)):
                self._settings.publish(ChangedSettings(changes=some))
                await anyio.lowlevel.checkpoint()

    def _publish_some(self, at_most: int) -> bool:
        """Publish so many changes and, after the last one, new states; return whether more may wait."""
        changes = self.index.pop_changes(at_most)
        for change in changes:
            self._services.remember(change)
            self._changes.publish(change)
            self._log(change)
        if len(changes) >= at_most:
            return True
        if not self.index.has_states:
            return False
        self._publish_states(at_most * _STATES_PER_CHANGE)
        return self.index.has_states

    def _publish_states(self, at_most: int) -> None:
        for state in self.index.pop_states(at_most):
            self._states.publish(state)

    def _log(self, change: DeviceChange) -> None:
        event, words = _WORDS[change.kind]
        held_back = self._change_limit.allows(event)
        if held_back is None:
            return
        device = change.device
        self._node.log.info(
            event,
            message=words.format(id=device.id, gateway=device.endpoints[0].gateway, why=change.why)
            + more_like_this(held_back),
            device=device.id,
            service_type=device.service_type,
            gateway=device.endpoints[0].gateway,
            why=change.why,
            other=change.other,
            held_back=held_back,
        )

    def _log_rejected(self, sighting: Sighting) -> None:
        self._rejected = self.index.counters.rejected
        if self._limit.allows(REJECTED) is not None:
            self._node.log.warning(
                REJECTED, message=f"{sighting.key} was not added: the index is full", rejected=self._rejected
            )


async def _quiet_turns() -> None:
    for _ in range(_QUIET_TURNS):
        await anyio.lowlevel.checkpoint()


def _heard_at(message: Sighting | Report, now: float) -> float:
    """Return when *message*, which is taken in *now*, was heard: one kept for late joiners may be old."""
    heard_at = message.heard_at
    return heard_at if heard_at and heard_at < now else now


_WORDS = {
    "appeared": (APPEARED, "found {id} on {gateway}: {why}"),
    "changed": (CHANGED, "{id} changed: {why}"),
    "stale": (STALE, "{id} is stale: {why}"),
    "returned": (RETURNED, "{id} is back: {why}"),
    "removed": (REMOVED, "{id} is gone: {why}"),
    "merged": (MERGED, "{id} was merged: {why}"),
    "unmerged": (UNMERGED, "{id} was split: {why}"),
    "conflict": (CONFLICT, "{id} is disputed: {why}"),
    "resolved": (RESOLVED, "{id} is no longer disputed: {why}"),
}
