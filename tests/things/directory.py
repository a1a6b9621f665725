"""A directory of Thing Descriptions: registrations, lists in pages, and events of changes.

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, section 7.3.2.
"""

from collections.abc import Mapping

import anyio
from anyio.abc import TaskStatus
from tests.simulated.http.web_server import WebPeer, WebReply, WebRequest, WebServer

from homebot.house.wire import as_json, json_value
from homebot.support.numbers import to_number

TD_TYPE = "application/td+json"
LD_TYPE = "application/ld+json"
PREFIX = "/things/"


class ThingDirectoryServer:
    """A directory independent of homebot; any client may register things.

    Args:
        address: The address to listen on.
        port: The port; 0 for a free one, which it keeps.
        has_events: Whether it serves change events.
        page: The most things on one page.
        token: The bearer token that it wants; empty for none.

    Attributes:
        server: Its server.
        things: The descriptions, by id.
    """

    def __init__(
        self,
        address: str = "127.0.0.1",
        port: int = 0,
        *,
        has_events: bool = True,
        page: int = 100,
        token: str = "",
    ) -> None:
        self.server = WebServer(self, address, port)
        self.things: dict[str, Mapping[str, object]] = {}
        self._has_events = has_events
        self._page = page
        self._token = token

    @property
    def url(self) -> str:
        """Its address; it is known once it serves."""
        return f"http://{self.server.address}:{self.server.port}"

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Be on the network until cancelled."""
        await self.server.serve(task_status=task_status)

    def register(self, description: Mapping[str, object]) -> None:
        """Add or replace a description."""
        thing_id = str(description["id"])
        change = "thing_updated" if thing_id in self.things else "thing_created"
        self.things[thing_id] = description
        self._send_event(change, description if change == "thing_created" else {"id": thing_id})

    def delete(self, thing_id: str) -> None:
        """Remove a thing."""
        if self.things.pop(thing_id, None) is not None:
            self._send_event("thing_deleted", {"id": thing_id})

    def answer(self, request: WebRequest) -> WebReply:
        """Return the answer to a request of HTTP."""
        if not self._lets_in(request.headers):
            return WebReply(b"", 401, headers={"WWW-Authenticate": "Bearer"})
        if request.path == "/things" and request.method == "GET":
            return self._listed(request)
        thing_id = request.path.removeprefix(PREFIX)
        if not request.path.startswith(PREFIX):
            return WebReply(b"", 404)
        known = thing_id in self.things
        match request.method:
            case "PUT":
                return self._registered(thing_id, request.body)
            case "DELETE" if known:
                self.delete(thing_id)
                return WebReply(b"", 204)
            case "GET" if known:
                return WebReply(as_json(self.things[thing_id]), content_type=TD_TYPE)
            case _:
                return WebReply(b"", 404)

    def greet(self, peer: WebPeer, path: str) -> bool:
        """Subscribe a peer to changes."""
        if not (self._has_events and peer.takes_events and path == "/events" and self._lets_in(peer.headers)):
            return False
        peer.send(b": welcome")
        return True

    def receive(self, peer: WebPeer, message: bytes) -> None:
        """Do nothing: it has no WebSockets."""

    def _listed(self, request: WebRequest) -> WebReply:
        wanted, offset = (to_number(request.query.get(name)) or 0 for name in ("limit", "offset"))
        limit = min(int(wanted) or self._page, self._page)
        begin = int(offset)
        body = as_json(list(self.things.values())[begin : begin + limit])
        headers = {}
        if begin + limit < len(self.things):
            headers["Link"] = f'</things?offset={begin + limit}&limit={limit}>; rel="next"'
        return WebReply(body, content_type=LD_TYPE, headers=headers)

    def _registered(self, thing_id: str, body: bytes) -> WebReply:
        description = json_value(body)
        if not isinstance(description, dict) or description.get("id", thing_id) != thing_id:
            return WebReply(b"", 400)
        is_new = thing_id not in self.things
        self.register({**description, "id": thing_id})
        return WebReply(b"", 201 if is_new else 204)

    def _send_event(self, change: str, fields: Mapping[str, object]) -> None:
        for peer in self.server.peers:
            peer.send(f"event: {change}\ndata: ".encode() + as_json(fields))

    def _lets_in(self, headers: Mapping[str, str]) -> bool:
        return not self._token or headers.get("authorization") == f"Bearer {self._token}"
