"""The services of the directory."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection, Sequence
from functools import cached_property, partial
from importlib import import_module
from operator import attrgetter
from typing import TYPE_CHECKING

import anyio.lowlevel
from anyio import to_thread

import homebot.places
from homebot.clock import TimeSlice
from homebot.devices import FIND_DEVICES, GET_CHANGES, GET_INDEX_DATA, QUERY_DEVICES, names
from homebot.devices import services as messages
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.devices.query.matching import fits
from homebot.devices.query.term_messages import query_terms, read_terms
from homebot.devices.query.terms import And, FactIs, Query, split_near, type_is
from homebot.discovery.index import DeviceIndex
from homebot.discovery.persistence import IndexPersistence
from homebot.discovery.places_services import OwnerRequests, PlacesServices
from homebot.errors import RefusedError, UsageError
from homebot.graph import Node
from homebot.support.folding import fold

if TYPE_CHECKING:
    from homebot.discovery.listing import ShortForms
    from homebot.discovery.nearness import Nearness

_KIND = attrgetter("kind")

_MAX_CHANGES_PER_TURN = 10
"""Changes published, or postings updated, before other tasks run."""

_MAX_TURNS = 1000
"""Most turns that other tasks get before an answer, so that it does not wait for the end of a flood."""


class DirectoryServices:
    """The services of the directory.

    Args:
        publish: Publishes up to so many waiting changes, so that no answer is ahead of them; returns whether there
            may be more.
    """

    def __init__(
        self, node: Node, index: DeviceIndex, persistence: IndexPersistence, publish: Callable[[int], bool]
    ) -> None:
        self._clock = node.graph.clock
        self._index = index
        self._persistence = persistence
        self._publish_some = publish
        self._node = node
        self._near: Nearness | None = None

    def register(self) -> None:
        """Register the services."""
        node, owner = self._node, OwnerRequests(self._node, self._persistence.save_now, self._publish_all)
        node.create_service(messages.GetIndexData, GET_INDEX_DATA, self._get_index_data)
        node.create_service(messages.FindDevices, FIND_DEVICES, self._find_devices)
        node.create_service(messages.QueryDevices, QUERY_DEVICES, self._query)
        node.create_service(messages.ListDevices, names.LIST_DEVICES, self._list)
        load_groups = partial(import_module, "homebot.discovery.group_list")
        node.offer_service("homebot/srv/ListGroups", names.LIST_GROUPS, self._serve_groups, load_groups)
        node.create_service(messages.GetChanges, GET_CHANGES, self._get_changes)
        owner.serve(messages.ForgetDevice, names.FORGET_DEVICE, self._forget)
        owner.serve(messages.SplitDevice, names.SPLIT_DEVICE, self._split)
        owner.serve(messages.MergeDevices, names.MERGE_DEVICES, self._merge)
        node.create_service(messages.ExportIndex, names.EXPORT_INDEX, self._export_index)
        node.create_service(GetHealth, names.DISCOVERY_HEALTH, self._get_health)
        PlacesServices(self._clock, self._index).register(node, owner)

    async def _get_index_data(self, request: messages.GetIndexDataRequest) -> messages.GetIndexDataResponse:
        await self._catch_up()
        devices = self._index.devices(request.service_type)
        return messages.GetIndexDataResponse(
            entries=tuple(
                messages.IndexEntry(gateway=gateway, topic=topic, device_id=device.id)
                for device in devices
                for gateway, topic in dict.fromkeys(
                    (endpoint.gateway, endpoint.address) for endpoint in device.endpoints
                )
            ),
            topics=tuple(device.endpoints[0].address for device in devices),
            device_ids=tuple(device.id for device in devices),
        )

    def _find_devices(
        self, request: messages.FindDevicesRequest
    ) -> messages.FindDevicesResponse | Awaitable[messages.FindDevicesResponse]:
        if self._index.is_behind or not {"near", "words"}.isdisjoint(map(_KIND, request.query)):
            return self._find_later(request)
        return self._found(request)

    async def _find_later(self, request: messages.FindDevicesRequest) -> messages.FindDevicesResponse:
        await self._catch_up()
        return self._found(request, await self._near_robot(request))

    async def _near_robot(self, request: messages.FindDevicesRequest) -> list[str] | None:
        """Return the ids of the devices near a robot for *request*, best first; None if it does not ask for that."""
        near, rest = split_near(read_terms(request.query, self._parse))
        if near is None:
            return None
        return [device.device for device in (await (await self._nearness()).find(near, rest)).devices]

    def _found(
        self, request: messages.FindDevicesRequest, near: Sequence[str] | None = None
    ) -> messages.FindDevicesResponse:
        is_by_id = request.ids and not request.query and not request.service_type
        devices = []
        for device_id in sorted(set(request.ids)) if is_by_id else self._matching(request, near):
            device = self._index.get(device_id)
            if device is not None:  # otherwise the robot is named, but unknown
                devices.append(device)
        return messages.FindDevicesResponse(devices=tuple(devices), sequence=self._index.changes.sequence)

    def _parse(self, text: str) -> Query:
        from homebot.words.queries import parse_query  # noqa: PLC0415 - only what people write is sent as text

        return parse_query(text, self._exists)

    def _exists(self, query: Query) -> bool:
        return bool(self._index.find(query))

    def _matching(self, request: messages.FindDevicesRequest, near: Sequence[str] | None) -> list[str]:
        """Return the ids of the devices that match *request*, sorted, or in the order of *near* if given."""
        query = read_terms(request.query, self._parse)
        if request.service_type:
            query = And((type_is(request.service_type), query))
        if request.is_checked:
            self._check_words(query)
        matches = self._index.find(query)
        matches = matches.intersection(request.ids) if request.ids else matches
        return sorted(matches) if near is None else [device_id for device_id in near if device_id in matches]

    async def _query(self, request: messages.QueryDevicesRequest) -> messages.QueryDevicesResponse:
        from homebot.discovery.search.rank import rank, reasons  # noqa: PLC0415 - for searches alone

        await self._catch_up()
        index, limit = self._index, request.offset + request.limit if request.limit else None
        ranked: list[tuple[float, str, tuple[str, ...]]]
        try:
            query = read_terms(request.query, self._parse)
            self._check_words(query)
            near, rest = split_near(query)
            if near is None:
                matches = index.find(query)
                if request.is_spelled:
                    matches = {match for match in matches if fits(query, index.postings.facets(match))}
                ranked = [(score, device_id, ()) for score, device_id in rank(query, matches, index.postings)]
                note = self._explain_result(query, matches, is_spelled=request.is_spelled)
                answer = messages.QueryDevicesResponse(success=True, message=note, total=len(ranked))
            else:
                nearest = await (await self._nearness()).find(near, rest, limit or 0)
                ranked = [(-device.cost, device.device, (nearest.why(device),)) for device in nearest.devices]
                answer = nearest.answer
        except (RefusedError, UsageError) as exc:
            is_mistake = isinstance(exc, UsageError)
            return messages.QueryDevicesResponse(
                success=False, message=_reason(exc), sequence=index.sequence, is_mistake=is_mistake
            )
        results, work = [], TimeSlice(self._clock)
        for score, device_id, why in ranked[request.offset : limit]:
            if (device := index.get(device_id)) is not None:
                because = (*why, *reasons(rest, device_id, index.postings))
                results.append(messages.Found(device=device, score=score, reasons=because))
            if work.is_over:
                await work.pause()
        words = any(term.kind == "words" for term in request.query)
        more = {"query": query_terms(query)} if words else {}
        return answer.model_copy(update={"results": tuple(results), "sequence": index.sequence, **more})

    async def _list(self, request: messages.ListDevicesRequest) -> messages.ListDevicesResponse:
        await self._catch_up()
        wanted = messages.FindDevicesRequest(query=request.query, ids=request.ids, is_checked=True)
        try:
            matches = self._matching(wanted, await self._near_robot(wanted))
            if request.is_spelled:
                query = read_terms(request.query, self._parse)
                matches = [device_id for device_id in matches if fits(query, self._index.postings.facets(device_id))]
        except (RefusedError, UsageError) as exc:
            return messages.ListDevicesResponse(success=False, message=_reason(exc), sequence=self._index.sequence)
        from homebot.discovery.listing import rights_in  # noqa: PLC0415 - screens and agents ask, after the start

        end = request.offset + min(request.limit or messages.MAX_LISTED, messages.MAX_LISTED)
        rights = rights_in(request)
        listed, work = [], TimeSlice(self._clock)
        for device_id in matches[request.offset : end]:
            if (device := self._index.get(device_id)) is not None:
                listed.append(self._short_forms.of(device, rights, needs_approval=self._index.postings.needs_approval))
            if work.is_over:
                await work.pause()
        return messages.ListDevicesResponse(
            success=True,
            message=self._explain_result(
                read_terms(request.query, self._parse), matches, is_spelled=request.is_spelled
            ),
            devices=tuple(listed),
            total=len(matches),
            sequence=self._index.sequence,
        )

    @cached_property
    def _short_forms(self) -> ShortForms:
        from homebot.discovery.listing import ShortForms  # noqa: PLC0415 - as above

        return ShortForms()

    async def _nearness(self) -> Nearness:
        """Return the finder of devices near a robot; its modules load in a thread, as that is too long for one turn."""
        if self._near is None:
            make = await to_thread.run_sync(_load_nearness)
            if self._near is None:
                self._near = make(self._node, self._index)
        return self._near

    def _check_words(self, query: Query) -> None:
        """Check the words of *query*, as :func:`check_words` does."""
        from homebot.discovery.search.unknown_words import check_words  # noqa: PLC0415 - for searches alone

        index = self._index
        check_words(query, index.postings, index.owner.plan, index.devices)

    def _explain_result(self, query: Query, found: Collection[str], *, is_spelled: bool) -> str:
        """Return what is to be known about the devices *found*, as :func:`explain_result` does."""
        from homebot.discovery.search.unknown_words import explain_result  # noqa: PLC0415 - for searches alone

        return explain_result(query, found, self._index.postings, self._index.owner.plan, is_spelled=is_spelled)

    def _get_changes(self, request: messages.GetChangesRequest) -> messages.GetChangesResponse:
        self._publish_all()
        recent = self._index.changes.recent
        return messages.GetChangesResponse(
            changes=recent.since(request.since),
            complete=recent.forgotten <= request.since <= self._index.sequence,
            sequence=self._index.sequence,
        )

    def _forget(self, request: messages.ForgetDeviceRequest) -> messages.ForgetDeviceResponse:
        announced = self._index.forget(request.device, self._clock.now())
        if announced is None:
            raise UsageError(f"there is no device {request.device!r}")
        return messages.ForgetDeviceResponse(
            success=True,
            announced_on=tuple(messages.AnnouncedOn(gateway=gateway, topic=topic) for gateway, topic in announced),
        )

    async def _catch_up(self) -> None:
        """Publish the waiting changes and update the postings, in small steps.

        Each step lasts as long as the last turn of all other tasks, so that it can keep up with a flood.
        """
        if not self._index.is_behind:
            return
        monotonic = self._clock.monotonic
        until = 0.0
        for _ in range(_MAX_TURNS):
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
        self._publish_some(_MAX_CHANGES_PER_TURN)
        self._index.sort(_MAX_CHANGES_PER_TURN)
        return self._index.is_behind

    def _publish_all(self) -> None:
        while self._publish_some(_MAX_CHANGES_PER_TURN):
            pass

    def _split(self, request: messages.SplitDeviceRequest) -> messages.SplitDeviceResponse:
        key = (request.gateway, request.key) if request.gateway or request.key else None
        devices = self._index.split(request.device, key, self._clock.monotonic())
        return messages.SplitDeviceResponse(success=True, devices=devices)

    def _merge(self, request: messages.MergeDevicesRequest) -> messages.MergeDevicesResponse:
        device = self._index.merge(request.devices, self._clock.monotonic())
        return messages.MergeDevicesResponse(success=True, device=device)

    async def _export_index(self, _: messages.ExportIndexRequest) -> messages.ExportIndexResponse:
        return messages.ExportIndexResponse(rows=await self._persistence.export())

    def _get_health(self, _: HealthRequest) -> HealthResponse:
        sizes = {"devices": len(self._index), "forgotten_devices": len(self._index.tombstones)}
        counts = (*Count.each(sizes), *self._index.counts(), *self._persistence.counts())
        troubles = (self._persistence.problem,) if self._persistence.problem else ()
        plan = self._index.owner.plan
        overlaps = homebot.places.FloorPlan.of(plan).overlaps if plan.has_areas else ()
        notes = [
            f"the rooms {room} and {other} overlap by {area:.1f} m²; correct [places]" for room, other, area in overlaps
        ]
        groups = self._index.owner.groups
        notes += [
            f"the group {name} is empty: no device fits {query!r}; correct its members in [[groups]]"
            for name, query in ({} if groups is None else groups.queries).items()
            if not self._index.find(FactIs(names.GROUP, fold(name)))
        ]
        return HealthResponse(counts=counts, troubles=troubles, notes=tuple(notes))

    def _serve_groups(self) -> None:
        from homebot.discovery.group_list import GroupList  # noqa: PLC0415 - few homes ask

        GroupList(self._index, self._catch_up).serve(self._node)


def _reason(exc: RefusedError | UsageError) -> str:
    return exc.reason if isinstance(exc, RefusedError) else str(exc)


def _load_nearness() -> type[Nearness]:
    from homebot.discovery.nearness import Nearness  # noqa: PLC0415 - with the first query for what is near

    return Nearness
