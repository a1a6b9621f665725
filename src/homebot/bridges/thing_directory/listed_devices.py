"""The devices of the directory, as things: described, read and commanded."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TypeAlias
from urllib.parse import quote

import anyio
import anyio.lowlevel

from homebot.bridges.thing_directory.catalog import ThingCatalog
from homebot.bridges.thing_directory.documents import BEARER
from homebot.devices import Device, DeviceChange
from homebot.devices.capabilities import EVENTS
from homebot.devices.device import DevicePart, Endpoint
from homebot.devices.follow import Follow
from homebot.devices.handles.handle import Handle
from homebot.devices.house_view import HouseView
from homebot.devices.part import Capability
from homebot.graph import Node
from homebot.wot.export import property_names, thing_id, to_thing
from homebot.wot.thing import NO_SECURITY

__all__ = ["ListedDevices", "ListedProperty"]

_TURN = 10
"""Devices described before other tasks get their turn."""

_OF_A_DIRECTORY = re.compile(r"urn:homebot:[0-9a-f]{16}:")
_Properties: TypeAlias = "dict[str, ListedProperty]"


@dataclass(frozen=True, slots=True)
class ListedProperty:
    """One property of a listed device, and whether it can be set here."""

    handle: Handle
    capability: Capability
    is_writable: bool


class HttpForms:
    """The directory's own addresses of properties, at which devices of all gateways are read and commanded."""

    def __init__(self, path: str, *, allows_commands: bool) -> None:
        self._path = path
        self._allows_commands = allows_commands

    def of_property(self, name: str, part: DevicePart, capability: Capability) -> list[dict[str, object]]:
        """Return the form of a property; none for events, which are told on no address."""
        ops = ["readproperty"] if capability.readable else []
        ops += ["writeproperty"] if self.is_writable(part, capability) else []
        if not ops or capability.name in EVENTS:
            return []
        href = f"{self._path}/properties/{quote(name, safe='')}"
        return [{"href": href, "contentType": "application/json", "op": ops}]

    def is_writable(self, part: DevicePart, capability: Capability) -> bool:
        """Return whether a property can be set."""
        return self._allows_commands and capability.settable and bool(part.routes)

    def of_words(self, _endpoint: Endpoint) -> list[dict[str, object]]:
        """Return nothing: plain text goes over other bridges."""
        return []


class ListedDevices:
    """The devices of the directory, in a catalog of descriptions.

    A device that is known from the directory of another homebot alone is left out: two that follow each other would
    describe it back and forth.

    Args:
        owner: The id of this homebot.
        needs_token: Whether reading and setting properties needs a token.

    Attributes:
        refused: Number of times that a device was left out because there were too many.
    """

    def __init__(
        self,
        node: Node,
        catalog: ThingCatalog,
        owner: str,
        *,
        needs_token: bool,
        allows_commands: bool,
        max_devices: int,
        on_change: Callable[[], None],
    ) -> None:
        self.catalog = catalog
        self.refused = 0
        self._node = node
        self._owner = owner
        self._security = BEARER if needs_token else NO_SECURITY
        self._allows_commands = allows_commands
        self._max_devices = max_devices
        self._on_change = on_change
        self._view = HouseView.of(node)
        self._properties: dict[str, _Properties] = {}

    async def run(self) -> None:
        """Follow the devices of the house until cancelled."""
        number = 0
        async for change in Follow(self._node):
            self._on_device(change)
            number += 1
            if number % _TURN == 0:
                await anyio.lowlevel.checkpoint()
        await anyio.sleep_forever()

    def properties(self, listed_id: str) -> dict[str, ListedProperty] | None:
        """Return the properties of a thing by name; None where there is no such thing."""
        return self._properties.get(listed_id)

    def _on_device(self, change: DeviceChange) -> None:
        device = change.device
        listed_id = thing_id(device.id, self._owner)
        if change.kind == "removed" or not _is_own(device):
            self.catalog.remove(listed_id)
            self._properties.pop(listed_id, None)
        elif listed_id not in self._properties and len(self._properties) >= self._max_devices:
            self.refused += 1
            return
        else:
            self._list(device, change.sequence, listed_id)
        self._on_change()

    def _list(self, device: Device, sequence: int, listed_id: str) -> None:
        forms = HttpForms(f"/things/{quote(listed_id, safe='')}", allows_commands=self._allows_commands)
        described = to_thing(device, forms, self._owner)
        names = described["properties"]
        properties: _Properties = {}
        view = self._view.store(device, sequence)
        for name, part, capability in property_names(device):
            if isinstance(names, dict) and name in names:
                handle = Handle(view, part.id, self._view)
                properties[name] = ListedProperty(handle, capability, forms.is_writable(part, capability))
        self._properties[listed_id] = properties
        if properties:
            all_ = f"/things/{quote(listed_id, safe='')}/properties"
            described["forms"] = [{"href": all_, "contentType": "application/json", "op": "readallproperties"}]
        now = datetime.fromtimestamp(self._node.graph.clock.now(), UTC).isoformat(timespec="seconds")
        self.catalog.put(listed_id, {**described, **self._security}, now.replace("+00:00", "Z"))


def _is_own(device: Device) -> bool:
    return not device.endpoints or any(_OF_A_DIRECTORY.match(one.key) is None for one in device.endpoints)
