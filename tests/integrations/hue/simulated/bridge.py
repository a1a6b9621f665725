"""A Philips Hue bridge with its devices, simulated at its HTTPS API.

It lists resources, reports changes, and passes commands on.

Source: Philips Hue, CLIP API v2 reference; the old API for its configuration and new application keys.
"""

import os
import ssl
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Final, Protocol

import anyio
import anyio.to_thread
from anyio.abc import TaskStatus
from tests.integrations.hue.simulated.resources import (
    CHANGED,
    Resource,
    bridge_resources,
    device_resources,
    group_resources,
    light_orders,
    resource_uuid,
    scene_resource,
    state_fields,
)
from tests.simulated.http.web_server import WebDevice, WebPeer, WebReply, WebRequest, WebServer

from homebot.devices.identity import in_pairs
from homebot.house.connected_device import HubDevice
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.wire import as_json, as_object, hardware_address
from homebot.integrations.hue.formats.resources import at, merged

KEY_HEADER: Final = "hue-application-key"
NAME: Final = "Hue bridge"
_EVENTS: Final = "/eventstream/clip/v2"
_RESOURCES: Final = "/clip/v2/resource"
_SCENES: Final = {"Bright": 100.0, "Dimmed": 30.0}
_CHANGEABLE: Final[Mapping[str, frozenset[str]]] = {
    "light": frozenset(
        {"on", "dimming", "color_temperature", "color", "effects", "effects_v2", "dynamics", "alert", "gradient"}
    ),
    "grouped_light": frozenset({"on", "dimming", "color_temperature", "color", "dynamics", "alert", "signaling"}),
    "device": frozenset({"metadata", "identify"}),
    "scene": frozenset({"recall", "metadata"}),
    "geofence_client": frozenset({"name", "is_at_home"}),
}
"""By type of resource: the fields that a request may change."""


class BridgedHueDevice(Protocol):
    """A device behind a bridge, as the bridge sees it."""

    device: SimulatedDeviceInfo

    def obey(self, body: Mapping[str, object]) -> None:
        """Carry out a command to its light."""


