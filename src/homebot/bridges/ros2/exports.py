"""The topics and services of homebot that others may use."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from homebot.bridges.ros2.attachment import Attachment
from homebot.bridges.ros2.robots import RobotsOnWire, fits_any
from homebot.bridges.rosbridge.services import cause_of_call, usual_timeout
from homebot.errors import HomebotError, ServiceUnavailableError
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.graph.subscription import OTHERS
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.definition import fields_by_name, fields_of, zero_of
from homebot.messages.json import message_from_json, message_to_json
from homebot.messages.message import Message
from homebot.messages.type_hash import type_hash

if TYPE_CHECKING:
    from homebot.bridges.ros2.entities import OwnEntities, WireEntity
    from homebot.bridges.ros2.session import WireQuery

__all__ = ["Exports"]

_MOST_CALLS = 100
"""Calls at a time, as of one client of the door."""

_KINDS = frozenset({EntityKind.PUBLISHER, EntityKind.SERVICE})


class Exports:
    """Offers the topics and services with the names in *patterns*, while a node of homebot has them.

    Args:
        node_of: Returns the full name of the node with a gid; empty if it is unknown.
    """

    def __init__(
        self,
        node: Node,
        own: OwnEntities,
        patterns: Iterable[str],
        robots: RobotsOnWire,
        node_of: Callable[[bytes], str],
    ) -> None:
        self._node, self._own, self._patterns = node, own, tuple(patterns)
        self._robots, self._node_of = robots, node_of
        self._running = 0
        self._open: dict[tuple[EntityKind, str], Callable[[], None]] = {}

    def refresh(self, kind: EntityKind, name: str) -> None:
        """Offer what came with the full name *name*, or take back what left."""
        if kind not in _KINDS or not fits_any(name, self._patterns):
            return
        found = self._node.graph.get_endpoints(kind=kind, name=name)
        others = [one for one in found if one.node != self._node.full_name]
        close = self._open.get((kind, name))
        if others and close is None:
            self._open[kind, name] = self._topic(others) if kind is EntityKind.PUBLISHER else self._service(name)
        elif close is not None and not others:
            del self._open[kind, name]
            close()

    def refresh_all(self) -> None:
        """Offer all that is there."""
        for info in self._node.graph.get_endpoints():
            self.refresh(info.kind, info.name)

    def _topic(self, publishers: list[EndpointInfo]) -> Callable[[], None]:
        name, node = publishers[0].name, self._node
        message_type = node.graph.get_message_type(name)
        assert message_type is not None, "a topic with a publisher has a type"  # noqa: S101 - for mypy
        offered = [one.qos for one in publishers if one.qos is not None]
        is_latched = all(one.durability is DurabilityPolicy.TRANSIENT_LOCAL for one in offered)
        durability = DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE
        reliability = max(one.reliability for one in offered)
        qos = QoSProfile(max(one.depth for one in offered), reliability=reliability, durability=durability)
        info = EndpointInfo(EntityKind.PUBLISHER, node.full_name, name, message_type.ros_type, qos)
        entity = self._own.declare(info, type_hash(message_type))
        writer = self._own.session.publish(entity.token.key, qos)
        entity.keep(writer)
        entity.announce()

        def send(message: Message) -> None:
            writer.put(message_to_cdr(message), attachment=entity.attachment())

        reading = node.create_subscription(message_type, name, send, qos, from_node=OTHERS)
        return partial(_close, reading.close, entity)

    def _service(self, name: str) -> Callable[[], None]:
        service_type = self._node.graph.get_service_type(name)
        if service_type is None:  # it left at once
            return lambda: None
        info = EndpointInfo(EntityKind.SERVICE, self._node.full_name, name, service_type.ros_type)
        entity = self._own.declare(info, type_hash(service_type))

        def asked(query: WireQuery) -> None:
            if self._running >= _MOST_CALLS:
                query.refuse(f"{_MOST_CALLS} calls are at work; ask again later")
                return
            self._running += 1
            self._node.create_task(partial(self._answer, name, query))

        entity.keep(self._own.session.serve(entity.token.key, asked))
        entity.announce()
        return entity.close

    async def _answer(self, name: str, query: WireQuery) -> None:
        """Answer *query*, also if it fails: a client of rmw_zenoh would wait for ten minutes."""
        try:
            gid = Attachment.of_bytes(query.attachment).gid
            response = await self._response(name, query.payload, self._node_of(gid))
        except HomebotError as exc:
            failed = self._failure(name, str(exc))
            if failed is None:
                query.refuse(str(exc))
                return
            response = failed
        finally:
            self._running -= 1
        query.reply(message_to_cdr(response), query.attachment)

    async def _response(self, name: str, payload: bytes, caller: str) -> Message:
        node = self._node
        access = self._robots.caller(caller)
        access.check_calling(name)
        service_type = node.graph.get_service_type(name)
        if service_type is None:
            raise ServiceUnavailableError(name, "has no server now")
        request_type: type[Message] = service_type.Request
        request = message_from_cdr(request_type, payload)
        stamped = access.stamped(request_type, request.__dict__)
        if stamped is not request.__dict__:
            request = message_from_json(request_type, access.stamped(request_type, message_to_json(request)))
        client = node.create_client(service_type, name)
        CURRENT_CAUSE.set(cause_of_call(node, access, name))
        try:
            answer: Any = await client.call(request, usual_timeout(name))
        finally:
            client.close()
        response: Message = answer if isinstance(answer, Message) else service_type.Response.of(answer)
        return response

    def _failure(self, name: str, problem: str) -> Message | None:
        """Return the response that says *problem*, if the type of the service has one."""
        service_type = self._node.graph.get_service_type(name)
        if service_type is None:
            return None
        response_type: type[Message] = service_type.Response
        if not {"success", "message"} <= fields_by_name(response_type).keys():
            return None
        required = (one for one in fields_of(response_type) if response_type.model_fields[one.name].is_required())
        values = {one.name: zero_of(one) for one in required} | {"success": False, "message": problem}
        try:
            return response_type(**values)
        except ValidationError:  # zero is not allowed
            return None


def _close(reading: Callable[[], None], entity: WireEntity) -> None:
    reading()
    entity.close()
