"""The node of the discovery layer, which follows all gateways, maintains the index, and forgets silent devices."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import anyio
import anyio.lowlevel
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict, Field

from homebot.clock import SLICE, TimeSlice
from homebot.devices import GatewayNames, GatewayState, Sighting, gateway_of
from homebot.devices.approval_messages import ApprovedCommands
from homebot.devices.gateway_messages import Report
from homebot.devices.names import APPROVED_COMMANDS
from homebot.devices.services import IndexRow
from homebot.discovery.house_rooms import HouseRooms
from homebot.discovery.index import MAX_DEVICES, DeviceIndex
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.persistence import IndexPersistence
from homebot.discovery.publication import MAX_CHANGES_PER_TURN, ChangePublisher
from homebot.discovery.services import DirectoryServices
from homebot.discovery.source_record import LostLink
from homebot.errors import TypeMismatchError
from homebot.graph import (
    DurabilityPolicy,
    EndpointInfo,
    EntityKind,
    Node,
    QoSProfile,
    Subscription,
    qos_profile_latched,
)
from homebot.log import LogLimit, more_like_this
from homebot.messages import Time
from homebot.places import Places
from homebot.support.isolation import run_as
from homebot.units import Seconds

if TYPE_CHECKING:
    from homebot.discovery.reading_limits import LimitsOfDevices

REJECTED = "discovery.index_full"
NOT_FOLLOWED = "discovery.source_not_followed"
FOREIGN = "discovery.foreign_sighting"
LINK_LOST = "discovery.link_lost"
LINK_BACK = "discovery.link_back"

_SOURCES_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

MessageT = TypeVar("MessageT", Sighting, Report)
SourceT = TypeVar("SourceT", Sighting, Report, GatewayState)


class DirectorySettings(BaseModel):
    """The table ``[discovery]``.

    Attributes:
        forget_after: Seconds for which a stale device stays listed before it is removed; a week by default, since many
            lamps are silent for days.
        max_devices: Most listed devices; further ones are counted and logged.
        persist: Whether devices are remembered in a file across restarts.
        prefer: Names of gateways, best first: the order in which they get commands for a device that several can
            reach. Other gateways come last, in the usual order.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    forget_after: Seconds = Field(default=604_800.0)
    max_devices: int = Field(default=MAX_DEVICES, ge=1)
    persist: bool = True
    prefer: tuple[str, ...] = ()


