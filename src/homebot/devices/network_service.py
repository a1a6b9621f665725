"""Services of homebot on the network, for gateways that announce them."""

from typing import ClassVar, Final

from homebot.devices.device import KeyValue
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.messages.message import Message, UInt16

__all__ = ["NETWORK_SERVICES", "NETWORK_SERVICES_QOS", "NetworkService"]

NETWORK_SERVICES = "/network_services"
"""The topic on which components that listen on a port announce it."""

NETWORK_SERVICES_QOS: Final = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class NetworkService(Message):
    """A service of this process on the network.

    Attributes:
        service_type: Its type in DNS-SD (RFC 6763): ``_rosbridge._tcp``, perhaps with a subtype.
        addresses: The addresses that it listens on; ``0.0.0.0`` and ``::`` mean all addresses of the computer.
        port: Its TCP or UDP port.
        facts: Facts for programs that connect, such as a path; no secrets, because all programs see them.
        is_withdrawn: Whether it is no longer available.
    """

    key_field: ClassVar[str | None] = "service_type"

    service_type: str
    addresses: tuple[str, ...] = ()
    port: UInt16 = 0
    facts: tuple[KeyValue, ...] = ()
    is_withdrawn: bool = False
