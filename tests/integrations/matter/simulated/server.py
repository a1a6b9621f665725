"""A Matter server, simulated at its WebSocket: it lists nodes, reports changes, and passes commands on.

Source: python-matter-server 8.1, ``docs/websockets_api.md`` (schema version 11).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Final, TypeAlias

import anyio
from anyio.abc import TaskStatus
from tests.simulated.http.web_server import WebDevice, WebPeer, WebServer

from homebot.house.wire import as_json, as_object

SCHEMA: Final = 11
_FAILED, _NOT_COMMISSIONED, _NOT_READY, _NO_NODE, _WRONG_ARGUMENTS, _NO_COMMAND = 0, 1, 3, 5, 8, 9


_Answer: TypeAlias = tuple[int | None, object]
"""An error code or None, and the result or the problem."""


class CommissionedNode(ABC):
    """A node, as its server sees it.

    Attributes:
        node_id: Its number in the fabric; 0 while it is not commissioned.
        setup_code: With which it can be commissioned; empty for one that is commissioned when the server reaches it.
        attributes: The values that the server knows, by path.
    """

    def __init__(self, server: SimulatedMatterServer) -> None:
        self.server = server
        self.node_id = 0
        self.is_available = False
        self.is_bridge = False
        self.setup_code = ""
        self.attributes: dict[str, object] = {}

    @abstractmethod
    def invoke(self, endpoint: int, cluster: int, command: str, payload: Mapping[str, object]) -> bool:
        """Carry out a command; return false for one that it does not have."""

    def answer(self, endpoint: int, cluster: int, command: str, payload: Mapping[str, object]) -> object:
        """Return the answer to a question; None for a command that has none."""
        del endpoint, cluster, command, payload
        return None

    @abstractmethod
    def write(self, path: str, value: object) -> bool:
        """Write an attribute; return false for one that cannot be written."""

    def update(self, attributes: Mapping[str, object]) -> None:
        """Report those *attributes*, by path, that are new."""
        for path, value in attributes.items():
            if self.attributes.get(path) != value:
                self.change(path, value)

    def change(self, path: str, value: object) -> None:
        """Report that an attribute has a new value."""
        self.attributes[path] = value
        self.server.send_event("attribute_updated", [self.node_id, path, value])

    def describe(self) -> dict[str, object]:
        """Return the node as the server lists it."""
        return {
            "node_id": self.node_id,
            "date_commissioned": "2026-01-01T00:00:00.000000",
            "last_interview": "2026-01-01T00:00:00.000000",
            "interview_version": 6,
            "available": self.is_available,
            "is_bridge": self.is_bridge,
            "attributes": self.attributes,
            "attribute_subscriptions": [],
        }


_Handler: TypeAlias = Callable[[CommissionedNode, Mapping[str, object]], _Answer]


class SimulatedMatterServer(WebDevice):
    """A server with its nodes, which it keeps when they are away.

    Attributes:
        calls: The newest 100 commands that it was given, with their arguments.
    """

    def __init__(self, address: str = "127.0.0.1", port: int = 0) -> None:
        self.server = WebServer(self, address, port)
        self.nodes: dict[int, CommissionedNode] = {}
        self.calls: list[tuple[str, Mapping[str, object]]] = []
        self._commissionable: list[CommissionedNode] = []
        self._last_node_id = 0
        self._node_commands: Mapping[str, _Handler] = {
            "get_node": lambda node, _args: (None, node.describe()),
            "remove_node": self._remove_node,
            "read_attribute": _read,
            "write_attribute": _write,
            "device_command": _invoke,
        }

    @property
    def url(self) -> str:
        """The address of its WebSocket, once it serves."""
        return f"ws://{self.server.address}:{self.server.port}/ws"

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled."""
        await self.server.serve(task_status=task_status)

    def reach(self, node: CommissionedNode) -> None:
        """Reach a node, which is commissioned now unless it waits for its setup code."""
        if node.node_id:
            self.send_event("node_updated", node.describe())
        elif node.setup_code:
            self._commissionable.append(node)
        else:
            self._commission(node)

    def miss(self, node: CommissionedNode) -> None:
        """Report that a node cannot be reached."""
        if node.node_id in self.nodes:
            self.send_event("node_updated", node.describe())
        elif node in self._commissionable:
            self._commissionable.remove(node)

    def remove(self, node: CommissionedNode) -> None:
        """Remove a node from the fabric."""
        if self.nodes.pop(node.node_id, None) is not None:
            self.send_event("node_removed", node.node_id)
            node.node_id = 0
            if node.setup_code and node.is_available:
                self._commissionable.append(node)

    def send_event(self, event: str, data: object) -> None:
        """Send an event to all listening clients."""
        frame = as_json({"event": event, "data": data})
        for peer in self.server.peers:
            if peer.name:
                peer.send(frame)

    def greet(self, peer: WebPeer, path: str) -> bool:
        """Accept a WebSocket at ``/ws`` and send the greeting."""
        peer.send(
            as_json(
                {
                    "fabric_id": 1,
                    "compressed_fabric_id": 1_234_567_890_123_456_789,
                    "schema_version": SCHEMA,
                    "min_supported_schema_version": 9,
                    "sdk_version": "2025.7.0",
                    "wifi_credentials_set": False,
                    "thread_credentials_set": False,
                    "bluetooth_enabled": False,
                }
            )
        )
        return path == "/ws"

    def receive(self, peer: WebPeer, message: bytes) -> None:
        """Run a command, and answer it."""
        frame = as_object(message)
        message_id, command, args = frame.get("message_id"), frame.get("command"), frame.get("args") or {}
        if not isinstance(message_id, str) or not isinstance(command, str) or not isinstance(args, dict):
            return
        self.calls = [*self.calls[-99:], (command, args)]
        if command == "start_listening":
            peer.name = "listener"
        code, result = self._run(command, args)
        if code is None:
            peer.send(as_json({"message_id": message_id, "result": result}))
        else:
            peer.send(as_json({"message_id": message_id, "error_code": code, "details": result}))

    def _run(self, command: str, args: Mapping[str, object]) -> _Answer:
        """Run a command; return an error code or None, and the result or the problem."""
        if command in {"start_listening", "get_nodes"}:
            return None, [node.describe() for node in self.nodes.values()]
        if command == "commission_with_code":
            return self._commission_with_code(args)
        if command not in self._node_commands:
            return _NO_COMMAND, f"Invalid Command: {command}"
        node_id = args.get("node_id")
        node = self.nodes.get(node_id) if isinstance(node_id, int) else None
        if node is None:
            return _NO_NODE, f"Node {node_id} does not exist or has not been interviewed."
        if command in {"device_command", "read_attribute", "write_attribute"} and not node.is_available:
            return _NOT_READY, f"Node {node_id} is not (yet) available."
        return self._node_commands[command](node, args)

    def _remove_node(self, node: CommissionedNode, _args: Mapping[str, object]) -> _Answer:
        self.remove(node)
        return None, None

    def _commission_with_code(self, args: Mapping[str, object]) -> _Answer:
        if not isinstance(args.get("code"), str):
            return _WRONG_ARGUMENTS, ""
        if args.get("network_only") is not True:
            return _NOT_COMMISSIONED, "Bluetooth commissioning is not available."
        for node in self._commissionable:
            if node.setup_code == args["code"]:
                self._commissionable.remove(node)
                self._commission(node)
                return None, node.describe()
        self._last_node_id += 1  # the real one uses a number up each time
        return _NOT_COMMISSIONED, f"Commission with code failed for node {self._last_node_id}."

    def _commission(self, node: CommissionedNode) -> None:
        self._last_node_id += 1
        node.node_id = self._last_node_id
        self.nodes[node.node_id] = node
        self.send_event("node_added", node.describe())


