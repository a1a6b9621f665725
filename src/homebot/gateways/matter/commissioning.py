"""The services of a Matter gateway that commission and remove nodes; the Matter server does the work.

Source: as :mod:`homebot.gateways.matter.server_messages`: ``commission_with_code``, ``remove_node``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Final, Literal, Protocol

from pydantic import ConfigDict, Field

from homebot.conventions.setup_codes import check_matter_setup_code
from homebot.devices.names import GatewayNames
from homebot.errors import LinkError, PeerError, RefusedError, UnableError
from homebot.messages.message import Message, ServiceAnswer, ServiceType

if TYPE_CHECKING:
    from homebot.gateways.matter.server_link import MatterServerLink
    from homebot.graph import Node

__all__ = [
    "Commission",
    "CommissionRequest",
    "CommissionResponse",
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


class CommissionResponse(ServiceAnswer):
    """The result of commissioning or decommissioning.

    Attributes:
        problem: ``refused`` by the gateway or the device, where the same again fails again; ``unreachable`` where the
            network is not there now, or gave no answer in time; ``busy`` while another device is commissioned.
        key: The gateway's key of the device.
        name: The name of the device.
    """

    problem: Literal["", "refused", "unreachable", "busy"] = ""
    key: str = ""
    name: str = ""


class DecommissionRequest(Message):
    """Request to remove a device from the network of a gateway; it needs its setup code to come back.

    Attributes:
        key: The gateway's key of the device.
    """

    key: str


Commission = ServiceType("homebot/srv/Commission", CommissionRequest, CommissionResponse)
Decommission = ServiceType("homebot/srv/Decommission", DecommissionRequest, CommissionResponse)


class CommissioningNames:
    """The graph names of a gateway that commissions devices, beside those that every gateway has.

    Attributes:
        commission: Service :data:`Commission`.
        decommission: Service :data:`Decommission`.
    """

    def __init__(self, gateway: str) -> None:
        self.commission = f"{GatewayNames(gateway).node}/commission"
        self.decommission = f"{GatewayNames(gateway).node}/decommission"


class CommissioningGateway(Protocol):
    """The gateway of the nodes."""

    @property
    def acts(self) -> bool:
        """True if commands are sent."""

    @property
    def observes_because(self) -> str:
        """The reason why not."""

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
        self._is_busy = False
        names = CommissioningNames(node.name)
        node.create_service(Commission, names.commission, self._commission, concurrent=True)
        node.create_service(Decommission, names.decommission, self._decommission, concurrent=True)

    async def _commission(self, request: CommissionRequest) -> CommissionResponse:
        """Have the server commission a device, one at a time."""
        if self._is_busy:
            return CommissionResponse(success=False, message="another device is being commissioned", problem="busy")
        self._is_busy = True
        try:
            check_matter_setup_code(request.code)
            if not (request.network_only or self._gateway.connected_link().has_bluetooth):
                raise UnableError("the Matter server has no Bluetooth; it can only commission devices on the network")
            args = {"code": request.code, "network_only": request.network_only}
            result = await self._call("commissioning", "commission_with_code", args, COMMISSIONS_WITHIN)
            key, name = await self._gateway.add_commissioned(result)
        except (LinkError, PeerError) as exc:
            return _failed(exc)
        finally:
            self._is_busy = False
        return CommissionResponse(success=True, key=key, name=name)

    async def _decommission(self, request: DecommissionRequest) -> CommissionResponse:
        """Remove a node; one that does not answer is removed from the server alone."""
        try:
            node_id, name = self._gateway.node_of(request.key)
            await self._call(f"removing {name}", "remove_node", {"node_id": node_id}, REMOVES_WITHIN)
        except (LinkError, PeerError) as exc:
            return _failed(exc)
        return CommissionResponse(success=True, key=request.key, name=name)

    async def _call(self, what: str, command: str, args: Mapping[str, object], within: float) -> object:
        if not self._gateway.acts:
            raise RefusedError(what, self._gateway.observes_because)
        link = self._gateway.connected_link()
        return await link.call(what, command, args, is_secret="code" in args, within=within)


def _failed(error: LinkError | PeerError) -> CommissionResponse:
    if isinstance(error, LinkError):
        return CommissionResponse(success=False, message=str(error), problem="unreachable")
    code = error.code if isinstance(error, RefusedError) else None
    return CommissionResponse(success=False, message=_PROBLEMS.get(code or 0, str(error)), problem="refused")
