"""Services by which the owner states the rooms and names of devices, and approves their commands."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from contextlib import closing
from dataclasses import replace
from functools import partial
from typing import Final, Literal, TypeVar, final

from anyio import to_thread

from homebot.clock import Clock, TimeSlice
from homebot.devices import approval_messages as approvals
from homebot.devices import names
from homebot.devices import places_messages as messages
from homebot.devices.device import KeyValue
from homebot.devices.query.terms import NameIs
from homebot.discovery.index import DeviceIndex
from homebot.errors import ConfigError, RefusedError, ServiceError, UsageError
from homebot.graph import Node
from homebot.messages import Time
from homebot.messages.json import message_to_text
from homebot.messages.message import Message, ServiceAnswer, ServiceType
from homebot.places import HouseDoor, HouseRoom
from homebot.places.plan import Point
from homebot.support.folding import fold

RequestT = TypeVar("RequestT", bound=Message)
AnswerT = TypeVar("AnswerT", bound=ServiceAnswer)

_DEPTH: Final = 1000

_MAX_ABSENT = 1000

_SHORT = 4000
"""Most characters of a places file parsed without a thread, in a few milliseconds; long ones take a second."""


class PlacesServices:
    """The services of the directory for the owner's statements."""

    def __init__(self, clock: Clock, index: DeviceIndex) -> None:
        self._clock = clock
        self._index = index

    def register(self, node: Node, owner: OwnerRequests) -> None:
        """Register the services at *node*; requests of the owner go through *owner*."""
        owner.serve(messages.PlaceDevice, names.PLACE_DEVICE, self._place)
        owner.serve(messages.AliasDevice, names.ALIAS_DEVICE, self._add_alias)
        owner.serve(messages.TagDevice, names.TAG_DEVICE, self._add_tag)
        owner.serve(approvals.ApproveDevice, names.APPROVE_DEVICE, partial(self._approve, node))
        node.create_service(messages.GetPlaces, names.GET_PLACES, self._get_places)
        owner.serve(messages.TeachPlace, names.TEACH_PLACE, self._teach)
        owner.serve(messages.ChangeRoom, names.CHANGE_ROOM, self._change_room)
        node.create_service(messages.ExportPlaces, names.EXPORT_PLACES, self._export)
        node.create_service(
            messages.ImportPlaces,
            names.IMPORT_PLACES,
            lambda request: owner.carry_out(messages.ImportPlacesResponse, partial(self._import, owner, request)),
        )

    def _place(self, request: messages.PlaceDeviceRequest) -> messages.PlaceDeviceResponse:
        places, may_be_absent = self._index.places, request.may_be_absent
        device = places.future_name(request.device) if may_be_absent else request.device
        if request.room or request.at:
            more = {"is_new": request.is_new, "may_be_absent": may_be_absent}
            room = places.place(device, request.room, self._clock.now(), at=request.at, **more)
        else:
            room = places.unplace(device, may_be_absent=may_be_absent)
        return messages.PlaceDeviceResponse(success=True, room=room, absent="" if places.has(device) else device)

    def _add_alias(self, request: messages.AliasDeviceRequest) -> messages.AliasDeviceResponse:
        if not request.remove:
            from homebot.devices.device_names import names_of  # noqa: PLC0415 - for aliases alone

            name = fold(request.alias)
            for other in sorted(self._index.find(NameIs(name)) - {request.device}):
                device = self._index.get(other)
                if device is not None and name in map(fold, names_of(device)):  # else the name of a part
                    raise RefusedError(f"the alias {request.alias!r}", f"{device.id} is called that already")
        aliases = self._change(request.device, "name", request.alias, remove=request.remove)
        return messages.AliasDeviceResponse(success=True, aliases=aliases)

    def _add_tag(self, request: messages.TagDeviceRequest) -> messages.TagDeviceResponse:
        return messages.TagDeviceResponse(
            success=True, tags=self._change(request.device, "tag", request.tag, remove=request.remove)
        )

    async def _approve(self, node: Node, request: approvals.ApproveDeviceRequest) -> approvals.ApproveDeviceResponse:
        places, device = self._index.places, request.device
        if request.is_preview:
            digest = places.approval_digest(device)
            commands = await self._commands(node, device)
            places.check_shown(device, digest)
            return approvals.ApproveDeviceResponse(success=True, commands=commands, digest=digest)
        if request.remove:
            places.disapprove(device)
            return approvals.ApproveDeviceResponse(success=True)
        changes = places.approve(device, self._clock.now(), request.digest)
        return approvals.ApproveDeviceResponse(
            success=True, commands=await self._commands(node, device), changes=changes
        )

    async def _commands(self, node: Node, device: str) -> tuple[str, ...]:
        """Return the payloads that the gateways of *device* send for commands; the announced ones if one is silent."""
        lines: list[str] = []
        for (gateway, key), announced in self._index.places.commands(device).items():
            with closing(
                node.create_client(approvals.DescribeCommands, names.GatewayNames(gateway).describe_commands)
            ) as client:
                try:
                    described = (await client.call(approvals.DescribeCommandsRequest(key=key))).commands
                except ServiceError:
                    described = ()
            lines += described or announced
        return tuple(lines)

    def _get_places(self, _: messages.GetPlacesRequest) -> messages.GetPlacesResponse:
        plan = self._index.owner.plan
        absent = sorted(self._index.places.absent())[:_MAX_ABSENT]
        return messages.GetPlacesResponse(
            home=plan.home,
            rooms=tuple(map(_room_info, plan.rooms)),
            absent=tuple(KeyValue(key=key, value=room) for key, room in absent),
            doors=tuple(map(_door_info, plan.doors)),
        )

    def _teach(self, request: messages.TeachPlaceRequest) -> messages.TeachPlaceResponse:
        teach, now = self._index.places.teach, self._clock.now()
        room, is_new = teach(request.device, request.gateway, request.tag, request.room, now, at=request.at)
        return messages.TeachPlaceResponse(success=True, room=room, is_new=is_new)

    async def _change_room(self, request: messages.ChangeRoomRequest) -> messages.ChangeRoomResponse:
        exchange, name = self._index.places_exchange, ""
        if request.name:
            name = await TimeSlice(self._clock).do(exchange.rename_room(request.room, request.name))
        else:
            await TimeSlice(self._clock).do(exchange.remove_room(request.room))
        return messages.ChangeRoomResponse(success=True, name=name)

    async def _export(self, _: messages.ExportPlacesRequest) -> messages.ExportPlacesResponse:
        return messages.ExportPlacesResponse(
            text=await TimeSlice(self._clock).do(self._index.places_exchange.export_text())
        )

    async def _import(
        self, owner: OwnerRequests, request: messages.ImportPlacesRequest
    ) -> messages.ImportPlacesResponse:
        exchange = self._index.places_exchange
        try:
            parse = partial(exchange.parse, request.text, self._clock.now())
            places = parse() if len(request.text) <= _SHORT else await to_thread.run_sync(parse)
            places = replace(places, rooms=tuple(room._replace(source=request.source) for room in places.rooms))
            owner.publish(names.IMPORT_PLACES, request)  # other files may hold passwords
            imported = await TimeSlice(self._clock).do(exchange.apply(places, replaces=request.replaces))
        except ConfigError as exc:
            raise UsageError(f"{exc.key}: {exc.reason}" if exc.key else exc.reason) from exc
        return messages.ImportPlacesResponse(success=True, added=imported.added, kept=imported.kept)

    def _change(self, device: str, fact: Literal["name", "tag"], word: str, *, remove: bool) -> tuple[str, ...]:
        """Add a word to the statements about a device, or withdraw it; return all of them."""
        places = self._index.places
        if remove:
            return places.withdraw(device, fact, word)
        return places.add(device, fact, word, self._clock.now())


