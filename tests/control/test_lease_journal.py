"""What the journal has of leases, in virtual time."""

from __future__ import annotations

import anyio
import pytest
from tests.control.conftest import OpenHome
from tests.control.test_leases import a_door, end, hold, request, steps, told

pytestmark = pytest.mark.virtual_time


async def test_a_block_is_held_and_released_and_no_renewal_is_noted(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        async with door.hold("open", by="robot", ttl=3):
            await anyio.sleep(60)
        found = await steps(home)
    assert told(found) == [("held", "/app", "robot"), ("released", "/app", "robot")]
    assert {one.device for one in found} == {door.device.id}
    assert [[(one.capability, one.value.plain()) for one in entry.settings] for entry in found] == [
        [("movement", "open")]
    ] * 2


async def test_a_stop_command_outranks_a_lease(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot"):
        await home.report("door", "movement", "opening")
        await anyio.sleep(0.1)
        await door.stop()
        assert told(await steps(home))[1:] == [("outranked", "", "it was stopped")]


async def test_who_ended_a_lease_is_noted(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot", ttl=3):
        await end(home, door)
        await anyio.sleep(10)
        found = await steps(home)
    assert told(found) == [("held", "/app", "robot"), ("ended", "client:owner", "robot"), ("denied", "/app", "robot")]


async def test_who_is_refused_is_noted_with_the_reason(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot"):
        await hold(home, request(door, value="closed", by="guard"))
        entry = (await steps(home))[-1]
    assert (entry.kind, entry.text, entry.issuer) == ("denied", "guard", "client:robot")
    assert (entry.verdicts[0].policy, entry.verdicts[0].reason) == ("lease", "held open by robot for 10 s more")
    assert entry.settings[0].value.plain() == "closed"
