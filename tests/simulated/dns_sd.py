"""Announcements of simulated devices by DNS-SD over multicast DNS; the only file of the house with zeroconf.

Source: RFC 6762 and 6763.
"""

import socket
from collections.abc import Mapping
from dataclasses import dataclass, field

import anyio
from anyio.abc import TaskStatus
from zeroconf import IPVersion, ServiceInfo
from zeroconf.asyncio import AsyncZeroconf


@dataclass(frozen=True, slots=True)
class DnsSdService:
    """A service that a device announces.

    Attributes:
        service_type: ``_wled._tcp.local.``
        host: The name of its host, without ``.local.``
        ttl: Time to live of the SRV record in seconds; 120 by the standard.
    """

    service_type: str
    name: str
    host: str
    port: int
    properties: Mapping[str, str] = field(default_factory=dict)
    ttl: int = 120


async def announce_service(
    service: DnsSdService, address: str, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED
) -> None:
    """Announce *service* on the interface with the IPv4 *address* until cancelled, without a goodbye.

    Simulated devices end like devices that lose power: silently, so that their records expire.
    """
    info = ServiceInfo(
        service.service_type,
        f"{service.name}.{service.service_type}",
        addresses=[socket.inet_aton(address)],
        port=service.port,
        properties=dict(service.properties),
        server=f"{service.host}.local.",
        host_ttl=service.ttl,
    )
    responder = AsyncZeroconf(interfaces=[address], ip_version=IPVersion.V4Only)
    try:
        await (await responder.async_register_service(info, cooperating_responders=True))
        task_status.started()
        await anyio.sleep_forever()
    finally:
        with anyio.CancelScope(shield=True):
            responder.zeroconf.registry.async_remove(info)
            await responder.async_close()
