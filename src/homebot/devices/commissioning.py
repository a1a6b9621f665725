"""Commissioning: devices join the network of a gateway by their setup codes, and leave it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from homebot.messages.message import Message, ServiceType

__all__ = ["Commission", "CommissionRequest", "CommissionResponse", "Decommission", "DecommissionRequest"]


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


class CommissionResponse(Message):
    """The result of commissioning or decommissioning.

    Attributes:
        success: Whether it was done.
        message: The reason if not, as text.
        problem: ``refused`` by the gateway or the device, where the same again fails again; ``unreachable`` where the
            network is not there now, or gave no answer in time; ``busy`` while another device is commissioned.
        key: The gateway's key of the device.
        name: The name of the device.
    """

    success: bool
    message: str = ""
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
