"""The services that homebot announces on the network.

``_homebot._tcp`` is always announced, with name, version and id. Other services are announced as published on
:data:`homebot.devices.network_service.NETWORK_SERVICES`, unless they listen on loopback only.
"""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib.metadata import version

import anyio
import anyio.to_thread

from homebot.addresses import is_loopback
from homebot.devices.network_service import NETWORK_SERVICES, NETWORK_SERVICES_QOS, NetworkService
from homebot.errors import LinkError
from homebot.gateways.mdns.network import OwnService, ServiceNetwork
from homebot.graph import Node
from homebot.installation import installation_id

__all__ = ["HOMEBOT", "OwnServices", "installation_facts"]

ANNOUNCE_FAILED = "mdns.announce_failed"

HOMEBOT = "_homebot._tcp"

DOOR = "_rosbridge._tcp"
"""The door. ``_homebot._tcp`` has its port too, or 0 if there is no door to connect to."""

MAX_SERVICES = 20


class OwnServices:
    """The services that this process announces.

    Args:
        node: The node of the gateway.
        name: The name that others see; empty for that of this computer.
    """

    def __init__(self, node: Node, name: str) -> None:
        self._node = node
        self._name = name or platform.node().partition(".")[0] or "homebot"
        self._offered: dict[str, NetworkService] = {}
        self._changed = anyio.Event()
        self._waiting: dict[str, None] = {}
        node.create_subscription(NetworkService, NETWORK_SERVICES, self._take, NETWORK_SERVICES_QOS)

    async def announce(self, network: ServiceNetwork) -> None:
        """Keep the announcements up to date until cancelled."""
        self._waiting = dict.fromkeys((HOMEBOT, *self._offered))
        identity = await anyio.to_thread.run_sync(installation_facts, self._node.full_name)
        while True:
            while self._waiting:
                await self._tell(network, self._waiting.popitem()[0], identity)
            self._changed = anyio.Event()
            await self._changed.wait()

    def _take(self, service: NetworkService) -> None:
        reached = tuple(one for one in service.addresses if not is_loopback(one))
        if service.is_withdrawn or not reached:
            self._offered.pop(service.service_type, None)
        elif service.service_type in self._offered or len(self._offered) < MAX_SERVICES:
            self._offered[service.service_type] = service.model_copy(update={"addresses": reached})
        self._waiting |= {service.service_type: None, HOMEBOT: None}
        self._changed.set()

    async def _tell(self, network: ServiceNetwork, service_type: str, identity: Mapping[str, str]) -> None:
        offered = self._offered.get(service_type)
        try:
            if service_type == HOMEBOT:
                await network.announce(self._homebot(identity))
            elif offered is None:
                await network.withdraw(service_type)
            else:
                facts = {one.key: one.value for one in offered.facts}
                own = OwnService(service_type, self._name, offered.port, offered.addresses, facts)
                await network.announce(own)
        except LinkError as exc:
            self._node.log.warning(ANNOUNCE_FAILED, message=str(exc), service_type=service_type)

    def _homebot(self, identity: Mapping[str, str]) -> OwnService:
        door = self._offered.get(DOOR)
        facts = {"name": self._name, **identity}
        return OwnService(HOMEBOT, self._name, 0 if door is None else door.port, properties=facts)


def installation_facts(name: str) -> dict[str, str]:
    """Return version and id of this homebot; reads files. The id stays the same, and says nothing about the computer.

    Args:
        name: The name of what is identified on this computer.
    """
    return {"version": version("homebot"), "id": installation_id(name)}
