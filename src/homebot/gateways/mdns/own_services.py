"""The services that homebot announces on the network.

``_homebot._tcp`` is always announced, with name, version and id. Other services are announced as published on
:data:`homebot.devices.exposure.NETWORK_SERVICES`, unless they listen on loopback only.

Several homebots on one network, or on one computer, have different names, host names and ids. A name that another
program has is changed, and kept for the next start; of two homebots that have one id, because a folder was copied, the
last one by name takes another.

Source: RFC 6762 (Multicast DNS), section 9 (Conflict Resolution).
"""

from __future__ import annotations

import platform
from importlib.metadata import version
from typing import TYPE_CHECKING, Final

import anyio
from anyio import to_thread

from homebot.conventions.dns_sd import FoundService, full_type
from homebot.devices.exposure import NETWORK_SERVICES, NETWORK_SERVICES_QOS, NetworkService
from homebot.errors import LinkError
from homebot.gateways.mdns.network import OwnService
from homebot.graph import Node
from homebot.support.addresses import is_loopback
from homebot.support.installation import Installation

if TYPE_CHECKING:
    from homebot.gateways.mdns.zeroconf_network import MdnsNetwork

ANNOUNCE_FAILED = "mdns.announce_failed"
NAME_TAKEN = "mdns.name_taken"
ID_TAKEN = "mdns.id_taken"
ID_NOT_KEPT = "mdns.id_not_kept"

HOMEBOT: Final = "_homebot._tcp"

DOOR: Final = "_rosbridge._tcp"
"""The door. ``_homebot._tcp`` has its port too, or 0 if there is no door to connect to."""

MAX_SERVICES: Final = 20


class OwnServices:
    """The services that this process announces by *name*; if that is empty, by the name of this computer."""

    def __init__(self, node: Node, name: str, installation: Installation) -> None:
        self._node = node
        self._wanted = name or platform.node().partition(".")[0] or "homebot"
        self._installation = installation
        self._name = self._wanted
        self._id = self._version = ""
        self._offered: dict[str, NetworkService] = {}
        self._changed = anyio.Event()
        self._waiting: dict[str, None] = {}
        self._same_id_as = ""
        node.create_subscription(NetworkService, NETWORK_SERVICES, self._on_service, NETWORK_SERVICES_QOS)

    async def announce(self, network: MdnsNetwork) -> None:
        """Keep the announcements up to date until cancelled."""
        self._name = await to_thread.run_sync(self._installation.name_for, self._wanted)
        self._version = await to_thread.run_sync(version, "homebot")
        await self._read_id()
        if problem := self._installation.problem:
            self._node.log.info(ID_NOT_KEPT, message=f"homebot's id on the network is for this run: {problem}")
        while True:
            while self._waiting:
                service_type = next(iter(self._waiting))
                del self._waiting[service_type]
                offered = self._offered.get(service_type)
                try:
                    if service_type == HOMEBOT:
                        await self._save_name(await network.announce(self._homebot()))
                    elif offered is None:
                        await network.withdraw(service_type)
                    else:
                        facts = {fact.key: fact.value for fact in offered.facts}
                        own = OwnService(service_type, self._name, self._host, offered.port, offered.addresses, facts)
                        await network.announce(own)
                except LinkError as exc:
                    self._node.log.warning(ANNOUNCE_FAILED, message=str(exc), service_type=service_type)
            if self._same_id_as and self._same_id_as < self._name:
                self._same_id_as = ""
                await to_thread.run_sync(self._installation.renew)
                await self._read_id()
                message = "another homebot on the network has this one's id, which is another one from now on"
                self._node.log.warning(ID_TAKEN, message=message, id=self._id)
                continue
            self._changed = anyio.Event()
            await self._changed.wait()

    def on_other_service(self, service: FoundService) -> None:
        """Check a service of another program: it may be a homebot with the same id."""
        is_homebot = service.service_type == full_type(HOMEBOT)
        if is_homebot and self._id and service.properties.get("id") == self._id:
            self._same_id_as = service.name
            self._changed.set()

    def _on_service(self, service: NetworkService) -> None:
        reached = tuple(address for address in service.addresses if not is_loopback(address))
        if service.is_withdrawn or not reached:
            self._offered.pop(service.service_type, None)
        elif service.service_type in self._offered or len(self._offered) < MAX_SERVICES:
            self._offered[service.service_type] = service.model_copy(update={"addresses": reached})
        self._waiting |= {service.service_type: None, HOMEBOT: None}
        self._changed.set()

    async def _read_id(self) -> None:
        self._id = await to_thread.run_sync(self._installation.id_of, self._node.full_name)
        self._waiting = dict.fromkeys((HOMEBOT, *self._offered, *self._waiting))  # others get its name

    async def _save_name(self, got: str) -> None:
        """Save the name that replaced one in use, for the next start and for the other services."""
        if got == self._name:
            return
        message = f"another program on the network is called {self._name}; this homebot is {got} there"
        self._node.log.info(NAME_TAKEN, message=message, name=got)
        self._name = got
        await to_thread.run_sync(self._installation.store_name, self._wanted, got)

    @property
    def _host(self) -> str:
        """The label of a host name for this homebot alone: others on this computer have the same addresses."""
        label = "".join(
            character if character.isascii() and character.isalnum() else "-" for character in self._wanted.lower()
        ).strip("-")
        return f"{label[:40] or 'robot'}-homebot-{self._id[:8]}"

    def _homebot(self) -> OwnService:
        door = self._offered.get(DOOR)
        facts = {"name": self._wanted, "version": self._version, "id": self._id}
        return OwnService(HOMEBOT, self._name, self._host, 0 if door is None else door.port, properties=facts)
