"""A Home Assistant, simulated at its WebSocket: it lists its registries, reports states, and calls services.

Source: Home Assistant core 2024.3, ``components/websocket_api`` and ``components/config``.
"""

import secrets
import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Final, TypeAlias

import anyio
from anyio.abc import TaskStatus
from tests.simulated.http.web_server import WebDevice, WebPeer, WebServer

from homebot.house.wire import as_json, as_object

Fields: TypeAlias = Mapping[str, object]

_REGISTRIES: Final = ("area", "device", "entity", "floor", "label")


class ListedEntity(ABC):
    """An entity, as its Home Assistant sees it, which is a device by itself.

    Attributes:
        entity_id: Its id; empty before Home Assistant has it.
    """

    entity_id = ""

    def __init__(self) -> None:
        self.shown = "unavailable"
        self.attributes: dict[str, object] = {}

    @abstractmethod
    def call(self, service: str, data: Fields) -> bool:
        """Carry out a service; return false for one that it does not have."""

    @abstractmethod
    def entry(self) -> Fields:
        """Return its entry in the registry of entities."""

    @abstractmethod
    def device_entry(self) -> Fields:
        """Return the entry of its device."""


class SimulatedHomeAssistant(WebDevice):
    """A Home Assistant with its entities, which it keeps when they are away.

    Args:
        port: The port; 0 for a free one.

    Attributes:
        areas: The names of its areas, by their ids.
        floors: The names of the floors of areas, by the ids of these.
        triggers: The triggers of its devices, by the ids of these.
        calls: The newest 100 service calls.
    """

    def __init__(self, address: str = "127.0.0.1", port: int = 0) -> None:
        self.server = WebServer(self, address, port)
        self.token = secrets.token_hex(16)
        self.version = "2024.3.3"
        self.entities: dict[str, ListedEntity] = {}
        self.areas: dict[str, str] = {}
        self.floors: dict[str, str] = {}
        self.triggers: dict[str, list[Fields]] = {}
        self.calls: list[Fields] = []
        self._followed: list[tuple[WebPeer, int, list[Fields]]] = []
        self._states: dict[WebPeer, object] = {}
        self._events: dict[WebPeer, dict[str, object]] = {}
        self._greeted: set[WebPeer] = set()

    @property
    def url(self) -> str:
        """Its address, once it serves."""
        return f"http://{self.server.address}:{self.server.port}"

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled."""
        await self.server.serve(task_status=task_status)

    def reach(self, entity: ListedEntity, area: str = "") -> None:
        """Add an entity, or show that it is there again."""
        is_new = entity.entity_id not in self.entities
        self.entities[entity.entity_id] = entity
        if area:
            self.areas[area] = area
        if is_new:
            for registry in ("area", "device", "entity"):
                self.change_registry(registry)
            self.send_states({"a": {entity.entity_id: _compress(entity)}})
        else:
            self.show(entity, entity.shown, entity.attributes)

    def show(self, entity: ListedEntity, state: str, attributes: Fields) -> None:
        """Report a new state."""
        news = {key: value for key, value in attributes.items() if entity.attributes.get(key) != value}
        additions: dict[str, object] = {"s": state, "lc": time.time()} if state != entity.shown else {"lu": time.time()}
        entity.shown = state
        entity.attributes |= news
        if entity.entity_id in self.entities:
            self.send_states({"c": {entity.entity_id: {"+": additions | ({"a": news} if news else {})}}})

    def remove(self, entity: ListedEntity) -> None:
        """Remove an entity and its device."""
        if self.entities.pop(entity.entity_id, None) is not None:
            self.send_states({"r": [entity.entity_id]})
            self.change_registry("entity")
            self.change_registry("device")

    def change_registry(self, registry: str) -> None:
        """Report that a registry has changed."""
        self.tell(f"{registry}_registry_updated", {"action": "update"})

    def tell(self, kind: str, data: Fields) -> None:
        """Send an event of its bus to all that subscribed to it."""
        for peer, subscribed in self._events.items():
            if kind in subscribed and peer in self.server.peers:
                peer.send(_event(subscribed[kind], {"event_type": kind, "data": data}))

    def fire(self, trigger: Fields) -> None:
        """Fire a trigger of a device."""
        for peer, number, followed in self._followed:
            if trigger in followed and peer in self.server.peers:
                variables = {"idx": str(followed.index(trigger)), "platform": "device"}
                peer.send(_event(number, {"variables": {"trigger": variables}, "context": None}))

    def greet(self, peer: WebPeer, path: str) -> bool:
        """Accept a WebSocket and ask for a token."""
        peer.send(as_json({"type": "auth_required", "ha_version": self.version}))
        return path == "/api/websocket"

    def receive(self, peer: WebPeer, message: bytes) -> None:
        """Run a command, and answer it."""
        frame = as_object(message)
        if peer not in self._greeted:
            is_valid = frame.get("type") == "auth" and frame.get("access_token") == self.token
            if is_valid:
                self._greeted.add(peer)
            kind = {"type": "auth_ok"} if is_valid else {"type": "auth_invalid", "message": "Invalid access token"}
            peer.send(as_json({**kind, "ha_version": self.version}))
            return
        number = frame.get("id")
        if not isinstance(number, int):
            return
        error, result = self._run(peer, number, frame)
        answer = {"success": True, "result": result} if not error else {"success": False, "error": result}
        peer.send(as_json({"id": number, "type": "result", **answer}))
        if frame.get("type") == "subscribe_entities":
            self._states[peer] = number
            peer.send(_event(number, {"a": {key: _compress(entity) for key, entity in self.entities.items()}}))

    def _run(self, peer: WebPeer, number: int, frame: Fields) -> tuple[bool, object]:
        match frame.get("type"):
            case "get_config":
                return False, {"unit_system": {"temperature": "°C"}, "version": self.version, "state": "RUNNING"}
            case "auth/current_user":
                return False, {"id": "robot", "name": "homebot"}
            case "subscribe_events":
                self._events.setdefault(peer, {})[str(frame.get("event_type"))] = number
                return False, None
            case "subscribe_entities":
                return False, None
            case "call_service":
                return self._call(frame)
            case "device_automation/trigger/list":
                return False, self.triggers.get(str(frame.get("device_id")), [])
            case "subscribe_trigger":
                listed = frame.get("trigger")
                self._followed.append((peer, number, listed if isinstance(listed, list) else []))
                return False, None
            case str() as kind if kind.startswith("config/") and kind.endswith("_registry/list"):
                registry = kind.removeprefix("config/").removesuffix("_registry/list")
                if registry in _REGISTRIES:
                    return False, self._listed(registry)
        return True, {"code": "unknown_command", "message": "Unknown command."}

    def _listed(self, registry: str) -> list[Fields]:
        match registry:
            case "area":
                floors = self.floors
                return [{"area_id": key, "name": name, "floor_id": floors.get(key)} for key, name in self.areas.items()]
            case "floor":
                return [{"floor_id": name, "name": name} for name in set(self.floors.values())]
            case "device":
                return [entity.device_entry() for entity in self.entities.values()]
            case "entity":
                return [{"entity_id": key, **entity.entry()} for key, entity in self.entities.items()]
        return []

    def _call(self, frame: Fields) -> tuple[bool, object]:
        self.calls = [*self.calls[-99:], frame]
        target, data, service = frame.get("target"), frame.get("service_data") or {}, frame.get("service")
        if not isinstance(service, str) or not isinstance(data, dict):
            return True, {"code": "invalid_format", "message": "the call is invalid"}
        listed = (target if isinstance(target, dict) else data).get("entity_id")
        if not isinstance(listed, list):
            return True, {"code": "invalid_format", "message": "the call is invalid"}
        for entity_id in listed:
            entity = self.entities.get(entity_id)
            if entity is None or entity.shown == "unavailable":
                continue  # a call leaves it out, as in Home Assistant
            if (frame.get("domain"), service) == ("homeassistant", "update_entity"):
                continue  # it polls the entity, whose state is the same
            if not entity_id.startswith(f"{frame.get('domain')}.") or not entity.call(service, data):
                return True, {"code": "not_found", "message": f"Service {frame.get('domain')}.{service} not found."}
        return False, {"context": {"id": "1"}}

    def send_states(self, event: Fields) -> None:
        """Send an event to all that subscribed to states."""
        for peer, number in self._states.items():
            if peer in self.server.peers:
                peer.send(_event(number, event))


def _compress(entity: ListedEntity) -> Fields:
    return {"s": entity.shown, "a": entity.attributes, "c": "1", "lc": time.time()}


def _event(number: object, event: Fields) -> bytes:
    return as_json({"id": number, "type": "event", "event": event})
