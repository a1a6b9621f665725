"""A node of a Matter server, as one or more devices. Pure.

A node is one device, its endpoints are the parts. Each bridged endpoint, together with the endpoints it is composed
of, is a device of its own.

Source: Matter 1.4 Core Specification, 9.2 (composition), 9.5 (Descriptor), 9.12 (Bridge), 9.13 (Bridged Device Basic
Information), 11.1 (Basic Information), 11.12 (General Diagnostics).
"""

import base64
import binascii
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Self, TypeAlias

from homebot.conventions.payload import shown
from homebot.devices.identity import identifiers, may_be_unique
from homebot.devices.part import Part
from homebot.errors import WireError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.integrations.matter.formats.cluster_row import ClusterRow
from homebot.integrations.matter.formats.endpoint import MatterEndpoint
from homebot.integrations.matter.formats.opening_clusters import is_covering
from homebot.integrations.matter.formats.parts import parts_of
from homebot.integrations.matter.formats.scenes import scene_parts

MAX_ATTRIBUTES: Final = 20_000
MAX_PARTS: Final = 200
"""The parts of one node."""

BASIC, BRIDGED, DIAGNOSTICS = 40, 57, 51
_VENDOR, _PRODUCT, _LABEL, _HARDWARE, _SOFTWARE, _SERIAL, _REACHABLE, _UNIQUE = 1, 3, 5, 8, 10, 15, 17, 18
_FACTS: Final = {"manufacturer": _VENDOR, "model": _PRODUCT, "hw_version": _HARDWARE, "sw_version": _SOFTWARE}

_BRIDGED_NODE: Final = 0x0013
_PATH: Final = re.compile(r"([0-9]{1,5})/([0-9]{1,10})/([0-9]{1,10})")

_RowsOfPart: TypeAlias = tuple[MatterEndpoint, tuple[ClusterRow, ...]]


@dataclass(frozen=True, slots=True)
class NodeDevice:
    """A node, or a device behind it, as a device of the gateway.

    Attributes:
        rows: By the id of each part: its endpoint, and the rows of its capabilities.
        root: The endpoint with its name, maker and serial number.
    """

    device: GatewayDevice
    rows: Mapping[str, _RowsOfPart]
    root: MatterEndpoint


