"""Exposure of homebot's own robots, apps, switches and network services to other systems, such as Home Assistant.

An exposed device goes to a gateway on ``/gateway/<name>/offers``, and its states on ``/gateway/<name>/offer_reports``.
Both topics are latched. Commands of the other systems arrive on ``/gateway/<name>/offer_commands`` as
:class:`homebot.devices.gateway_messages.Command`, with the id of the exposed device as key.
"""

from collections.abc import AsyncIterator
from types import TracebackType
from typing import ClassVar, Final, Self

from homebot.devices.device import KeyValue
from homebot.devices.gateway_messages import Command
from homebot.devices.names import GatewayNames
from homebot.devices.part import Part
from homebot.devices.value import PlainValue, Reading, Value
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.messages.message import Message, UInt16

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_COMMANDS_DEPTH = 100

NETWORK_SERVICES = "/network_services"
"""The topic on which components that listen on a port announce it."""

NETWORK_SERVICES_QOS: Final = _LATCHED


class ExposedDevice(Message):
    """A device that homebot exposes to other systems, such as Home Assistant.

    Attributes:
        id: Unique in this homebot; keep it the same across restarts.
        is_withdrawn: Whether it is no longer exposed.
    """

    key_field: ClassVar[str | None] = "id"

    id: str
    name: str
    parts: tuple[Part, ...]
    model: str = ""
    area: str = ""
    is_withdrawn: bool = False


class ExposedState(Message):
    """A reported state of an exposed device.

    Attributes:
        readings: The values; kept until they are replaced.
    """

    key_field: ClassVar[str | None] = "id"

    id: str
    readings: tuple[Reading, ...]


class Exposure:
    """An exposed device, published within a ``with`` block and withdrawn after it; one task reads its commands.

    Args:
        gateway: Name of the gateway that publishes it, if publishing is turned on there.
    """

    def __init__(self, node: Node, offer: ExposedDevice, gateway: str = "mqtt") -> None:
        names = GatewayNames(gateway)
        self.offer = offer
        self._node = node
        self._offers = node.create_publisher(ExposedDevice, names.offers, _LATCHED)
        self._reports = node.create_publisher(ExposedState, names.offer_reports, _LATCHED)
        self._commands = node.create_subscription(Command, names.offer_commands, qos_profile=_COMMANDS_DEPTH)

    def __enter__(self) -> Self:
        self._offers.publish(self.offer)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self._node.is_closed:
            self._offers.publish(self.offer.model_copy(update={"is_withdrawn": True}))
        self._commands.close()

    def set_state(self, capability: str, value: PlainValue, part: str = "") -> None:
        """Publish the new *value* of *capability* of the part *part*."""
        reading = Reading(part=part, capability=capability, value=Value.of(value))
        self._reports.publish(ExposedState(id=self.offer.id, readings=(reading,)))

    async def commands(self) -> AsyncIterator[Command]:
        """Yield the commands of other systems, until the block or the node ends.

        At most 100 are queued; the oldest is dropped.
        """
        async for command in self._commands:
            if command.key == self.offer.id:
                yield command


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
