"""Pings to clients that own goals or leases, in virtual time."""

from __future__ import annotations

import anyio
import pytest

from homebot.bridges.rosbridge.heartbeat import Heartbeat, OwnedLeases
from homebot.devices.command_messages import Setting
from homebot.devices.lease_messages import HolderRequest, HoldRequest
from homebot.devices.names import HOLD_PART, RELEASE_LEASE, RENEW_LEASE
from homebot.devices.value import Value
from homebot.graph import Graph

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


async def test_a_lease_counts_until_it_is_released_or_over() -> None:
    leases = OwnedLeases(Graph().clock)
    setting = Setting(capability="on", value=Value.of(True))
    hold = HoldRequest(device="lamp", setting=setting, lease="l", by="robot", ttl=10.0, issuer="client:robot")
    mine, other = (HolderRequest(lease=name, by="robot", issuer="client:robot") for name in ("l", "another"))
    leases.record(HOLD_PART, hold)
    await anyio.sleep(6)
    leases.record(RENEW_LEASE, mine)
    leases.record(RENEW_LEASE, other)
    await anyio.sleep(6)
    assert leases
    await anyio.sleep(6)
    assert not leases
    leases.record(HOLD_PART, hold)
    leases.record(RELEASE_LEASE, mine)
    assert not leases
