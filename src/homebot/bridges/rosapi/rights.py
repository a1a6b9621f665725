"""A service of our own: the rights of the client that asks, so that it offers no more."""

from typing import Final

from homebot.graph import Node
from homebot.messages.message import Message, ServiceType


class GetRightsRequest(Message):
    """A question for the client's own rights.

    Attributes:
        issuer: The client; set by the rosbridge server.
        rights: The first words of its rights, such as ``read`` and ``act``; set by the rosbridge server.
        scope: Its rights to act and to ask, as they were written; set by the rosbridge server.
    """

    issuer: str = ""
    scope: tuple[str, ...] = ()
    rights: tuple[str, ...] = ()


class GetRightsResponse(Message):
    """The client, its rights, and the devices on which it may act: each right as written, such as ``act: light``."""

    issuer: str
    rights: tuple[str, ...]
    acts_on: tuple[str, ...]


GetRights: Final = ServiceType("homebot/srv/GetRights", GetRightsRequest, GetRightsResponse)


def serve(node: Node) -> None:
    """Offer the service on *node*."""
    node.create_service(GetRights, "/rosapi/rights", _answer)


def _answer(request: GetRightsRequest) -> GetRightsResponse:
    return GetRightsResponse(issuer=request.issuer, rights=request.rights, acts_on=request.scope)