@final
class OwnerRequests:
    """The services of the owner: each request is published to subscribers, and saved before it is answered.

    Args:
        keep: Writes the owner's decisions; returns the reason of a failure, in words.
        publish_all: Publishes waiting changes, so that a caller sees its statement once it has the answer.
    """

    def __init__(self, node: Node, keep: Callable[[], Awaitable[str]], publish_all: Callable[[], None]) -> None:
        self._node = node
        self._keep = keep
        self._publish_all = publish_all
        self._publisher = node.create_publisher(messages.OwnerRequest, names.OWNER_REQUESTS, _DEPTH)

    def serve(
        self,
        service: ServiceType[RequestT, AnswerT],
        name: str,
        handler: Callable[[RequestT], AnswerT | Awaitable[AnswerT]],
    ) -> None:
        """Offer a service, answered as by :meth:`carry_out`."""

        async def answer(request: RequestT) -> AnswerT:
            self.publish(name, request)
            return await self.carry_out(service.Response, partial(handler, request))

        self._node.create_service(service, name, answer)

    async def carry_out(self, response: type[AnswerT], handle: Callable[[], AnswerT | Awaitable[AnswerT]]) -> AnswerT:
        """Return the answer of *handle*, or a *response* with the reason for its refusal.

        The message of the answer says so if the result could not be saved.
        """
        try:
            result = handle()
            answer = result if isinstance(result, ServiceAnswer) else await result
        except (ConfigError, RefusedError, UsageError) as exc:
            return response(success=False, message=str(exc))
        self._publish_all()
        if not (problem := await self._keep()):
            return answer
        return answer.model_copy(update={"message": f"a restart would lose this, as it was not written: {problem}"})

    def publish(self, name: str, request: Message) -> None:
        """Publish a request to the service *name*."""
        if self._publisher.subscription_count:
            at = Time.from_seconds(self._node.graph.clock.now())
            self._publisher.publish(messages.OwnerRequest(at=at, service=name, request=message_to_text(request)))


def _room_info(room: HouseRoom) -> messages.RoomInfo:
    rings = ((ring, index > 0) for rings in room.polygons for index, ring in enumerate(rings))
    areas = (messages.AreaRing(x=_xs(ring), y=_ys(ring), is_hole=is_hole) for ring, is_hole in rings)
    return messages.RoomInfo(name=room.name, floor=room.floor, doors=room.doors, areas=tuple(areas))


def _door_info(door: HouseDoor) -> messages.DoorInfo:
    ends, more = door.position, (door.width, door.contact, door.lock)
    return messages.DoorInfo(
        name=door.name, rooms=door.rooms, x=_xs(ends), y=_ys(ends), width=more[0], contact=more[1], lock=more[2]
    )


def _xs(points: tuple[Point, ...]) -> tuple[float, ...]:
    return tuple(x for x, _ in points)


def _ys(points: tuple[Point, ...]) -> tuple[float, ...]:
    return tuple(y for _, y in points)