def _read(node: CommissionedNode, args: Mapping[str, object]) -> _Answer:
    paths = args.get("attribute_path")
    if not isinstance(paths, list):
        return _WRONG_ARGUMENTS, "attribute_path"
    wanted = [str(path).removesuffix("*") for path in paths]
    return None, {path: value for path, value in node.attributes.items() if path.startswith(tuple(wanted))}


def _write(node: CommissionedNode, args: Mapping[str, object]) -> _Answer:
    path, value = args.get("attribute_path"), args.get("value")
    if not isinstance(path, str):
        return _WRONG_ARGUMENTS, "attribute_path"
    return None, [{"Path": {}, "Status": 0 if node.write(path, value) else 0x88}]


def _invoke(node: CommissionedNode, args: Mapping[str, object]) -> _Answer:
    endpoint, cluster, name = args.get("endpoint_id"), args.get("cluster_id"), args.get("command_name")
    payload = args.get("payload")
    if not isinstance(endpoint, int) or not isinstance(cluster, int):
        return _WRONG_ARGUMENTS, "endpoint_id, cluster_id"
    if not isinstance(name, str) or not isinstance(payload, dict):
        return _WRONG_ARGUMENTS, "command_name, payload"
    if (answer := node.answer(endpoint, cluster, name, payload)) is not None:
        return None, answer
    if node.invoke(endpoint, cluster, name, payload):
        return None, None
    return _FAILED, "InteractionModelError: UnsupportedCommand (0x81)"
