"""Shelly devices of the second generation and later, on the network by themselves.

A device answers calls on a WebSocket at ``/rpc`` and by HTTP at ``/rpc`` and ``/rpc/METHOD``, describes itself at
``/shelly``, and sends changes to every WebSocket that has called it. Its frames are those of MQTT.

Source: Shelly Gen2+ API, General: RPC Protocol, RPC Channels, Authentication; Overview, Common Device Traits.
"""

import hashlib
import json
from collections.abc import Callable, Mapping

from tests.simulated.dns_sd import DnsSdService
from tests.simulated.http.served_web_device import ServedWebDevice
from tests.simulated.http.web_server import WebPeer, WebReply, WebRequest

from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.wire import as_json, as_object, json_value
from homebot.integrations.shelly.simulated.rpc_dialect import ShellyRpcDialect, describe_shelly

UNAUTHORIZED = 401
ALGORITHM = "SHA-256"
NONCE = 1625038762
OPEN_METHODS = frozenset({"Shelly.GetDeviceInfo"})


class ServedShelly(ServedWebDevice):
    """A dimmer or a cover."""

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        on_command: Callable[[str], None],
        *,
        address: str = "127.0.0.1",
        announced: bool = False,
        password: str = "",
    ) -> None:
        super().__init__(device, on_command, address=address, announced=announced)
        self.refused_calls = 0
        self._dialect = ShellyRpcDialect()
        self._password = password
        self._count: int | None = None  # that of the last signed call; None before the first challenge

    @property
    def id(self) -> str:
        """Its id: ``shellydimmerg3-02aabbccddee``."""
        return str(describe_shelly(self.device)["id"])

    def service(self) -> DnsSdService:
        """Return its announced service."""
        about = describe_shelly(self.device)
        text = {name: str(about[name]) for name in ("gen", "app", "ver")}
        return DnsSdService("_shelly._tcp.local.", self.id, self.id, self.server.port, text)

    def show(self) -> None:
        """Send the state to every WebSocket that has called."""
        for message in self._dialect.state_messages(self.device, self.state):
            frame = dict(as_object(message.payload))
            for peer in self.server.peers:
                if peer.name:
                    peer.send(as_json({**frame, "dst": peer.name}))

    def answer(self, request: WebRequest) -> WebReply:
        """Return the answer to a request of HTTP."""
        if request.path == "/shelly":
            return WebReply(as_json(self._about()))
        if request.path == "/rpc" and request.method == "POST":
            call = as_object(request.body)
            return self._answer_http({"src": "user", **call}, whole=True)
        if request.path.startswith("/rpc/"):
            params = dict(as_object(request.body)) or {name: _parse(text) for name, text in request.query.items()}
            call = {"id": 1, "src": "user", "method": request.path.removeprefix("/rpc/"), "params": params}
            return self._answer_http(call, whole=False)
        return WebReply(b"Not Found", 404, "text/plain")

    def greet(self, peer: WebPeer, path: str) -> bool:
        """Accept a WebSocket to ``/rpc``."""
        del peer
        return path == "/rpc"

    def receive(self, peer: WebPeer, message: bytes) -> None:
        """Run a call, and answer it."""
        call = as_object(message)
        if not isinstance(call.get("src"), str):
            return
        peer.name = str(call["src"])
        if self._password and call.get("method") not in OPEN_METHODS and not self._is_signed(call.get("auth")):
            self.refused_calls += 1
            self._count = 0
            challenge = {"auth_type": "digest", "nonce": NONCE, "nc": 1, "realm": self.id, "algorithm": ALGORITHM}
            error = {"code": UNAUTHORIZED, "message": json.dumps(challenge)}
            peer.send(as_json({"id": call.get("id"), "src": self.id, "dst": call.get("src"), "error": error}))
            return
        for answer in self._run(call):
            peer.send(as_json(answer))

    def _run(self, call: Mapping[str, object]) -> list[Mapping[str, object]]:
        payload = as_json(call)
        for command in self._dialect.parse_command(self.device, "", payload):
            self.on_command(command)
        replies = self._dialect.replies(self.device, self.state, "", payload)
        answers = [dict(as_object(reply.payload)) for reply in replies]
        for answer in answers:
            result = answer.get("result")
            if call.get("method") == "Shelly.GetDeviceInfo" and isinstance(result, dict):
                answer["result"] = {**result, **self._about()}
        return list(answers)

    def _about(self) -> dict[str, object]:
        has_password = bool(self._password)
        return {
            **describe_shelly(self.device),
            "auth_en": has_password,
            "auth_domain": self.id if has_password else None,
        }

    def _is_signed(self, auth: object) -> bool:
        """Return whether *auth* correctly answers the last challenge with an unused count."""
        if not isinstance(auth, dict):
            return False
        count = auth.get("nc", 1)
        if self._count is None or auth.get("nonce") != NONCE or not isinstance(count, int) or count <= self._count:
            return False
        secret = _hash("admin", self.id, self._password)
        request = _hash("dummy_method", "dummy_uri")
        right = _hash(secret, str(NONCE), str(count), str(auth.get("cnonce")), "auth", request)
        if auth.get("response") != right:
            return False
        self._count = count
        return True

    def _answer_http(self, call: Mapping[str, object], *, whole: bool) -> WebReply:
        if self._password and call.get("method") not in OPEN_METHODS:
            self.refused_calls += 1
            return WebReply(b"", UNAUTHORIZED, "text/plain")
        (answer,) = self._run(call) or [{}]
        if whole:
            return WebReply(as_json(answer))
        if "error" in answer:
            return WebReply(as_json(answer["error"]), 404)
        return WebReply(as_json(answer.get("result")))


def _hash(*texts: str) -> str:
    return hashlib.sha256(":".join(texts).encode()).hexdigest()


def _parse(text: str) -> object:
    value = json_value(text.encode(errors="replace"))
    return text if value is None and text != "null" else value
