"""Pings to clients that own goals or leases, in virtual time."""

import anyio
import pytest

from homebot.bridges.rosbridge.heartbeat import Heartbeat, OwnedLeases
from homebot.devices.command_messages import Setting
from homebot.devices.lease_messages import HolderRequest, HoldPart, HoldRequest, LeaseState, ReleaseLease, RenewLease
from homebot.devices.names import HOLD_PART, RELEASE_LEASE, RENEW_LEASE
from homebot.devices.value import Value
from homebot.errors import RefusedError
from homebot.graph import Graph, Node

pytestmark = pytest.mark.virtual_time


class Peer:
    """A client that answers pings until it vanishes."""

    def __init__(self) -> None:
        self.is_there = True
        self.is_streaming = False
        self.owns = True
        self.pings = 0
        self.heartbeat = Heartbeat(self.ping, 0.4, 0.5, lambda: self.is_streaming)

    async def ping(self) -> None:
        self.pings += 1
        if not self.is_there:
            await anyio.sleep_forever()

    async def vanished(self) -> float:
        """Return the seconds until it is found out."""
        began = anyio.current_time()
        await self.heartbeat.run(lambda: self.owns)
        return anyio.current_time() - began


async def test_a_client_that_vanishes_is_found_out_within_a_second() -> None:
    peer = Peer()
    with anyio.move_on_after(60.1) as limit:
        await peer.vanished()
    assert limit.cancelled_caught
    assert peer.pings == 151
    peer.is_there = False
    assert await peer.vanished() <= 0.9


async def test_a_client_that_owns_nothing_is_not_pinged_until_it_does() -> None:
    peer = Peer()
    peer.is_there = peer.owns = False
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(peer.vanished)
        await anyio.sleep(60)
        assert peer.pings == 0
        peer.owns = True
        peer.heartbeat.start()
        began = anyio.current_time()
    assert anyio.current_time() - began <= 0.9
    assert peer.pings == 1


async def test_a_client_that_streams_is_there() -> None:
    peer = Peer()
    peer.is_there, peer.is_streaming = False, True
    with anyio.move_on_after(60) as limit:
        await peer.vanished()
    assert limit.cancelled_caught


def hold(ttl: float = 10.0) -> HoldRequest:
    setting = Setting(capability="on", value=Value.of(True))
    return HoldRequest(device="lamp", setting=setting, lease="l", by="robot", ttl=ttl, issuer="client:robot")


MINE, OTHER = (HolderRequest(lease=name, by="robot", issuer="client:robot") for name in ("l", "another"))


class Control:
    """Takes leases a second after it is asked, and records what is released."""

    def __init__(self, node: Node) -> None:
        self.steps: list[str] = []
        self.hold_client = node.create_client(HoldPart, HOLD_PART)
        self.renew_client = node.create_client(RenewLease, RENEW_LEASE)
        self.release_client = node.create_client(ReleaseLease, RELEASE_LEASE)
        node.create_service(HoldPart, HOLD_PART, self.hold, concurrent=True)
        node.create_service(ReleaseLease, RELEASE_LEASE, self.release)

    async def hold(self, request: HoldRequest) -> LeaseState:
        await anyio.sleep(1)
        self.steps.append(f"held {request.lease}")
        raise RefusedError("the hold", "this is a test")

    def release(self, request: HolderRequest) -> LeaseState:
        self.steps.append(f"released {request.lease}")
        raise RefusedError("the release", "this is a test")


async def test_a_lease_counts_until_it_is_released_or_over() -> None:
    async with Node(Graph(), "door") as door:
        leases, control = OwnedLeases(door), Control(door)
        leases.record("me", control.hold_client, hold())
        await anyio.sleep(6)
        leases.record("me", control.renew_client, MINE)
        leases.record("me", control.renew_client, OTHER)
        await anyio.sleep(6)
        assert leases.has("me")
        assert not leases.has("somebody else")
        await anyio.sleep(6)
        assert not leases.has("me")
        leases.record("me", control.hold_client, hold())
        leases.record("me", control.release_client, MINE)
        assert not leases.has("me")


async def test_a_lease_ends_with_the_connection_that_held_or_renewed_it_last() -> None:
    async with Node(Graph(), "door") as door:
        leases, control = OwnedLeases(door), Control(door)
        leases.record("first", control.hold_client, hold(3600))
        leases.record("other", control.hold_client, hold(3600).model_copy(update={"lease": "another"}))
        leases.record("second", control.renew_client, MINE)
        leases.release("first")
        await anyio.sleep(1)
        assert control.steps == []
        leases.release("second")
        await anyio.sleep(0.1)
        assert set(control.steps) == {"released l"}
        assert leases.has("other")


async def test_a_lease_that_begins_after_its_client_left_ends_too() -> None:
    async with Node(Graph(), "door") as door:
        leases, control = OwnedLeases(door), Control(door)
        leases.record("me", control.hold_client, hold(3600))
        with anyio.move_on_after(0.5):
            await control.hold_client.call(hold(3600))
        leases.release("me")
        await anyio.sleep(2)
        assert control.steps == ["released l", "held l", "released l"]
