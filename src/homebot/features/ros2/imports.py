"""The topics and services of robots that homebot uses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeVar

import anyio

from homebot.bridges.rosbridge.types import message_type_of_topic, service_type_of
from homebot.bridges.zenoh.attachment import Attachment
from homebot.bridges.zenoh.bridge_tokens import BridgeToken, entity_texts, token_of_text
from homebot.bridges.zenoh.tokens import NO_HASH, EntityToken
from homebot.errors import HomebotError, PeerError, ServiceFailedError, ServiceUnavailableError
from homebot.features.ros2.goals import Caller
from homebot.features.ros2.health import MESSAGE_REFUSED, NOT_IMPORTED
from homebot.graph import Node
from homebot.graph.endpoint import EndpointInfo, EntityKind, GraphEntity
from homebot.graph.qos import DurabilityPolicy
from homebot.messages.action import SendGoalType
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.message import Message
from homebot.messages.type_hash import type_hash

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.access import ClientAccess
    from homebot.bridges.zenoh.entities import OwnEntities, WireEntity
    from homebot.bridges.zenoh.session import WireSample
    from homebot.features.ros2.health import LinkHealth
    from homebot.features.ros2.robots import RobotsOnWire

KeyT = TypeVar("KeyT")

_MAX_TOKENS = 10_000
"""Tokens of others that are kept; a robot with Nav2 has some 700."""

MAX_TOKENS_OF_ONE = 2000
"""The tokens of one process: one that goes wrong leaves room for the others."""

_MAX_OPEN = 1000
"""Topics and services that are imported: with more, Zenoh takes 20 ms and longer for each."""

_LATEST_TOKEN = 1.0  # seconds

_MAX_ANSWER = 600.0
"""Seconds after which a query ends, as with rmw_zenoh; the time limit of the caller is shorter."""

_ENDLESS = 1e9
"""The same for the result of a goal, which may take any time."""


class Imports:
    """Has the topics and services of robots in the graph, as entities of *node*, while their tokens are there."""

    def __init__(self, node: Node, own: OwnEntities, robots: RobotsOnWire, health: LinkHealth) -> None:
        self._node, self._own, self._robots, self._health = node, own, robots, health
        self._problems: dict[str, str] = {}
        self._tokens: dict[str, EntityToken] = {}
        self._callers: dict[bytes, Caller] = {}
        self._nodes: Counter[Caller] = Counter()
        self._sizes: Counter[str] = Counter()  # tokens that are kept, by session
        self._new_caller = anyio.Event()
        self._open: dict[tuple[EntityKind, str], tuple[set[str], WireEntity]] = {}

    async def caller_of(self, gid: bytes) -> Caller:
        """Return the node whose client has *gid*.

        The token of a new client may come after its first request, so an unknown one is waited for.
        """
        with anyio.move_on_after(_LATEST_TOKEN):
            while gid not in self._callers:
                await self._new_caller.wait()
        return self._callers.get(gid, Caller("", ""))

    def has_node(self, caller: Caller) -> bool:
        """Return whether a node has a token."""
        return self._nodes[caller] > 0

    @property
    def tokens(self) -> Iterable[EntityToken]:
        """The tokens of others."""
        return self._tokens.values()

    @property
    def problems(self) -> Iterable[str]:
        """The reasons for which something of robots does not come."""
        return dict.fromkeys(self._problems.values())

    def on_token(self, text: str, is_there: bool) -> None:  # noqa: FBT001 - as the session calls it
        """Take notice of a token of others that came or went."""
        for entity in entity_texts(text):
            self._on_entity(entity, is_there=is_there)

    def _on_entity(self, text: str, *, is_there: bool) -> None:
        try:
            if is_there and text not in self._tokens:
                self._add(text)
            elif not is_there and (token := self._tokens.pop(text, None)) is not None:
                self._remove(text, token)
        except HomebotError as exc:
            if text in self._tokens:
                self._problems[text] = str(exc)
            self._health.refused(NOT_IMPORTED, text, str(exc))

    def close(self) -> None:
        """Remove the nodes of others from the graph; the rest ends with the node of the link."""
        for token in self._tokens.values():
            self._hide(token)

    def _add(self, text: str) -> None:
        token = token_of_text(text)
        if token.session == self._own.session.id:
            return
        if self._sizes[token.session] >= MAX_TOKENS_OF_ONE:
            self._problems[token.session] = (
                f"a process of a robot has more than {MAX_TOKENS_OF_ONE} entities, the rest of which are unknown here"
            )
            raise PeerError(self._problems[token.session])
        if len(self._tokens) >= _MAX_TOKENS:
            raise PeerError(f"of robots, only {_MAX_TOKENS} entities are known")
        self._tokens[text] = token
        self._sizes[token.session] += 1
        kind, name = token.info.kind, token.info.name
        self._node.graph.elsewhere.add(token, token.info)
        if kind is EntityKind.NODE:
            self._nodes[Caller(token.session, name)] += 1
            self._node.graph.add_endpoint(token, token.info)
        elif kind is EntityKind.CLIENT:
            self._callers[token.gid] = Caller(token.session, token.info.node)
            self._new_caller.set()
            self._new_caller = anyio.Event()
        access = self._robots.source_of(name) if kind in {EntityKind.PUBLISHER, EntityKind.SERVICE} else None
        if access is None:
            return
        if (present := self._open.get((kind, name))) is not None:
            present[0].add(text)
            return
        if len(self._open) >= _MAX_OPEN:
            raise PeerError(f"{_MAX_OPEN} topics and services are imported, and no more; name fewer in import of [ros]")
        access.check_publishing(name)
        entity = self._topic(token, access) if kind is EntityKind.PUBLISHER else self._service(token)
        self._open[kind, name] = ({text}, entity)

    def _remove(self, text: str, token: EntityToken) -> None:
        self._problems.pop(text, None)
        self._problems.pop(token.session, None)
        _subtract(self._sizes, token.session)
        self._callers.pop(token.gid, None)
        if token.info.kind is EntityKind.NODE:
            _subtract(self._nodes, Caller(token.session, token.info.name))
        self._hide(token)
        key = (token.info.kind, token.info.name)
        if (present := self._open.get(key)) is None:
            return
        present[0].discard(text)
        if not present[0]:
            del self._open[key]
            present[1].close()

    def _hide(self, token: EntityToken) -> None:
        self._node.graph.remove_endpoint(token)
        self._node.graph.elsewhere.remove(token)

    def _topic(self, token: EntityToken, access: ClientAccess) -> WireEntity:
        info, node = token.info, self._node
        message_type = message_type_of_topic(node.graph, info.name, info.ros_type)
        entity = self._entity(EntityKind.SUBSCRIPTION, token, type_hash(message_type))
        assert info.qos is not None, "the token of a publisher has it"  # noqa: S101 - for mypy
        publisher = node.create_publisher(message_type, info.name, info.qos)
        entity.keep(publisher.close)

        def receive(sample: WireSample) -> None:
            if publisher.is_closed or self._robots.source_of(info.name) is None:
                return
            try:
                if not token.is_bridged:
                    Attachment.of_bytes(sample.attachment)
                message = message_from_cdr(message_type, sample.payload)
                access.check_robot(info.name, message)
            except HomebotError as exc:
                self._health.refused(MESSAGE_REFUSED, info.name, str(exc))
                return
            publisher.publish(message)

        entity.keep(self._own.session.subscribe(token.key, info.qos, receive).undeclare)
        entity.announce()
        if isinstance(token, BridgeToken) and info.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            self._own.session.fetch(token.cache, receive, token.session)
        return entity

    def _service(self, token: EntityToken) -> WireEntity:
        info, node = token.info, self._node
        service_type = service_type_of(node.graph, info.name, info.ros_type)
        entity = self._entity(EntityKind.CLIENT, token, type_hash(service_type))
        response_type: type[Message] = service_type.Response
        longest = _ENDLESS if info.name.endswith("/_action/get_result") else _MAX_ANSWER

        async def ask(request: Message) -> Message:
            asked = None if token.is_bridged else entity.attachment()
            answer = await self._own.session.ask(token.key, message_to_cdr(request), asked, longest, token.session)
            if answer is None:
                raise ServiceUnavailableError(info.name, f"of {info.node} did not answer; is it still there?")
            if isinstance(answer, str):
                raise ServiceFailedError(info.name, answer)
            return message_from_cdr(response_type, answer)

        server = node.create_service(service_type, info.name, ask, concurrent=True, cancel_with_caller=True)
        entity.keep(server.close)
        if isinstance(service_type, SendGoalType):
            action = info.name.partition("/_action/")[0]
            shown = EndpointInfo(EntityKind.ACTION_SERVER, node.full_name, action, service_type.action_type.ros_type)
            acting = GraphEntity(shown, node.remove_entity)
            node.add_entity(acting)
            entity.keep(acting.close)
        entity.announce()
        return entity

    def _entity(self, kind: EntityKind, token: EntityToken, own_hash: str) -> WireEntity:
        """Return the entity here that uses that with *token*, unless its type has another definition there.

        Types of ROS 2 Humble are taken for the same, as it has no hashes.
        """
        their = token.info
        info = EndpointInfo(kind, self._node.full_name, their.name, their.ros_type, their.qos)
        entity = self._own.declare(info, NO_HASH if token.type_hash == NO_HASH else own_hash)
        if problem := token.difference(entity.token):
            raise PeerError(problem)
        return entity


def _subtract(counts: Counter[KeyT], key: KeyT) -> None:
    counts[key] -= 1
    if not counts[key]:
        del counts[key]