class Directory:
    """Subscribes to the sightings and reports of all gateways, present and future.

    Messages on the topics of a gateway count only if its own node publishes them.

    Args:
        file: The file that keeps the index across restarts; None for none.
        known: The devices known at the start without a *file*.
    """

    def __init__(
        self,
        node: Node,
        settings: DirectorySettings,
        file: Path | None = None,
        owner: OwnerFacts | None = None,
        *,
        needs_approval: bool = True,
        limits: LimitsOfDevices | None = None,
        known: Sequence[IndexRow] = (),
    ) -> None:
        self._node = node
        # Microseconds, so that numbers keep growing across restarts.
        self.index = DeviceIndex(
            forget_after=settings.forget_after,
            first_sequence=round(node.graph.steady_now() * 1e6) + 1,
            max_devices=settings.max_devices,
            owner=owner,
        )
        self.index.owner.prefer = settings.prefer
        self.index.postings.needs_approval = needs_approval
        self.index.table.limits = limits
        self._clock = node.graph.clock
        self._publisher = ChangePublisher(node, self.index)
        self._persistence = IndexPersistence(node, self.index, file if settings.persist else None, known)
        self._services = DirectoryServices(node, self.index, self._persistence, self._publisher.publish_some)
        self._approved = node.create_publisher(ApprovedCommands, APPROVED_COMMANDS, qos_profile_latched)
        self._sources: set[str] = set()
        self._wakes_at = math.inf
        self._rejected = 0
        self._earlier_deadline = anyio.Event()
        self._limit = LogLimit(self._clock)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Keep the index until cancelled.

        It answers once it has read its file and the messages that gateways keep for late joiners, so that clients of a
        restarted directory do not see an empty house.
        """
        await self._persistence.load()
        self._publish_approvals()
        self.index.owner.approvals.on_change = self._publish_approvals
        with self._node.graph.watch() as changes:
            self._follow_all()
            self._services.register()
            async with anyio.create_task_group() as tasks:
                publisher = self._publisher
                tasks.start_soon(publisher.publish_changes)
                for work in (self._persistence.run, self._expire, publisher.publish_settings, publisher.publish_growth):
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

    def _publish_approvals(self) -> None:
        self._approved.publish(ApprovedCommands(digests=self.index.owner.approvals.digests))

    def owner_record(self, feature: str) -> str:
        """Return the record of the owner for a feature, as :meth:`save_record` saved it; empty for none."""
        return self._persistence.record_for(feature).text

    async def save_record(self, feature: str, record: str, *, at_once: bool) -> str:
        """Save a record of the owner for a feature; return why it could not be saved at once, empty if it was."""
        kept = self._persistence.record_for(feature)
        kept.text, kept.is_unsaved = record, True
        return await self._persistence.save_now() if at_once else ""

    async def reconfigure(self, places: Places, rooms: HouseRooms) -> None:
        """Replace the statements of the configuration on rooms and devices."""
        await TimeSlice(self._clock).do(self.index.places_exchange.reconfigure(places, rooms, self._clock.now()))
        while self._publisher.publish_some(MAX_CHANGES_PER_TURN):
            await anyio.lowlevel.checkpoint()

    def _follow_all(self) -> None:
        """Follow all topics, sightings first: the report of an unannounced device means nothing."""
        endpoints = self._node.graph.get_endpoints(kind=EntityKind.PUBLISHER)
        for kind in (Sighting, Report, GatewayState):
            for endpoint in endpoints:
                if endpoint.ros_type == kind.ros_type:
                    self._follow(endpoint)

    def _follow(self, publisher: EndpointInfo) -> None:
        gateway = gateway_of(publisher.node)
        names = GatewayNames(gateway)
        if not gateway or publisher.name in self._sources:
            return
        match publisher.name, publisher.ros_type:
            case names.received_topics, Sighting.ros_type:
                self._listen(Sighting, publisher, partial(self._ingest, gateway, self.index.observe))
            case names.readings, Report.ros_type:
                self._listen(Report, publisher, partial(self._ingest, gateway, self.index.report))
            case names.state, GatewayState.ros_type:
                if (states := self._subscribe(GatewayState, publisher)) is not None:
                    self._node.create_task(partial(self._follow_link, gateway, states))

    def _listen(
        self, kind: type[MessageT], publisher: EndpointInfo, take: Callable[[float, Iterator[MessageT]], None]
    ) -> None:
        if (source := self._subscribe(kind, publisher)) is not None:
            take(math.inf, iter(source.take, None))
            self._node.create_task(partial(source.run_batches, partial(take, SLICE)))

    def _subscribe(self, kind: type[SourceT], publisher: EndpointInfo) -> Subscription[SourceT] | None:
        topic = publisher.name
        try:
            source = self._node.create_subscription(kind, topic, qos_profile=_SOURCES_QOS, from_node=publisher.node)
        except TypeMismatchError as exc:
            self._node.log.warning(NOT_FOLLOWED, message=str(exc), topic=topic)
            return None
        self._sources.add(topic)
        return source

    async def _follow_link(self, gateway: str, states: Subscription[GatewayState]) -> None:
        async for state in states:
            is_lost = state.state == "unavailable"
            why = f"{gateway} is unavailable: {state.reason}"
            lost = LostLink(Time.from_seconds(self._clock.now()), why) if is_lost else None
            self._publisher.collect()
            if count := await TimeSlice(self._clock).do(self.index.record_link(gateway, lost)):
                self._log_link(gateway, lost, count)
            self._publisher.wake()

    def _log_link(self, gateway: str, lost: LostLink | None, count: int) -> None:
        event = LINK_LOST if lost else LINK_BACK
        if (held_back := self._limit.allows(event)) is None:
            return
        devices = "1 device" if count == 1 else f"{count} devices"
        message = f"{devices} cannot be reached: {lost.why}" if lost else f"{gateway} reaches {devices} again"
        self._node.log.info(
            event, message=message + more_like_this(held_back), gateway=gateway, devices=count, held_back=held_back
        )

    def _ingest(
        self,
        gateway: str,
        ingest: Callable[[MessageT, float], None],
        slice_of: float,
        messages: Iterator[MessageT],
    ) -> None:
        """Pass *messages* of *gateway* to *ingest* for *slice_of* seconds, or all; one kept for late joiners is old."""
        monotonic, counters = self._clock.monotonic, self.index.counters
        now = monotonic()
        until = now + slice_of
        self._publisher.collect()
        try:
            for message in messages:
                if message.gateway == gateway:
                    heard_at = message.heard_at
                    ingest(message, heard_at if heard_at and heard_at < now else now)
                    if counters.rejected > self._rejected:
                        self._rejected = self.index.counters.rejected
                        if self._limit.allows(REJECTED) is not None:
                            self._node.log.warning(
                                REJECTED,
                                message=f"{message.key} was not added: the index is full",
                                rejected=self._rejected,
                            )
                else:
                    if self._limit.allows(FOREIGN) is not None:
                        self._node.log.warning(
                            FOREIGN,
                            message=f"gateway {gateway} published {message.key[:100]!r} in the name of "
                            f"{message.gateway[:100]!r}; a gateway may publish only its own devices",
                            gateway=gateway,
                        )
                if (now := monotonic()) >= until:
                    break
        finally:
            self._publisher.wake()
            if self.index.deadlines.earliest < self._wakes_at:
                self._earlier_deadline.set()

    async def _expire(self) -> None:
        while True:
            deadline = self.index.next_deadline()
            self._wakes_at = math.inf if deadline is None else deadline
            self._earlier_deadline = anyio.Event()
            with anyio.move_on_after(max(0.0, self._wakes_at - self._clock.monotonic())):
                await self._earlier_deadline.wait()
            while self.index.expire(self._clock.monotonic(), at_most=MAX_CHANGES_PER_TURN):
                while self._publisher.publish_some(MAX_CHANGES_PER_TURN):
                    await anyio.lowlevel.checkpoint()
                await anyio.lowlevel.checkpoint()
