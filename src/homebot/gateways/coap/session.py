"""The session with one endpoint: what its devices are is for an integration to tell; here is when they are reached."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

import anyio

from homebot.conventions.coap.endpoint import CoapEndpoint, authority_of, host_of
from homebot.devices.gateway_messages import Command
from homebot.errors import WireError
from homebot.gateways.address_guard import AddressGuard, guard_for
from homebot.gateways.announced.device_runner import DeviceRunner
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.support.backoff import DEVICE_BACKOFF

if TYPE_CHECKING:
    from homebot.gateways.coap.aiocoap_client import CoapClient


class EndpointSession(DeviceRunner):
    """Describes the devices of one endpoint and runs them; ends if it only answered a multicast question once.

    Args:
        poll_every: Seconds between two readings of resources that cannot be observed.
        describing: Limits the endpoints that are described at the same time: of its host, and all.

    Attributes:
        keys: The keys of its devices, as far as they are known; the endpoint's until then.
        of_host: The limit for its host.
    """

    def __init__(
        self,
        endpoint: CoapEndpoint,
        client: CoapClient,
        devices: PublishedDevices,
        *,
        poll_every: float,
        describing: tuple[anyio.CapacityLimiter, anyio.CapacityLimiter],
    ) -> None:
        super().__init__(endpoint.key, endpoint.key, devices, DEVICE_BACKOFF)
        self.endpoint, self.authority = endpoint, authority_of(endpoint.base)
        self.host = host_of(endpoint.base)
        self.keys: tuple[str, ...] = (endpoint.key,)
        self.of_host, self._describing = describing
        self._client = client
        self._poll_every = poll_every
        self._is_described = False

    @abstractmethod
    async def perform(self, command: Command) -> None:
        """Carry out a command to one of its devices."""

    @abstractmethod
    async def run_devices(self) -> None:
        """Describe the devices and run them."""

    async def work(self) -> None:
        """Describe the devices and run them."""
        try:
            await self.run_devices()
        except WireError as exc:
            self._devices.reject(self.key, exc.frame, str(exc))
            raise

    def list_unheard(self) -> None:
        """Publish an endpoint that a directory or the settings list: it is advertised, though not reachable."""
        if self._is_advertised and self.key not in self._devices.keys:
            endpoint = self.endpoint
            device = GatewayDevice(
                self.key, endpoint.name or self.key, metadata=endpoint.facts, identifiers=endpoint.identifiers
            )
            why = f"it is listed, but {self.problem or 'has not answered yet'}"
            self._devices.put(device, why[:200], confirmed=False)

    def on_end(self) -> None:
        """Publish that its devices cannot be reached."""
        if not self._is_described and not self._is_advertised:
            self.stop()
            return
        super().on_end()
        for key in self.keys:
            self._devices.report_reachable(key, reachable=False)

    async def guard(self) -> AddressGuard:
        """Return the guard of this computer; only an endpoint on it may lead to it, unless another host named that."""
        if self.endpoint.is_foreign:
            return AddressGuard()
        return await guard_for(self.host)

    def on_described(self, *keys: str) -> None:
        """Keep the *keys* of its devices; those that it no longer describes are removed."""
        for key in set(self.keys) - set(keys) if self._is_described else ():
            self._devices.remove(key, "its endpoint no longer describes it")
        self.keys, self._is_described = keys, True
        self.on_answer()

    @property
    def _is_advertised(self) -> bool:
        return self.endpoint.is_registered or self.endpoint.is_static
