"""Settings of the gateway for CoAP."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, SecretStr, model_validator

from homebot.config import PeerAddress, SecretName
from homebot.conventions.coap.endpoint import check_uri
from homebot.gateways.base import GatewaySettings
from homebot.units import Seconds

CoapUri = Annotated[str, AfterValidator(check_uri)]
"""An address such as ``coap://192.168.1.20`` or ``coap://[fe80::1%25eth0]/things/lamp``."""


class CoapCredentials(BaseModel):
    """The credentials for the devices with addresses that begin with a text.

    Attributes:
        uri: Addresses that they are for; ``*`` stands for any text: ``coap://192.168.1.20/*``.
        oscore: A directory with an OSCORE context (RFC 8613) as aiocoap keeps it: ``settings.json``, ``secret.json``.
        identity: The identity of a DTLS pre-shared key; with *key*.
        key: The key itself.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    uri: Annotated[PeerAddress, Field(min_length=1)]
    oscore: SecretName = ""
    identity: str = ""
    key: SecretStr = SecretStr("")

    @model_validator(mode="after")
    def _is_one(self) -> CoapCredentials:
        has_key = bool(self.identity) and bool(self.key.get_secret_value())
        if bool(self.oscore) == has_key or (self.identity and not has_key):
            raise ValueError("give either oscore, or identity and key")
        return self


class CoapGatewaySettings(GatewaySettings):
    """The table ``[gateways.coap]``.

    Attributes:
        devices: Addresses of devices, or of Thing Descriptions.
        resource_directory: Addresses of resource directories (RFC 9176) to look devices up in.
        interfaces: Names of network interfaces on which devices are asked for by multicast.
        groups: The IP versions of the multicast groups: 224.0.1.187 and ff02::fd, all CoAP nodes.
        group_port: The port of those groups.
        ask_every: Seconds between two multicast questions.
        poll_every: Seconds between two readings of a resource that cannot be observed.
        timeout: Seconds to wait for a response, retransmissions included.
        max_devices: Devices that may be known at once.
        credentials: The credentials for devices that require some.
    """

    devices: tuple[CoapUri, ...] = ()
    resource_directory: tuple[CoapUri, ...] = ()
    interfaces: tuple[str, ...] = ()
    groups: tuple[Literal["ipv4", "ipv6"], ...] = ("ipv4", "ipv6")
    group_port: Annotated[int, Field(ge=1, le=65535)] = 5683
    ask_every: Annotated[Seconds, Field(ge=1.0)] = 60.0
    poll_every: Annotated[Seconds, Field(ge=1.0)] = 60.0
    timeout: Annotated[Seconds, Field(ge=0.1, le=300.0)] = 15.0
    max_devices: Annotated[int, Field(ge=1, le=10_000)] = 1000
    credentials: tuple[CoapCredentials, ...] = ()
