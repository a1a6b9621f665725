"""Services of the directory."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import cached_property
from typing import TYPE_CHECKING

import anyio.lowlevel

import homebot.places
from homebot.devices import (
    FIND_DEVICES,
    GET_CHANGES,
    GET_INDEX_DATA,
    QUERY_DEVICES,
    FindDevices,
    Found,
    GetChanges,
    GetIndexData,
    QueryDevices,
)
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.devices.names import DISCOVERY_HEALTH, EXPORT_INDEX, FORGET_DEVICE, MERGE_DEVICES, SPLIT_DEVICE
from homebot.devices.query import And, IsNear, Query, asks_for_near, read_terms, split_near, type_is
from homebot.devices.services import (
    AnnouncedOn,
    ExportIndex,
    ExportIndexRequest,
    ExportIndexResponse,
    FindDevicesRequest,
    FindDevicesResponse,
    ForgetDevice,
    ForgetDeviceRequest,
    ForgetDeviceResponse,
    GetChangesRequest,
    GetChangesResponse,
    GetIndexDataRequest,
    GetIndexDataResponse,
    IndexEntry,
    MergeDevices,
    MergeDevicesRequest,
    MergeDevicesResponse,
    QueryDevicesRequest,
    QueryDevicesResponse,
    SplitDevice,
    SplitDeviceRequest,
    SplitDeviceResponse,
)
from homebot.discovery.index import DeviceIndex
from homebot.discovery.owner_requests import OwnerRequests
from homebot.discovery.persistence import IndexPersistence
from homebot.discovery.places_services import PlacesServices
from homebot.errors import RefusedError, UsageError
from homebot.graph import Node
from homebot.messages.key_value import KeyValue

if TYPE_CHECKING:
    from homebot.discovery.nearness import Nearness

__all__ = ["DirectoryServices"]


_FEW = 10
"""Changes published, and devices made findable, before others get their turn."""

_MOST_TURNS = 1000
"""Turns that others get before an answer, so that none waits for a flood to end."""


class DirectoryServices:
    """The services of the directory.

    Args:
        node: The directory's node.
        index: The index of devices.
        persistence: The index file.
        publish: Publishes so many of the changes that wait, so that an answer holds nothing that is published after
            it; says whether there may be more.
    """

    def __init__(
        self, node: Node, index: DeviceIndex, persistence: IndexPersistence, publish: Callable[[int], bool]
    ) -> None:
        self._clock = node.graph.clock
        self._index = index
        self._persistence = persistence
        self._publish_some = publish
        self._node = node

    def register(self) -> None:
        """Begin to answer."""
        node, owner = self._node, OwnerRequests(self._node)
        node.create_service(GetIndexData, GET_INDEX_DATA, self._get_index_data)
        node.create_service(FindDevices, FIND_DEVICES, self._find_devices)
        node.create_service(QueryDevices, QUERY_DEVICES, self._query)
        node.create_service(GetChanges, GET_CHANGES, self._get_changes)
        owner.serve(ForgetDevice, FORGET_DEVICE, self._forget)
        owner.serve(SplitDevice, SPLIT_DEVICE, self._split)
        owner.serve(MergeDevices, MERGE_DEVICES, self._merge)
        node.create_service(ExportIndex, EXPORT_INDEX, self._export_index)
        node.create_service(GetHealth, DISCOVERY_HEALTH, self._get_health)
        PlacesServices(self._clock, self._index, self._publish_all).register(node, owner)

    async def _get_index_data(self, request: GetIndexDataRequest) -> GetIndexDataResponse:
        await self._catch_up()
        devices = self._index.devices(request.service_type)
        return GetIndexDataResponse(
            entries=tuple(
                IndexEntry(gateway=gateway, topic=topic, device_id=device.id)
                for device in devices
                for gateway, topic in dict.fromkeys((one.gateway, one.address) for one in device.endpoints)
            ),
            topics=tuple(device.endpoints[0].address for device in devices),
            device_ids=tuple(device.id for device in devices),
        )

    def _find_devices(self, request: FindDevicesRequest) -> FindDevicesResponse | Awaitable[FindDevicesResponse]:
        return self._find_later(request) if self._index.is_behind else self._found(request)

    async def _find_later(self, request: FindDevicesRequest) -> FindDevicesResponse:
        await self._catch_up()
        return self._found(request)

    def _found(self, request: FindDevicesRequest) -> FindDevicesResponse:
        is_by_id = request.ids and not request.query and not request.service_type
        devices = []
        for device_id in sorted(set(request.ids)) if is_by_id else self._matching(request):
            device = self._index.get(device_id)
            if device is not None:  # else it is named, but unknown
                devices.append(device)
        return FindDevicesResponse(devices=tuple(devices), sequence=self._index.changes.sequence)

    def _matching(self, request: FindDevicesRequest) -> list[str]:
        """Return the ids of the devices that match *request*, sorted."""
        query = read_terms(request.query)
        if request.service_type:
            query = And((type_is(request.service_type), query))
        if request.is_checked:
            self._check_words(query)
        found = self._near_devices(query) if asks_for_near(request.query) else self._index.find(query)
        return sorted(found.intersection(request.ids) if request.ids else found)

    def _near_devices(self, query: Query) -> set[str]:
        near, rest = split_near(query)
        found = self._index.find(rest)
        return {one.device for one in self._nearness.find(near, rest, found).found} if near is not None else set(found)

    async def _query(self, request: QueryDevicesRequest) -> QueryDevicesResponse:
        from homebot.discovery.search.rank import rank, reasons  # noqa: PLC0415 - for searches alone

        await self._catch_up()
        try:
            query = read_terms(request.query)
            self._check_words(query)
            near, rest = split_near(query)
            if near is not None:
                return self._near(request, near, rest)
        except (RefusedError, UsageError) as exc:
            is_mistake = isinstance(exc, UsageError)
            reason = exc.reason if isinstance(exc, RefusedError) else str(exc)
            return QueryDevicesResponse(
                success=False, message=reason, sequence=self._index.sequence, is_mistake=is_mistake
            )
        found = self._index.find(query)
        ranked = rank(query, found, self._index.postings)
        shown = ranked[request.offset :][: request.limit or None]
        results = (
            Found(device=device, score=score, reasons=reasons(query, one, self._index.postings))
            for score, one in shown
            if (device := self._index.get(one)) is not None
        )
        return QueryDevicesResponse(
            success=True, results=tuple(results), total=len(ranked), sequence=self._index.sequence
        )

    def _near(self, request: QueryDevicesRequest, near: IsNear, rest: Query) -> QueryDevicesResponse:
        """Return the devices near a robot, best first.

        Raises:
            RefusedError: The place of the robot is not known now.
            UsageError: There is no such robot.
        """
        from homebot.discovery.search.rank import reasons  # noqa: PLC0415 - for searches alone

        index, nearness = self._index, self._nearness
        found = index.find(rest)
        answer = nearness.find(near, rest, found, request.offset + request.limit if request.limit else 0)
        results = (
            Found(
                device=device,
                score=-one.cost,
                reasons=(answer.why(one, nearness), *reasons(rest, one.device, index.postings)),
            )
            for one in answer.found[request.offset :]
            if (device := index.get(one.device)) is not None
        )
        return QueryDevicesResponse(
            success=True,
            message=answer.text,
            results=tuple(results),
            total=answer.total,
            sequence=index.sequence,
            pose_age=answer.age,
            left_out=tuple(KeyValue(key=key, value=reason) for key, reason in answer.left_out),
        )

    @cached_property
    def _nearness(self) -> Nearness:
        from homebot.discovery.nearness import Nearness  # noqa: PLC0415 - with the first query for what is near

        return Nearness(self._node, self._index)

    def _check_words(self, query: Query) -> None:
        """Check that *query* has no misspelt word.

        Raises:
            UsageError: It has; says what was probably meant.
        """
        from homebot.discovery.search.unknown_words import unknown_word  # noqa: PLC0415 - for searches alone

        index = self._index
        names = (part.part.name for device in index.devices() for part in device.parts)
        if problem := unknown_word(query, index.postings, index.owner.plan, names):
            raise UsageError(problem)

    def _get_changes(self, request: GetChangesRequest) -> GetChangesResponse:
        self._publish_all()
        recent = self._index.changes.recent
        return GetChangesResponse(
            changes=recent.since(request.since),
            complete=recent.forgotten <= request.since <= self._index.sequence,
            sequence=self._index.sequence,
        )

    def _forget(self, request: ForgetDeviceRequest) -> ForgetDeviceResponse:
        announced = self._index.forget(request.device, self._clock.now())
        self._publish_all()
        if announced is None:
            return ForgetDeviceResponse(success=False, message=f"there is no device {request.device!r}")
        return ForgetDeviceResponse(
            success=True,
            announced_on=tuple(AnnouncedOn(gateway=gateway, topic=topic) for gateway, topic in announced),
        )

    async def _catch_up(self) -> None:
        """Publish the changes that wait, and make them findable, in small steps; few come after the last one.

        It works as long as all others did in their last turn, or a flood would bring more than it gets done.
        """
        if not self._index.is_behind:
            return
        monotonic = self._clock.monotonic
        until = 0.0
        for _ in range(_MOST_TURNS):
            while self._step() and monotonic() < until:
                pass
            if not self._index.is_behind:
                return
            left = monotonic()
            await anyio.lowlevel.checkpoint()
            back = monotonic()
            until = back + (back - left)
        self._publish_all()

    def _step(self) -> bool:
        self._publish_some(_FEW)
        self._index.sort(_FEW)
        return self._index.is_behind

    def _publish_all(self) -> None:
        while self._publish_some(_FEW):
            pass

    def _split(self, request: SplitDeviceRequest) -> SplitDeviceResponse:
        key = (request.gateway, request.key) if request.gateway or request.key else None
        try:
            devices = self._index.split(request.device, key, self._clock.monotonic())
        except RefusedError as exc:
            return SplitDeviceResponse(success=False, message=str(exc))
        self._publish_all()
        return SplitDeviceResponse(success=True, devices=devices)

    def _merge(self, request: MergeDevicesRequest) -> MergeDevicesResponse:
        try:
            device = self._index.merge(request.devices, self._clock.monotonic())
        except RefusedError as exc:
            return MergeDevicesResponse(success=False, message=str(exc))
        self._publish_all()
        return MergeDevicesResponse(success=True, device=device)

    async def _export_index(self, _: ExportIndexRequest) -> ExportIndexResponse:
        return ExportIndexResponse(rows=await self._persistence.export())

    def _get_health(self, _: HealthRequest) -> HealthResponse:
        counts = {
            "devices": len(self._index),
            "forgotten_devices": len(self._index.tombstones),
            **self._index.counts(),
            "index_file_failures": self._persistence.failures,
            "index_file_damaged": self._persistence.damaged,
        }
        troubles = () if self._persistence.state in {"off", "ok"} else (self._persistence.state,)
        plan = self._index.owner.plan
        overlaps = homebot.places.FloorPlan.of(plan).overlaps if plan.has_areas else ()
        notes = [
            f"the rooms {one} and {other} overlap by {area:.1f} m²; correct [places]" for one, other, area in overlaps
        ]
        return HealthResponse(counts=Count.each(counts), troubles=troubles, notes=tuple(notes))
