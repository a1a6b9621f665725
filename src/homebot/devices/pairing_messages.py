"""Services of gateways whose devices serve only paired programs."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from homebot.messages.message import Message, ServiceAnswer, ServiceType

__all__ = ["Pair", "PairRequest", "PairResponse", "Unpair", "UnpairRequest"]


class PairRequest(Message):
    """Request to pair homebot with a device.

    Attributes:
        device: The gateway's key of the device.
        code: The code on the device; empty if a button is pressed instead. It is a secret that is used once and never
            shown.
    """

    model_config = ConfigDict(hide_input_in_errors=True)

    device: str
    code: Annotated[str, Field(repr=False, max_length=255)] = ""


class UnpairRequest(Message):
    """Request to end the pairing with a device.

    Attributes:
        device: The gateway's key of the device.
    """

    device: str


class PairResponse(ServiceAnswer):
    """The result of pairing or unpairing.

    Attributes:
        problem: ``refused`` by the gateway or the device; ``unreachable`` if the device cannot be reached now;
            ``busy`` while another device is paired.
    """

    problem: Literal["", "refused", "unreachable", "busy"] = ""
    key: str = ""
    name: str = ""


Pair = ServiceType("homebot/srv/Pair", PairRequest, PairResponse)
Unpair = ServiceType("homebot/srv/Unpair", UnpairRequest, PairResponse)
