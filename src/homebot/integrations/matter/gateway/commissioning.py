"""The services of a Matter gateway that commission and remove nodes; the Matter server does the work."""

from collections.abc import Awaitable, Callable
from functools import partial
from typing import Annotated

from pydantic import ConfigDict, Field

from homebot.devices.names import GatewayNames
from homebot.gateways.pairing import ActingGateway, PairingRequests, PairResponse
from homebot.graph import Node
from homebot.messages.message import Message, ServiceType


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
