"""The Matter gateway: the nodes of a Matter server, over its WebSocket."""

from collections.abc import Awaitable, Callable, Collection, Iterator
from functools import partial
from typing import Annotated, ClassVar, Final
from urllib.parse import urlsplit

import anyio.lowlevel
from pydantic import BaseModel, ConfigDict, Field, field_validator

from homebot.conventions.payload import as_fields, shown
from homebot.devices.gateway_messages import Command
from homebot.devices.names import GatewayNames
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, PeerError, RefusedError, UnableError, WireError
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import GatewayContext, GatewaySettings
from homebot.gateways.linked_gateway import LinkedGateway
from homebot.gateways.pairing import ActingGateway, PairingRequests, PairingServices, PairResponse, UnpairedDevice
from homebot.graph import Node
from homebot.integrations.matter.formats.ecosystem import check_matter_setup_code
from homebot.integrations.matter.formats.endpoint import DESCRIPTOR, MatterEndpoint
from homebot.integrations.matter.formats.light_clusters import joint_orders
from homebot.integrations.matter.formats.parts import parts_of
from homebot.integrations.matter.formats.scenes import SCENES
from homebot.integrations.matter.formats.sensor_clusters import SWITCH, press_of
from homebot.integrations.matter.gateway.node import BASIC, BRIDGED, MatterNode, NodeDevice, node_id_of, parse_path
from homebot.integrations.matter.gateway.scene_reader import SceneReader
from homebot.integrations.matter.gateway.server_link import MAX_FRAME_BYTES, MatterServerLink, check_result
from homebot.messages.message import Message, ServiceType
from homebot.plugins import check_extra


class CommissionRequest(Message):
    """Request to commission the device that has a setup code.

    Attributes:
        code: The setup code, as the QR code or the digits on the device say it; a secret, which is passed on and
            forgotten: no text shows it.
        network_only: Whether the device is looked for on the local network alone, if it has an address already;
            false looks for it over Bluetooth as well, if the gateway can do that.
    """

    model_config = ConfigDict(hide_input_in_errors=True)

    code: Annotated[str, Field(repr=False, min_length=1, max_length=255)]
    network_only: bool = True


class DecommissionRequest(Message):
    """Request to remove a device from the network of a gateway; it needs its setup code to come back.

    Attributes:
        key: The gateway's key of the device.
    """

    key: str


Commission = ServiceType("homebot/srv/Commission", CommissionRequest, PairResponse)
Decommission = ServiceType("homebot/srv/Decommission", DecommissionRequest, PairResponse)


class CommissioningNames:
    """The graph names of a gateway that commissions devices, beside those that every gateway has.

    Attributes:
        commission: Service :data:`Commission`.
        decommission: Service :data:`Decommission`.
    """

    def __init__(self, gateway: str) -> None:
        self.commission = f"{GatewayNames(gateway).node}/commission"
        self.decommission = f"{GatewayNames(gateway).node}/decommission"


def serve_commissioning(
    node: Node,
    gateway: ActingGateway,
    add: Callable[[CommissionRequest], Awaitable[tuple[str, str]]],
    remove: Callable[[str], Awaitable[tuple[str, str]]],
) -> None:
    """Serve :class:`CommissioningNames`: *add* and *remove* return key and name, and raise LinkError or PeerError."""
    names, additions, removals = CommissioningNames(node.name), PairingRequests(gateway), PairingRequests(gateway)

    async def commission(request: CommissionRequest) -> PairResponse:
        return await additions.answer("commissioning", partial(add, request))

    async def decommission(request: DecommissionRequest) -> PairResponse:
        return await removals.answer("removing it", partial(remove, request.key))

    node.create_service(Commission, names.commission, commission, concurrent=True)
    node.create_service(Decommission, names.decommission, decommission, concurrent=True)


COMMISSIONS_WITHIN: Final = 180.0
REMOVES_WITHIN: Final = 120.0
"""In seconds; the server looks for a device for 30 seconds, and tries three times to read all of its attributes."""

_NOT_COMMISSIONED, _NOT_INTERVIEWED = 1, 2
_PROBLEMS: Final = {
    _NOT_COMMISSIONED: "no device could be commissioned with this code; is it in pairing mode and on this network, "
    "and not commissioned already?",
    _NOT_INTERVIEWED: "the device was commissioned, but its attributes could not be read",
}
"""By error code; the details of the server say less, and could repeat the setup code."""


