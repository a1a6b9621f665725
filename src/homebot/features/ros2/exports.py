"""The topics and services of homebot that others may use."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Iterator
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any

import anyio
import anyio.lowlevel
from pydantic import ValidationError

from homebot.bridges.rosbridge.services import cause_of_call, usual_timeout
from homebot.bridges.zenoh.attachment import Attachment
from homebot.errors import HomebotError, ServiceUnavailableError, TypeMismatchError
from homebot.features.ros2.goals import Caller, RobotGoals
from homebot.features.ros2.health import CALL_REFUSED
from homebot.features.ros2.robots import RobotsOnWire
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.graph.parameter_services import refusal
from homebot.graph.parameters import PARAMETER_SERVICES
from homebot.graph.subscription import OTHERS
from homebot.messages.action_msgs import CancelGoalResponse
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.definition import fields_by_name, zero_message
from homebot.messages.message import Message
from homebot.messages.type_hash import type_hash
from homebot.support.name_patterns import fits_any

if TYPE_CHECKING:
    from homebot.bridges.zenoh.entities import OwnEntities, WireEntity
    from homebot.bridges.zenoh.session import WireQuery
    from homebot.bridges.zenoh.tokens import EntityToken
    from homebot.features.ros2.health import LinkHealth

_MAX_CALLS = 100
"""Calls at a time, as of one client of the door."""

_FIRST_TURNS = 3
"""Turns of the event loop in which a call is read, handed over and served, unless its server waits for something."""

_KINDS = frozenset({EntityKind.PUBLISHER, EntityKind.SERVICE, EntityKind.ACTION_SERVER, EntityKind.NODE})
_USED = {EntityKind.SUBSCRIPTION: EntityKind.PUBLISHER, EntityKind.CLIENT: EntityKind.SERVICE}
_OF_PARAMETERS = frozenset(PARAMETER_SERVICES.values())


class Exports:
    """Offers the topics and services with the names in *patterns*, while a node of homebot has them.

    Args:
        caller_of: Returns the node with a gid.
        has_node: Returns whether a node of a robot has a token.
    """

    def __init__(
        self,
        node: Node,
        own: OwnEntities,
        patterns: Iterable[str],
        robots: RobotsOnWire,
        caller_of: Callable[[bytes], Awaitable[Caller]],
        has_node: Callable[[Caller], bool],
        health: LinkHealth,
    ) -> None:
        self._node, self._own, self._patterns = node, own, tuple(patterns)
        self._robots, self._caller_of, self._health = robots, caller_of, health
        self._goals = RobotGoals(node, has_node)
        self._running = 0
        self._beginning = anyio.Lock()
        self._open: dict[tuple[EntityKind, str], WireEntity] = {}

    def refresh(self, kind: EntityKind, name: str) -> None:
        """Offer a new entity with the full name *name*, or withdraw one that left."""
        if kind is EntityKind.NODE:
            self._goals.end_of_all_that_left()
        if kind not in _KINDS or not fits_any(name, self._patterns):
            return
        if kind is EntityKind.ACTION_SERVER:
            self._node.graph.get_action_type(name)  # one that waits for its first use starts, and its parts come
        else:
            others = [
                endpoint
                for endpoint in self._node.graph.get_endpoints(kind=kind, name=name)
                if endpoint.node != self._node.full_name
            ]
            present = self._open.get((kind, name))
            if others and present is None:
                if (opened := self._opened(kind, others)) is not None:
                    self._open[kind, name] = opened
            elif present is not None and not others:
                del self._open[kind, name]
                present.close()

    def refresh_all(self) -> None:
        """Offer all that is there."""
        self._goals.end_of_all_that_left()
        for info in self._node.graph.get_endpoints():
            self.refresh(info.kind, info.name)

    def problems(self, tokens: Iterable[EntityToken]) -> Iterator[str]:
        """Yield why those of *tokens* that others have for what is offered cannot use it."""
        for token in tokens:
            kind = _USED.get(token.info.kind)
            opened = None if kind is None else self._open.get((kind, token.info.name))
            if opened is not None and (problem := token.difference(opened.token)):
                yield problem

    def _opened(self, kind: EntityKind, others: list[EndpointInfo]) -> WireEntity | None:
        if kind is EntityKind.PUBLISHER:
            return self._topic(others)
        if kind is EntityKind.SERVICE:
            return self._service(others[0].name)
        if self._node.graph.get_node(others[0].name) is None:  # of a robot
            return None
        entity = self._own.declare(others[0], "")
        entity.announce()
        return entity

    def _topic(self, publishers: list[EndpointInfo]) -> WireEntity:
        name, node = publishers[0].name, self._node
        message_type = node.graph.get_message_type(name)
        assert message_type is not None, "a topic with a publisher has a type"  # noqa: S101 - for mypy
        offered = [publisher.qos for publisher in publishers if publisher.qos is not None]
        is_latched = all(profile.durability is DurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
        durability = DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE
        reliability = max(profile.reliability for profile in offered)
        qos = QoSProfile(max(profile.depth for profile in offered), reliability=reliability, durability=durability)
        info = EndpointInfo(EntityKind.PUBLISHER, node.full_name, name, message_type.ros_type, qos)
        entity = self._own.declare(info, type_hash(message_type))
        writer = self._own.session.publish(entity.token.key, qos)
        entity.keep(writer.undeclare)
        entity.announce()

        def send(message: Message) -> None:
            writer.put(message_to_cdr(message), attachment=entity.attachment())

        entity.keep(node.create_subscription(message_type, name, send, qos, from_node=OTHERS).close)
        return entity

    def _service(self, name: str) -> WireEntity | None:
        service_type = self._node.graph.get_service_type(name)
        if service_type is None:  # it left at once
            return None
        info = EndpointInfo(EntityKind.SERVICE, self._node.full_name, name, service_type.ros_type)
        entity = self._own.declare(info, type_hash(service_type))

        def asked(query: WireQuery) -> None:
            if self._running >= _MAX_CALLS:
                query.refuse(f"{_MAX_CALLS} calls are at work; ask again later")
                return
            self._running += 1
            self._node.create_task(partial(self._begin, name, query))

        entity.keep(self._own.session.serve(entity.token.key, asked).undeclare)
        entity.announce()
        return entity

    async def _begin(self, name: str, query: WireQuery) -> None:
        """Begin to answer *query*; before the next one, everything else has as long as this one works at first."""
        now = self._node.graph.clock.monotonic
        async with self._beginning:
            self._node.create_task(partial(self._answer, name, query))
            began = now()
            for _ in range(_FIRST_TURNS):
                await anyio.lowlevel.checkpoint()
            await anyio.sleep(now() - began)

    async def _answer(self, name: str, query: WireQuery) -> None:
        """Answer *query*, also if it fails: a client of rmw_zenoh would wait for ten minutes."""
        try:
            gid = Attachment.of_bytes(query.attachment).gid
            is_known = self._robots.are_several or "/_action/" in name
            caller = await self._caller_of(gid) if is_known else Caller("", "")
            response = await self._response(name, query.payload, caller)
        except HomebotError as exc:
            self._health.refused(CALL_REFUSED, name, str(exc))
            failed = self._failure(name, query.payload, str(exc))
            if failed is None:
                query.refuse(str(exc))
                return
            response = failed
        finally:
            self._running -= 1
        query.reply(partial(message_to_cdr, response), query.attachment)

    async def _response(self, name: str, payload: bytes, caller: Caller) -> Message:
        node = self._node
        access = self._robots.caller(caller.node)
        target, _, is_of_action = name.partition("/_action/")
        access.check_calling(target)
        await node.graph.begin(name)
        service_type = node.graph.get_service_type(name)
        if service_type is None:
            raise ServiceUnavailableError(name, "has no server now")
        request_type: type[Message] = service_type.Request
        request = access.as_own(message_from_cdr(request_type, payload))
        CURRENT_CAUSE.set(cause_of_call(node, access, target))
        if is_of_action:
            return await self._goals.answer(name, request, caller, access)
        client = node.create_client(service_type, name)
        try:
            answer: Any = await client.call(request, usual_timeout(name))
        finally:
            client.close()
        response: Message = answer if isinstance(answer, Message) else service_type.Response.of(answer)
        return response

    def _failure(self, name: str, payload: bytes, problem: str) -> Message | None:
        """Return the response that says *problem*, or as ROS 2 that nothing was done, if the service has one."""
        service_type = self._node.graph.get_service_type(name)
        if service_type is None:
            return None
        response_type: type[Message] = service_type.Response
        known = fields_by_name(response_type).keys()
        said: dict[str, object] = {"success": False, "message": problem}
        if "/_action/" in name:
            said = {"return_code": CancelGoalResponse.ERROR_REJECTED} if "return_code" in known else {}
        elif service_type.ros_type in _OF_PARAMETERS:
            said = {}
            with suppress(TypeMismatchError):
                said = refusal(message_from_cdr(service_type.Request, payload), response_type, problem)
        if not said.keys() <= known:
            return None
        try:
            zero: Message = zero_message(response_type)
        except ValidationError:  # zero is not allowed
            return None
        return zero.model_copy(update=said)
