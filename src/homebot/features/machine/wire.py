"""Services between the machines of a house, which prove to each other that they know its secret.

Behind each message in CDR are 32 bytes, an HMAC-SHA256 with the secret: of a request over its key and attachment too,
of an answer over that of its request. So neither a robot nor another home on the same network can command, or answer in
the name of a machine, and nothing can be sent again as something else.
"""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable
from functools import partial
from typing import TYPE_CHECKING, Final, TypeVar

from homebot.bridges.zenoh.entities import OwnEntities
from homebot.errors import HomebotError, LinkError, PeerError
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.message import Message, ServiceType
from homebot.messages.type_hash import type_hash

if TYPE_CHECKING:
    from pydantic import SecretStr

    from homebot.bridges.zenoh.entities import WireEntity
    from homebot.bridges.zenoh.session import WireQuery, ZenohSession
    from homebot.graph import Node

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT", bound=Message)

_PROOF: Final = 32


class MachineWire:
    """The services of machines with one *secret*, as those of *node*."""

    def __init__(self, node: Node, session: ZenohSession, secret: SecretStr) -> None:
        self.session = session
        self._node, self._own = node, OwnEntities(node, session, session.domain)
        self._secret = secret.get_secret_value().encode()
        self._clients: dict[str, WireEntity] = {}
        self._servers: list[WireEntity] = []

    def serve(
        self,
        name: str,
        service_type: ServiceType[RequestT, ResponseT],
        answer: Callable[[RequestT], Awaitable[ResponseT]],
    ) -> None:
        """Serve *name* for those that know the secret, several calls at a time."""
        entity = self._own.declare(self._info(EntityKind.SERVICE, name, service_type), type_hash(service_type))
        reply = partial(self._reply, entity.token.key, service_type.Request, answer)
        served = self.session.serve(entity.token.key, lambda query: self._node.create_task(partial(reply, query)))
        entity.keep(served.undeclare)
        entity.announce()
        self._servers.append(entity)

    async def ask(
        self, name: str, service_type: ServiceType[RequestT, ResponseT], request: RequestT, longest: float
    ) -> ResponseT:
        """Return the answer of the machine.

        Raises:
            LinkError: No node serves *name*, or none answered within *longest*; the request may have been read.
            PeerError: The machine refuses, or does not prove that it knows the secret.
        """
        client = self._clients.get(name)
        if client is None:
            info = self._info(EntityKind.CLIENT, name, service_type)
            client = self._clients[name] = self._own.declare(info, type_hash(service_type))
            client.announce()
        key, attachment = client.token.key, client.attachment()
        data = message_to_cdr(request)
        proof = self._proof(b"?", key.encode(), attachment, data)
        answer = await self.session.ask(key, data + proof, attachment, longest)
        if answer is None:
            raise LinkError(
                "its machine does not answer; is homebot running there, with this name and home, in the same version?"
            )
        if isinstance(answer, str):
            raise PeerError(answer[:500])
        return message_from_cdr(service_type.Response, self._verify(answer, b"!", proof))

    def close(self) -> None:
        """Serve no more, and leave."""
        for entity in (*self._servers, *self._clients.values()):
            entity.close()

    def _info(self, kind: EntityKind, name: str, service_type: ServiceType[RequestT, ResponseT]) -> EndpointInfo:
        return EndpointInfo(kind, self._node.full_name, name, service_type.ros_type)

    async def _reply(
        self,
        key: str,
        request_type: type[RequestT],
        answer: Callable[[RequestT], Awaitable[Message]],
        query: WireQuery,
    ) -> None:
        proof = query.payload[-_PROOF:]
        try:
            data = self._verify(query.payload, b"?", key.encode(), query.attachment)
            response = message_to_cdr(await answer(message_from_cdr(request_type, data)))
        except HomebotError as exc:
            query.refuse(str(exc))
            return
        query.reply(lambda: response + self._proof(b"!", proof, response), query.attachment)

    def _proof(self, *parts: bytes) -> bytes:
        return hmac.digest(self._secret, b"".join(parts), "sha256")

    def _verify(self, sealed: bytes, *about: bytes) -> bytes:
        data, proof = sealed[:-_PROOF], sealed[-_PROOF:]
        if not hmac.compare_digest(proof, self._proof(*about, data)):
            raise PeerError("the two machines do not have the same secret: see token_file and password_file")
        return data