class SimulatedHueBridge(WebDevice):
    """A bridge with its devices, which it keeps when they are away.

    Args:
        tls: The server's side of TLS, with the certificate of the bridge.

    Attributes:
        keys: The application keys that it made, and that it has from the start.
        commands: The newest 100 changes that it was asked for: type, id and body.
        busy: The number of the next requests for resources that it answers with 429.
        refusal: The text with which it refuses all changes; empty for none.
    """

    def __init__(self, home: str, tls: ssl.SSLContext, address: str = "127.0.0.1", port: int = 0) -> None:
        digits = hardware_address(SimulatedDeviceInfo(home, "bridge", NAME, "bridge", ""))
        self.id = f"{digits[:6]}fffe{digits[6:]}"
        self.server = WebServer(self, address, port, tls)
        self.resources: dict[str, Resource] = {}
        self.keys: set[str] = set()
        self.commands: list[tuple[str, str, Mapping[str, object]]] = []
        self.busy = 0
        self.refusal = ""
        self._is_pressed = False
        self._devices: dict[str, BridgedHueDevice] = {}
        self._events = 0
        for resource in (*bridge_resources(self.id, NAME), *group_resources("bridge_home", home, (), "")):
            self.resources[str(resource["id"])] = resource

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled."""
        await self.server.serve(task_status=task_status)

    def press_button(self) -> None:
        """Press its button: the next program that asks for a key gets one."""
        self._is_pressed = True

    def add(self, resources: list[Resource], device: BridgedHueDevice | None = None, room: str = "") -> None:
        """Add a device with its services, or bring one back; into a room, whose scenes light its lamps."""
        if device is not None:
            self._devices.update({str(resource["id"]): device for resource in resources})
        if str(resources[0]["id"]) in self.resources:
            for resource in resources:
                self.change(
                    str(resource["id"]), {name: resource[name] for name in resource.keys() - {"id", "type", "owner"}}
                )
            return
        for resource in resources:
            self.resources[str(resource["id"])] = resource
        self._send("add", resources)
        if room:
            self._furnish(room)

    def remove(self, resource_ids: list[str]) -> None:
        """Remove resources."""
        gone = [self.resources.pop(rid) for rid in resource_ids if rid in self.resources]
        self._send("delete", [{"id": resource["id"], "type": resource["type"]} for resource in gone])

    def change(self, rid: str, fields: Mapping[str, object]) -> None:
        """Report the fields of a resource, if it is still there, that are different now."""
        resource = self.resources.get(rid, {})
        now = merged(resource, fields)
        changed = {name: now[name] for name in fields if resource.get(name) != now[name]}
        if resource and changed:
            resource |= changed
            about = {name: resource[name] for name in ("id", "type", "owner") if name in resource}
            self._send("update", [about | changed])

    def press(self, rid: str, event: str, updated: str = CHANGED) -> None:
        """Report an event of a button."""
        report = {"button_report": {"updated": updated, "event": event}, "last_event": event}
        resource = self.resources[rid]
        self._send("update", [{"id": rid, "type": resource["type"], "owner": resource["owner"], "button": report}])

    def send_text(self, text: str) -> None:
        """Send a text to all programs that listen to events."""
        for peer in self.server.peers:
            peer.send(text.encode())

    def greet(self, peer: WebPeer, path: str) -> bool:
        """Accept a stream of events from a program with a key."""
        if path != _EVENTS or peer.headers.get(KEY_HEADER) not in self.keys:
            return False
        peer.send(b": hi")
        return True

    def answer(self, request: WebRequest) -> WebReply:
        """Return the answer to a request of HTTP."""
        if request.path in {"/api/config", "/api/0/config"}:
            about = {"name": NAME, "bridgeid": self.id.upper(), "modelid": "BSB002"}
            about |= {"mac": in_pairs(self.id[:6] + self.id[10:]), "swversion": "1968096020", "apiversion": "1.68.0"}
            return WebReply(as_json(about))
        if request.path == "/api" and request.method == "POST":
            return self._make_key(request.body)
        if request.headers.get(KEY_HEADER) not in self.keys:
            return _answer(403, error="unauthorized user")
        if not request.path.startswith(_RESOURCES):
            return _answer(404, error="Not Found")
        if self.busy:
            self.busy -= 1
            return _answer(429, error="too many requests")
        kind, _, rid = request.path.removeprefix(_RESOURCES).strip("/").partition("/")
        match request.method:
            case "GET":
                resources = [
                    resource
                    for own, resource in self.resources.items()
                    if kind in {"", resource["type"]} and rid in {"", own}
                ]
                if rid and not resources:
                    return _answer(404, error="resource not found")
                return _answer(200, resources)
            case "PUT":
                return self._obey(kind, rid, request.body)
            case "POST" if kind == "geofence_client":
                made = {"id": resource_uuid(kind, str(len(self.resources))), "type": kind, **as_object(request.body)}
                self.add([made])
                return _answer(201, [{"rid": made["id"], "rtype": kind}])
            case _:
                return _answer(405, error="Method Not Allowed")

    def _make_key(self, body: bytes) -> WebReply:
        name = as_object(body).get("devicetype")
        if not isinstance(name, str) or not 0 < len(name) <= 40:
            return WebReply(as_json([{"error": {"type": 6, "address": "", "description": "parameter not available"}}]))
        if not self._is_pressed:
            problem = {"type": 101, "address": "", "description": "link button not pressed"}
            return WebReply(as_json([{"error": problem}]))
        self._is_pressed = False
        key = resource_uuid(self.id, name, str(len(self.keys)))
        self.keys.add(key)
        return WebReply(as_json([{"success": {"username": key}}]))

    def _obey(self, kind: str, rid: str, payload: bytes) -> WebReply:
        resource, body = self.resources.get(rid), as_object(payload)
        if resource is None or resource["type"] != kind:
            return _answer(404, error="resource not found")
        if unknown := body.keys() - _CHANGEABLE.get(kind, frozenset()):
            return _answer(400, error=f"invalid value for parameter {min(unknown)}")
        if self.refusal:
            return _answer(207, error=self.refusal)
        self.commands = [*self.commands[-99:], (kind, rid, body)]
        done: list[Resource] = [{"rid": rid, "rtype": kind}]
        match kind:
            case "scene":
                self._end_scenes()
                actions = resource["actions"]
                for action in actions if isinstance(actions, list) else ():
                    if action["target"]["rid"] in self.resources:
                        self._light(action["target"]["rid"], action["action"], [])
                self.change(str(resource["id"]), {"status": {"active": "static", "last_recall": CHANGED}})
            case "light":
                return self._light(rid, body, done)
            case "grouped_light":
                self._group(resource, body)
            case "geofence_client":
                self.change(rid, body)
        return _answer(200, done)

    def _light(self, rid: str, body: Mapping[str, object], done: list[Resource]) -> WebReply:
        device = self._devices.get(rid)
        owner = self.resources[rid].get("owner")
        radio = [
            resource
            for resource in self.resources.values()
            if resource["type"] == "zigbee_connectivity" and resource["owner"] == owner
        ]
        if device is None or any(service["status"] != "connected" for service in radio):
            problem = "device (light) has communication issues, command (.on) may not have effect"
            return _answer(207, done, problem)
        device.obey(body)
        self._end_scenes()
        return _answer(200, done)

    def _group(self, grouped: Resource, body: Mapping[str, object]) -> None:
        children = self.resources[str(at(grouped, "owner", "rid"))]["children"]
        inside = {at(child, "rid") for child in children} if isinstance(children, list) else set()
        for rid, light in tuple(self.resources.items()):
            if light["type"] == "light" and not inside.isdisjoint((rid, at(light, "owner", "rid"))):
                self._light(rid, body, [])
        self.change(str(grouped["id"]), {"on": body["on"]} if "on" in body else {})

    def _end_scenes(self) -> None:
        for rid, resource in self.resources.items():
            if resource["type"] == "scene":
                self.change(rid, {"status": {"active": "inactive"}})

    def _furnish(self, room: str) -> None:
        """Describe a room, and its scenes, by the devices in it."""
        inside = {rid: device for rid, device in self._devices.items() if device.device.room == room}
        children = [(rid, "device") for rid in inside if self.resources[rid]["type"] == "device"]
        lights = [rid for rid in inside if self.resources[rid]["type"] == "light"]
        resources = group_resources("room", room, children, "other")
        resources += [scene_resource(room, name, lights, level) for name, level in _SCENES.items() if lights]
        new = [resource for resource in resources if resource["id"] not in self.resources]
        self.resources.update({str(resource["id"]): resource for resource in new})
        if new:
            self._send("add", new)
        for resource in resources:
            self.change(
                str(resource["id"]), {name: resource[name] for name in ("children", "actions") if name in resource}
            )

    def _send(self, kind: str, data: list[Resource]) -> None:
        self._events += 1
        event_id = resource_uuid(self.id, "event", str(self._events))
        events = [{"creationtime": CHANGED, "data": data, "id": event_id, "type": kind}]
        self.send_text(f"id: {self._events}:0\ndata: {as_json(events).decode()}")


def _answer(status: int, data: list[Resource] | None = None, error: str = "") -> WebReply:
    errors = [{"description": error}] if error else []
    return WebReply(as_json({"data": data or [], "errors": errors}), status)


@asynccontextmanager
async def paired_bridge(address: str, port: int, pairings: Path) -> AsyncIterator[SimulatedHueBridge]:
    """Keep a bridge on the network inside the block that homebot is paired with, by the file *pairings*."""
    tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    bridge = SimulatedHueBridge("house", tls, address, port)
    certificate = await anyio.to_thread.run_sync(make_certificate, bridge.id, tls)
    key = resource_uuid(bridge.id, "homebot")
    bridge.keys.add(key)
    kept = {"name": NAME, "origin": f"https://{address}:{port}", "key": key, "certificate": certificate}
    await anyio.to_thread.run_sync(_write_secret, pairings, as_json({bridge.id: kept}))
    try:
        async with anyio.create_task_group() as tasks:
            await tasks.start(bridge.serve)
            yield bridge
            tasks.cancel_scope.cancel()
    finally:
        with anyio.CancelScope(shield=True):
            await anyio.to_thread.run_sync(pairings.unlink)


def make_certificate(name: str, tls: ssl.SSLContext) -> str:
    """Make a certificate by an authority that no computer knows, for the server's side *tls*; return it in PEM."""
    import trustme  # noqa: PLC0415 - loads 60 modules

    leaf = trustme.CA(organization_name="homebot").issue_cert(common_name=name)
    leaf.configure_cert(tls)
    pem: bytes = leaf.cert_chain_pems[0].bytes()
    return pem.decode()