class MatterNode:
    """A commissioned node, with its devices as the gateway has published them, itself first."""

    def __init__(self, id: int) -> None:  # noqa: A002 - Matter's word
        self.id = id
        self.is_available = False
        self.endpoints: dict[int, MatterEndpoint] = {}
        self.published: tuple[NodeDevice, ...] = ()
        self._attribute_count = 0

    @classmethod
    def parse(cls, data: object) -> Self:
        """Return the node that the server describes, without invalid attributes; raise WireError if it is none."""
        if not isinstance(data, dict):
            raise WireError(f"a node is {shown(data)}, not an object")
        node = cls(node_id_of(data.get("node_id")))
        attributes = data.get("attributes")
        if not isinstance(attributes, dict):
            raise WireError(f"the attributes of node {node.id} are {shown(attributes)}, not an object")
        if len(attributes) > MAX_ATTRIBUTES:
            raise WireError(f"node {node.id} has {len(attributes)} attributes, more than {MAX_ATTRIBUTES}")
        node.is_available = data.get("available") is True
        for path, value in attributes.items():
            try:
                node.set(parse_path(path), value)
            except WireError:
                continue
        return node

    def set(self, path: tuple[int, int, int], value: object) -> MatterEndpoint:
        """Set an attribute, and return the endpoint that has it; raise WireError if these are too many."""
        endpoint_id, cluster, attribute = path
        endpoint = self.endpoints.get(endpoint_id) or MatterEndpoint(endpoint_id)
        if not endpoint.has(cluster, attribute):
            if self._attribute_count >= MAX_ATTRIBUTES:
                raise WireError(f"node {self.id} has more than {MAX_ATTRIBUTES} attributes")
            self._attribute_count += 1
        self.endpoints[endpoint_id] = endpoint
        endpoint.clusters.setdefault(cluster, {})[attribute] = value
        return endpoint

    def devices(self, fabric: str = "") -> tuple[NodeDevice, ...]:
        """Return the node as devices, itself and then those behind it; *fabric* is the compressed ID, if known."""
        owners = self._owners()
        key = f"node-{self.id}"
        root = self.endpoints.get(0) or MatterEndpoint(0)
        place = f"matter:deviceid_{fabric}-{self.id:016X}" if fabric else ""  # as Home Assistant spells it
        members = (endpoint for endpoint in self._sort() if owners.get(endpoint.id, 0) == 0)
        devices = [self._device(key, root, members, "", place and f"{place}-MatterNodeDevice")]
        for endpoint in self._sort():
            if owners.get(endpoint.id) == endpoint.id:
                members = (member for member in self._sort() if owners.get(member.id) == endpoint.id)
                own = place and f"{place}-{endpoint.id}"
                devices.append(self._device(f"{key}-{endpoint.id}", endpoint, members, key, own))
        return tuple(devices)

    def is_reachable(self, device: NodeDevice) -> bool:
        """Return whether *device*, which is one of its devices, can be reached."""
        return self.is_available and device.root.flag(BRIDGED, _REACHABLE) is not False

    def _owners(self) -> dict[int, int]:
        """Return the bridged endpoint of each endpoint that belongs to one."""
        bridged = [endpoint for endpoint in self._sort() if endpoint.id and _BRIDGED_NODE in endpoint.device_types]
        owners = {endpoint.id: endpoint.id for endpoint in bridged}
        for endpoint in bridged:
            pending = list(endpoint.children)
            while pending:
                child = pending.pop()
                if child in self.endpoints and child not in owners and child:
                    owners[child] = endpoint.id
                    pending += self.endpoints[child].children
        return owners

    def _sort(self) -> list[MatterEndpoint]:
        return [self.endpoints[number] for number in sorted(self.endpoints)]

    def _device(
        self, key: str, root: MatterEndpoint, members: Iterable[MatterEndpoint], bridge: str, place: str
    ) -> NodeDevice:
        cluster = BRIDGED if bridge else BASIC
        serial, unique = root.text(cluster, _SERIAL), root.text(cluster, _UNIQUE)
        if not may_be_unique(serial, root.text(cluster, _PRODUCT)):
            serial = ""
        known_by = identifiers([*_hardware_addresses(root), place, unique and f"matter:uniqueid_{unique}", serial])
        parts, rows = self._parts(members, next(iter(known_by), ""))
        facts = {name: root.text(cluster, attribute) for name, attribute in _FACTS.items()} | {"via_device": bridge}
        device = GatewayDevice(
            key,
            root.text(cluster, _LABEL) or facts["model"] or f"Matter {key.replace('-', ' ')}",
            tuple(parts),
            {name: text for name, text in facts.items() if text},
            known_by,
            whole_device=True,
            authenticated=True,  # the owner commissioned it: it has a certificate
            raw_address=f"matter/{key}",
        )
        return NodeDevice(device, rows, root)

    def _parts(self, members: Iterable[MatterEndpoint], own: str) -> tuple[list[Part], dict[str, _RowsOfPart]]:
        """Return the parts of a device, which *own* identifies, at the endpoints *members*, and the rows of each."""
        coverings = {
            number
            for endpoint in self.endpoints.values()
            if is_covering(endpoint)
            for number in (endpoint.id, *endpoint.children)
        }
        parts: list[Part] = []
        rows: dict[str, _RowsOfPart] = {}
        for endpoint in members:
            parts_with_rows = [
                (part, endpoint, some) for part, some in parts_of(endpoint, covers=endpoint.id in coverings)
            ]
            if parts_with_rows and endpoint.scenes:
                main, _, its_rows = parts_with_rows[0]
                parts_with_rows += scene_parts(endpoint, f"{own}#{main.id}" if own else "", its_rows)
            for part, at, some in parts_with_rows[: MAX_PARTS - len(parts)]:
                parts.append(part)
                rows[part.id] = at, some
        return parts, rows


def parse_path(path: object) -> tuple[int, int, int]:
    """Return endpoint, cluster and attribute of a path such as ``1/6/0``."""
    match = _PATH.fullmatch(path) if isinstance(path, str) else None
    if match is None:
        raise WireError(f"{shown(path)} is not the path of an attribute")
    endpoint, cluster, attribute = (int(number) for number in match.groups())
    if endpoint > 0xFFFF or cluster > 0xFFFFFFFF or attribute > 0xFFFFFFFF:
        raise WireError(f"{shown(path)} is not the path of an attribute")
    return endpoint, cluster, attribute


def node_id_of(value: object) -> int:
    """Return a node ID."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 < value < 1 << 64:
        raise WireError(f"{shown(value)} is not a node ID")
    return value


def _hardware_addresses(root: MatterEndpoint) -> Iterator[str]:
    for interface in root.structs(DIAGNOSTICS, 0):
        encoded = interface.get("4", interface.get("hardwareAddress"))
        if not isinstance(encoded, str) or len(encoded) > 16:
            continue
        try:
            address = base64.b64decode(encoded, validate=True)
        except (binascii.Error, ValueError):
            continue
        if len(address) in {6, 8} and any(address):
            yield ":".join(f"{byte:02x}" for byte in address)
