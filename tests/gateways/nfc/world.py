"""Tags in the field of a simulated reader, which nfcpy's own UDP driver reads."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TypeVar

import anyio
from tests.patience import PATIENCE
from tests.simulated.nfc.field import TagField
from tests.simulated.nfc.type4_card import Type4Card

from homebot.conventions.nfc.ndef_message import NdefRecord, write_ndef
from homebot.devices.gateway_messages import GatewayState
from homebot.gateways.nfc import NfcGateway, NfcGatewaySettings
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile, Subscription
from homebot.messages import Message

MessageT = TypeVar("MessageT", bound=Message)

KEPT = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
UID = "04a1b2c3d4e5f6"


def uri(text: str) -> bytes:
    """The NDEF message of one URI."""
    return write_ndef(NdefRecord("uri", text.encode()))


def card(message: bytes = b"", uid: str = UID, *, capacity: int = 888, is_writable: bool = True) -> Type4Card:
    return Type4Card(bytes.fromhex(uid), message, capacity=capacity, is_writable=is_writable)


class TagHouse:
    """A gateway with one reader, on a graph with another node."""

    def __init__(self, graph: Graph, watcher: Node, gateway: NfcGateway, field: TagField) -> None:
        self.graph = graph
        self.watcher = watcher
        self.gateway = gateway
        self.field = field

    def listen(self, kind: type[MessageT], topic: str) -> Subscription[MessageT]:
        """Listen to what is kept for late joiners, or to taps, which are not."""
        qos_profile = KEPT if topic != "taps" else 100
        return self.watcher.create_subscription(kind, f"/gateway/nfc/{topic}", qos_profile=qos_profile)


@asynccontextmanager
async def tag_house(**settings: object) -> AsyncIterator[TagHouse]:
    field, graph = TagField(), Graph()
    async with field.served(), Node(graph, "watcher") as watcher, Node(graph, "nfc", namespace="/gateway") as node:
        table = {"devices": [field.path], **settings}
        house = TagHouse(graph, watcher, NfcGateway(node, NfcGatewaySettings.model_validate(table)), field)
        async with anyio.create_task_group() as tasks:
            await tasks.start(house.gateway.serve)
            assert (await take(house.listen(GatewayState, "state"))).state == "active"
            yield house
            tasks.cancel_scope.cancel()


async def take(subscription: Subscription[MessageT]) -> MessageT:
    with anyio.fail_after(PATIENCE):
        return await subscription.receive()