class MatterGatewaySettings(GatewaySettings):
    """The settings of a Matter gateway.

    Attributes:
        url: The WebSocket of the Matter server.
        max_nodes: Most known nodes; further ones are refused and counted.
    """

    url: str = "ws://127.0.0.1:5580/ws"
    max_nodes: Annotated[int, Field(ge=1, le=10_000)] = 500

    @field_validator("url")
    @classmethod
    def _check_url(cls, url: str) -> str:
        address = urlsplit(url)  # raises ValueError itself
        if address.scheme not in {"ws", "wss", "http", "https"} or not address.hostname:
            raise ValueError("the address of a Matter server is written like ws://127.0.0.1:5580/ws")
        if address.username is not None or address.password is not None:
            raise ValueError("a Matter server has no user and no password; leave them out")
        return url


class MatterGateway(LinkedGateway):
    """Brings the nodes of a Matter server onto the graph."""

    Settings: ClassVar[type[BaseModel]] = MatterGatewaySettings
    peer = "the Matter server"
    _link: MatterServerLink

    def __init__(self, node: Node, settings: MatterGatewaySettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._settings = settings
        self._nodes: dict[int, MatterNode] = {}
        self._node_of: dict[str, MatterNode] = {}
        self._missed: set[int] = set()
        self._scenes = SceneReader(self, self._on_scenes)
        self.devices = PublishedDevices(self, self._perform, settings, refresh=self._refresh)
        serve_commissioning(node, self, self._commission, self._decommission)
        PairingServices(self, node)

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Check the library."""
        del settings
        check_extra('the gateway "matter"', "matter", "aiohttp")

    async def connect(self) -> None:
        """Connect, and follow the server until the link is lost."""
        from homebot.gateways.http_client import HttpClient  # noqa: PLC0415 - only where it runs

        async with (
            HttpClient(guard=None) as client,
            client.websocket(self._settings.url, max_bytes=MAX_FRAME_BYTES) as socket,
        ):
            self._link = self._scenes.link = MatterServerLink(socket, self._on_nodes, self._on_event, self.on_invalid)
            await self._link.run()

    async def _on_nodes(self, listed: object) -> None:
        if not isinstance(listed, list):
            raise WireError(f"the list of nodes is {shown(listed)}, not a list")
        present: set[int] = set()
        for fields in listed:
            try:
                present.add(node_id_of(as_fields(fields).get("node_id")))
                await self._add_node(fields, "the Matter server listed it")
            except WireError as exc:
                self.devices.reject(self.peer, b"", str(exc))
            await anyio.lowlevel.checkpoint()
        for node_id in self._nodes.keys() - present:
            self._remove_node(node_id, "the Matter server no longer has it")
        self.on_link()

    async def _on_event(self, event: str, data: object, payload: bytes) -> None:
        await anyio.lowlevel.checkpoint()
        source = self._source_of(data)
        try:
            match event:
                case "node_added" | "node_updated":
                    await self._add_node(data, "the Matter server reported it")
                case "node_removed":
                    self._remove_node(node_id_of(data), "it was removed from the Matter server")
                case "attribute_updated" if self.devices.admits(source):
                    await self._on_attribute(data, payload)
                case "attribute_updated" if source in self._node_of:
                    self._missed.add(self._node_of[source].id)  # it is read later
                case "node_event" if self.devices.admits(source):
                    await self._on_node_event(data, payload)
                case "endpoint_removed":
                    removed = as_fields(data)
                    node, number = self._nodes.get(node_id_of(removed.get("node_id"))), removed.get("endpoint_id")
                    if node is not None and isinstance(number, int) and node.endpoints.pop(number, None) is not None:
                        self._describe(node, "an endpoint was removed")
                case "server_shutdown":
                    raise LinkError("the Matter server was shut down")
                case _:
                    pass  # endpoint_added comes with node_updated; others are about the server
        except WireError as exc:
            self.devices.reject(source, payload, str(exc))

    def _source_of(self, data: object) -> str:
        """Return the source of an event: the key of the node, if it is known."""
        node_id: object = data
        if isinstance(data, list):
            node_id = data[0] if data else None
        elif isinstance(data, dict):
            node_id = data.get("node_id")
        known = self._nodes.get(node_id) if isinstance(node_id, int) else None
        return shown(node_id) if known is None else known.published[0].device.key

    async def _add_node(self, data: object, why: str) -> None:
        node = MatterNode.parse(data)
        if node.id in self._nodes:
            node.published = self._nodes[node.id].published
        elif len(self._nodes) >= self._settings.max_nodes:
            self.devices.counters.devices_refused += 1
            return
        self._nodes[node.id] = node
        self._scenes.look_at(node)
        self._describe(node, why)
        for published in node.published:
            for part in published.rows:
                await self._report(published, part, None, is_old=not node.is_available)

    def _describe(self, node: MatterNode, why: str) -> None:
        """Publish the devices of a node, and remove those that it no longer has."""
        before = node.published
        node.published = node.devices(self._link.fabric)
        for gone in {published.device.key for published in before} - {
            published.device.key for published in node.published
        }:
            self._node_of.pop(gone, None)
            self.devices.remove(gone, "its bridge no longer has it")
        for published in node.published:
            self._node_of[published.device.key] = node
            self.devices.put(published.device, why, confirmed=node.is_available)
            self.devices.report_reachable(published.device.key, reachable=node.is_reachable(published))

    def _on_scenes(self, node: MatterNode) -> None:
        if self._nodes.get(node.id) is node:
            self._describe(node, "its scenes were read")

    def _remove_node(self, node_id: int, why: str) -> None:
        node = self._nodes.pop(node_id, None)
        self._scenes.forget(node_id)
        for published in () if node is None else node.published:
            self._node_of.pop(published.device.key, None)
            self.devices.remove(published.device.key, why)

    async def _on_attribute(self, data: object, payload: bytes) -> None:
        if not isinstance(data, list) or len(data) != 3:
            raise WireError(f"a new value of an attribute is {shown(data)}, not a list of three")
        node = self._node(data[0])
        path = parse_path(data[1])
        endpoint = node.set(path, data[2])
        if path[1] == SCENES:
            self._scenes.look_at(node)
        if path[1] in {DESCRIPTOR, BASIC, BRIDGED} or self._has_other_parts(node, endpoint):
            self._describe(node, "it changed")
        for published in node.published:
            parts = [part for part, (of, _) in published.rows.items() if of is endpoint]
            if not parts and published.root is not endpoint:
                continue
            self.devices.put(published.device, "it reported")
            await self.devices.deliver_raw(published.device.key, payload)
            for part in parts:
                await self._report(published, part, path[1])

    def _has_other_parts(self, node: MatterNode, endpoint: MatterEndpoint) -> bool:
        """Return whether the parts of an endpoint differ from those published: a limit may have changed."""
        published = [
            part for device in node.published for part in device.device.parts if device.rows[part.id][0] is endpoint
        ]
        return published != [part for part, _ in parts_of(endpoint)]

    async def _report(self, device: NodeDevice, part: str, cluster: int | None, *, is_old: bool = False) -> None:
        """Report the values of a part from one cluster, or from each cluster by itself; None for all clusters."""
        values: dict[str | int, dict[str, PlainValue]] = {}
        endpoint, rows = device.rows[part]
        for row in rows:
            if row.read is not None and (cluster is None or cluster in row.watched):
                values.setdefault(row.watched[0], {})[row.capability] = row.read(endpoint)
        for of_cluster in values.values():
            await self.devices.report(device.device.key, of_cluster, part, retained=is_old)

    async def _on_node_event(self, data: object, payload: bytes) -> None:
        fields = as_fields(data)
        node = self._node(fields.get("node_id"))
        number = fields.get("endpoint_id")
        endpoint = node.endpoints.get(number) if isinstance(number, int) else None
        if endpoint is None:
            raise WireError(f"an event is of endpoint {shown(number)}, which the node does not have")
        event = fields.get("event_id")
        if fields.get("cluster_id") != SWITCH or not isinstance(event, int):
            return
        press = press_of(endpoint, event, fields.get("data"))
        for published in node.published:
            if str(endpoint.id) in published.rows:
                self.devices.put(published.device, "it reported")
                await self.devices.deliver_raw(published.device.key, payload)
                if press is not None:
                    await self.devices.report(published.device.key, {"press": press}, str(endpoint.id))

    def _node(self, value: object) -> MatterNode:
        node_id = node_id_of(value)
        node = self._nodes.get(node_id)
        if node is None:
            raise WireError(f"node {node_id} is unknown")
        return node

    async def maintain(self) -> None:
        """Ask for the nodes with changes that were dropped, because they sent too many invalid messages."""
        missed, self._missed = self._missed, set()
        for node_id in missed & self._nodes.keys():
            try:
                described = await self._link.call("a node", "get_node", {"node_id": node_id})
                await self._add_node(described, "it was asked for")
            except LinkError:
                return  # all nodes are listed again after the next connection
            except PeerError as exc:
                self.devices.reject(self.peer, b"", f"node {node_id} cannot be read again: {exc}")

    async def pair(self, key: str, code: str) -> str:
        """Commission the device that has the setup code, and return its name; *key* is empty."""
        if key in self._node_of:
            raise UnableError(f"{key} is commissioned already")
        check_matter_setup_code(code)
        return (await self._commission(CommissionRequest(code=code)))[1]

    async def unpair(self, key: str) -> str:
        """Remove a node, and return its name."""
        return (await self._decommission(key))[1]

    def unpaired(self) -> Iterator[UnpairedDevice]:
        """Yield any device that has a setup code: the server knows none before."""
        problem = f"{self.peer} cannot be reached: {self.problem}" if self.problem else ""
        yield UnpairedDevice(device="", name="Matter", takes_code=True, within_s=COMMISSIONS_WITHIN, problem=problem)

    async def _commission(self, request: CommissionRequest) -> tuple[str, str]:
        """Add the device with a setup code."""
        check_matter_setup_code(request.code)
        self.check_link()
        if not (request.network_only or self._link.has_bluetooth):
            raise UnableError("the Matter server has no Bluetooth; it can only commission devices on the network")
        command, args = "commission_with_code", {"code": request.code, "network_only": request.network_only}
        try:
            described = await self._link.call("commissioning", command, args, is_secret=True, within=COMMISSIONS_WITHIN)
        except RefusedError as exc:
            raise UnableError(_PROBLEMS.get(exc.code or 0, str(exc))) from None
        node_id = node_id_of(as_fields(described).get("node_id"))
        if node_id not in self._nodes:  # python-matter-server announces it before it answers
            await self._add_node(described, "it was commissioned")
        if node_id not in self._nodes:
            raise UnableError(f"node {node_id} was commissioned, but the gateway has max_nodes already")
        device = self._nodes[node_id].published[0].device
        return device.key, device.name

    async def _decommission(self, key: str) -> tuple[str, str]:
        """Remove a node; one that does not answer is removed from the server alone."""
        node = self._node_of.get(key)
        if node is None:
            raise UnableError(f"the Matter gateway has no device {key[:100]!r}")
        root, name = node.published[0].device.key, node.published[0].device.name
        if root != key:
            raise UnableError(f"{key} is behind the bridge {root} ({name}); only the bridge can be removed")
        self.check_link()
        await self._link.call(f"removing {name}", "remove_node", {"node_id": node.id}, within=REMOVES_WITHIN)
        return key, name

    async def _perform(self, command: Command) -> Collection[str]:
        node, device = self._find_reachable(command.key)
        endpoint, rows = device.rows[command.part]
        what = f"{command.capability} for {device.device.name}"
        orders, along = joint_orders(rows, endpoint, command)
        for order in orders:
            name, args = order.server_call(node.id, endpoint.id)
            check_result(what, await self._link.call(what, name, args, is_secret=order.is_secret))
        return along

    async def _refresh(self, key: str, part: str) -> None:
        """Read the attributes behind the values of a part from its node."""
        node, device = self._find_reachable(key)
        endpoint, rows = device.rows[part]
        paths = [
            f"{endpoint.id}/{cluster}/*" for cluster in sorted({watched for row in rows for watched in row.watched})
        ]
        args = {"node_id": node.id, "attribute_path": paths}
        answer = await self._link.call(f"the values of {device.device.name}", "read_attribute", args)
        for path, value in as_fields(answer).items():
            await self._on_attribute([node.id, path, value], b"")

    def _find_reachable(self, key: str) -> tuple[MatterNode, NodeDevice]:
        """Return a device that answers, and its node."""
        self.check_link()
        node = self._node_of[key]
        device = next(published for published in node.published if published.device.key == key)
        if not node.is_reachable(device):
            raise LinkError(f"{device.device.name} does not answer the Matter server")
        return node, device
