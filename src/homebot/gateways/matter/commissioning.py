"""The services of a Matter gateway that commission and remove nodes; the Matter server does the work.

Source: as :mod:`homebot.gateways.matter.server_messages`: ``commission_with_code``, ``remove_node``.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Final, Protocol

from pydantic import ConfigDict, Field

from homebot.conventions.setup_codes import check_matter_setup_code
from homebot.devices.names import GatewayNames
from homebot.devices.pairing_messages import PairResponse
from homebot.errors import RefusedError, UnableError
from homebot.gateways.pairing import ActingGateway, PairingRequests
from homebot.messages.message import Message, ServiceType

if TYPE_CHECKING:
    from homebot.gateways.matter.server_link import MatterServerLink
    from homebot.graph import Node

__all__ = [
    "Commission",
    "CommissionRequest",
    "CommissioningNames",
    "CommissioningServices",
    "Decommission",
    "DecommissionRequest",
]

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


class CommissioningGateway(ActingGateway, Protocol):
    """The gateway of the nodes."""

    def connected_link(self) -> MatterServerLink:
        """Return the connection to the server, or raise a :class:`LinkError`."""

    def node_of(self, key: str) -> tuple[int, str]:
        """Return the id of a node and its name, or raise an :class:`UnableError`."""

    async def add_commissioned(self, data: object) -> tuple[str, str]:
        """Add a node as the answer to its commissioning describes it; return its key and name."""


class CommissioningServices:
    """Serves :class:`CommissioningNames`."""

    def __init__(self, gateway: CommissioningGateway, node: Node) -> None:
        self._gateway = gateway
        self._additions, self._removals = PairingRequests(gateway), PairingRequests(gateway)
        names = CommissioningNames(node.name)
        node.create_service(Commission, names.commission, self._commission, concurrent=True)
        node.create_service(Decommission, names.decommission, self._decommission, concurrent=True)

    async def _commission(self, request: CommissionRequest) -> PairResponse:
        return await self._additions.answer("commissioning", partial(self._add, request))

    async def _decommission(self, request: DecommissionRequest) -> PairResponse:
        return await self._removals.answer("removing it", partial(self._remove, request.key))

    async def _add(self, request: CommissionRequest) -> tuple[str, str]:
        check_matter_setup_code(request.code)
        link, args = self._gateway.connected_link(), {"code": request.code, "network_only": request.network_only}
        if not (request.network_only or link.has_bluetooth):
            raise UnableError("the Matter server has no Bluetooth; it can only commission devices on the network")
        what, command = "commissioning", "commission_with_code"
        try:
            described = await link.call(what, command, args, is_secret=True, within=COMMISSIONS_WITHIN)
        except RefusedError as exc:
            raise UnableError(_PROBLEMS.get(exc.code or 0, str(exc))) from None
        return await self._gateway.add_commissioned(described)

    async def _remove(self, key: str) -> tuple[str, str]:
        """Remove a node; one that does not answer is removed from the server alone."""
        node_id, name = self._gateway.node_of(key)
        link = self._gateway.connected_link()
        await link.call(f"removing {name}", "remove_node", {"node_id": node_id}, within=REMOVES_WITHIN)
        return key, name
