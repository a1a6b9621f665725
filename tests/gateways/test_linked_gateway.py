"""The link of a gateway: what is said, and what is not, while there is none."""

from typing import ClassVar

import anyio
import pytest
from pydantic import BaseModel
from tests.gateways.watched_gateway import receive, watched

from homebot.devices import GatewayState
from homebot.errors import LinkError
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import GatewaySettings
from homebot.gateways.linked_gateway import CONFIRM_EVERY, LinkedGateway
from homebot.graph import Node
from homebot.testing.gateway_contract.steps import KEPT

pytestmark = pytest.mark.virtual_time


class HubGateway(LinkedGateway):
    """Its hub ends the first link in order, and answers no other."""

    Settings: ClassVar[type[BaseModel]] = GatewaySettings
    peer = "the hub"

    def __init__(self, node: Node) -> None:
        settings = GatewaySettings()
        super().__init__(node, settings)
        self.devices = PublishedDevices(self, self._perform, settings)
        self.links = self.maintained = 0

    async def connect(self) -> None:
        self.links += 1
        if self.links > 1:
            await anyio.sleep_forever()
        self.on_link()

    async def _perform(self, _order: object) -> None:
        raise LinkError("no device is there")

    async def maintain(self) -> None:
        self.maintained += 1


async def test_a_link_that_the_peer_ends_in_order_is_lost_with_a_reason_and_confirms_nothing() -> None:
    async with watched("hub", HubGateway) as (gateway, watcher):
        states = watcher.create_subscription(GatewayState, gateway.names.state, qos_profile=KEPT)
        lost = await receive(states, lambda state: state.state == "unavailable")
        assert lost.reason == "the connection was closed"
        await anyio.sleep(3 * CONFIRM_EVERY)
        assert gateway.links == 2
        assert gateway.maintained == 0
        with pytest.raises(LinkError, match="the hub cannot be reached: the connection was closed"):
            gateway.check_link()
