"""Things that describe themselves over HTTP; their properties are read, written, and pushed as server-sent events.

Source: W3C Recommendations "Web of Things (WoT) Thing Description 1.1" and "Web of Things (WoT) Discovery".
"""

import json
from base64 import b64encode
from collections.abc import Callable, Mapping

from tests.simulated.dns_sd import DnsSdService
from tests.simulated.http.served_web_device import ServedWebDevice
from tests.simulated.http.web_server import WebPeer, WebReply, WebRequest
from tests.things.properties import THING_PROPERTIES, ThingProperty

from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.wire import as_json, hardware_address, json_value

TD_TYPE = "application/td+json"
WELL_KNOWN = "/.well-known/wot"
CONTEXTS = ["https://www.w3.org/2022/wot/td/v1.1", "https://webthings.io/schemas"]


class ServedThing(ServedWebDevice):
    """One thing.

    Args:
        token: Required bearer token; empty for none.
        user: With a user, *token* is the password of HTTP Basic authentication.
    """

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        on_command: Callable[[str], None],
        *,
        address: str = "127.0.0.1",
        announced: bool = False,
        token: str = "",
        user: str = "",
    ) -> None:
        super().__init__(device, on_command, address=address, announced=announced)
        self._type, self._properties = THING_PROPERTIES.get(device.kind, ("", {}))
        self._login = ""
        if user:
            self._login = f"Basic {b64encode(f'{user}:{token}'.encode()).decode()}"
        elif token:
            self._login = f"Bearer {token}"
        self._last: dict[str, object] = {}

    def service(self) -> DnsSdService:
        """Return its announced service."""
        name, host = self.device.device_id, f"thing-{hardware_address(self.device)[-6:]}"
        text = {"td": WELL_KNOWN, "type": "Thing", "scheme": "http"}
        return DnsSdService("_wot._tcp.local.", name, host, self.server.port, text)

    @property
    def origin(self) -> str:
        """The beginning of its addresses; it is known once it serves."""
        return f"http://{self.server.address}:{self.server.port}"

    def description(self) -> dict[str, object]:
        """Return its Thing Description; the address in it is known once it serves."""
        scheme = "basic" if self._login.startswith("Basic") else "bearer" if self._login else "nosec"
        return {
            "@context": CONTEXTS,
            "@type": [self._type] if self._type else [],
            "id": f"urn:dev:mac:{hardware_address(self.device)}",
            "title": self.device.device_id,
            "base": f"{self.origin}/",
            "securityDefinitions": {"access": {"scheme": scheme}},
            "security": "access",
            "properties": {name: self._described(name, one) for name, one in self._properties.items()},
        }

    def show(self) -> None:
        """Push new values to observers."""
        now = {name: one.read(self.state) for name, one in self._properties.items()}
        changed = {name for name, value in now.items() if self._last.get(name) != value}
        self._last = now
        for peer in self.server.peers:
            if peer.name in changed:
                peer.send(_event(peer.name, now[peer.name]))

    def answer(self, request: WebRequest) -> WebReply:
        """Return the answer to a request of HTTP."""
        path = request.path.rstrip("/")
        if path == WELL_KNOWN:
            return WebReply(as_json(self.description()), content_type=TD_TYPE)
        if not self._lets_in(request.headers):
            return WebReply(b"", 401, headers={"WWW-Authenticate": self._login.partition(" ")[0]})
        name = path.removeprefix("/properties/")
        if name == path or name not in self._properties:
            return WebReply(b"", 404)
        return self._answer_property(self._properties[name], request)

    def _answer_property(self, one: ThingProperty, request: WebRequest) -> WebReply:
        if request.method == "GET":
            return WebReply(as_json(one.read(self.state)))
        orders = one.order(json_value(request.body)) if one.order is not None and request.method == "PUT" else None
        for text in orders or ():
            self.on_command(text)
        return WebReply(b"", 400 if orders is None else 204)

    def greet(self, peer: WebPeer, path: str) -> bool:
        """Accept an observer of a property."""
        name = path.removeprefix("/properties/")
        if not peer.takes_events or name not in self._properties or not self._lets_in(peer.headers):
            return False
        peer.name = name
        peer.send(_event(name, self._properties[name].read(self.state)))
        return True

    def receive(self, peer: WebPeer, message: bytes) -> None:
        """Do nothing: it has no WebSockets."""

    def _lets_in(self, headers: Mapping[str, str]) -> bool:
        return not self._login or headers.get("authorization") == self._login

    def _described(self, name: str, one: ThingProperty) -> dict[str, object]:
        path = f"properties/{name}"
        ops = ["readproperty", "writeproperty"] if one.order is not None else ["readproperty"]
        forms: list[dict[str, object]] = [
            {"href": path, "op": ops},
            {"href": path, "op": ["observeproperty", "unobserveproperty"], "subprotocol": "sse"},
        ]
        return {**one.schema, "title": name, "readOnly": one.order is None, "observable": True, "forms": forms}


def _event(name: str, value: object) -> bytes:
    return f"event: {name}\ndata: {json.dumps(value)}".encode()