def _write_secret(path: Path, content: bytes) -> None:
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(content)


class HueHouseDevice(HubDevice):
    """A lamp or sensor of the house in the radio network of a bridge.

    Args:
        kind: Its kind at the bridge, where it is another: ``plug`` for a lamp at a plug, ``gradient`` for one with
            several colours.
    """

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        on_command: Callable[[str], None],
        bridge: SimulatedHueBridge,
        kind: str = "",
    ) -> None:
        super().__init__(device, on_command)
        self.kind = kind or device.kind
        self._bridge = bridge

    @property
    def owner_id(self) -> str:
        """The id of its device."""
        return resource_uuid(self.device.home, self.device.device_id)

    def resource_id(self, service: str) -> str:
        """Return the id of one of its services."""
        return resource_uuid(self.device.home, self.device.device_id, service)

    async def join(self) -> None:
        """Have the bridge reach it."""
        self._bridge.add(device_resources(self.device, self.kind, self.state), self, self.device.room)

    def leave(self) -> None:
        """Have the bridge miss it."""
        self._bridge.change(self.resource_id("zigbee_connectivity"), {"status": "connectivity_issue"})

    def show(self) -> None:
        """Report the fields that have changed."""
        if not self.is_there:
            return
        for rid, resource in tuple(self._bridge.resources.items()):
            owner = resource.get("owner")
            if isinstance(owner, dict) and owner.get("rid") == self.owner_id:
                service = str(resource["type"])
                fields = state_fields(service, self.kind, self.state)
                if service == "light" and self.kind != "plug":
                    now = self._bridge.resources[rid]["color_temperature"]
                    has_color = isinstance(now, dict) and now.get("mirek_valid") is False  # which no state tells
                    if has_color:
                        fields["color_temperature"] = now
                self._bridge.change(rid, fields)

    def obey(self, body: Mapping[str, object]) -> None:
        """Carry out a command to its light; the house knows nothing of colours and effects."""
        changed: Resource = {}
        points = at(body, "gradient", "points")
        color = at(points[0] if isinstance(points, list) and points else body, "color")
        if "gradient" in self._bridge.resources[self.resource_id("light")] and (color or "color_temperature" in body):
            changed["gradient"] = body.get("gradient", {"points": []})
        if color:
            changed |= {"color": color, "color_temperature": {"mirek": None, "mirek_valid": False}}
        elif "color_temperature" in body:
            changed["color_temperature"] = {"mirek_valid": True}
        if effect := at(body, "effects_v2", "action", "effect") or at(body, "effects", "effect"):
            changed |= {"effects": {"status": effect}, "effects_v2": {"status": {"effect": effect}}}
        self._bridge.change(self.resource_id("light"), changed)
        for order in light_orders(body):
            self.on_command(order)
