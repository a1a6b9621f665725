"""Strangers who flood the topics of announcements with what breaks the rules: nobody honest loses by it."""

import json
from random import Random
from typing import ClassVar

import anyio
import anyio.lowlevel
import pytest
from tests.gateways.mqtt.simple_house import House, SimpleConvention, settled, simple_house
from tests.sizes import size

from homebot.conventions.description import AnnouncementEvent
from homebot.gateways.announced.work_budget import BURST, MESSAGE_WORK, RATE, SHARED_BURST

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time]

LAMP = "simple:lamp1"
GARBAGE = b"{broken"
PER_SECOND = RATE // MESSAGE_WORK
"""Short messages that one budget pays for in a second."""


class CountedConvention(SimpleConvention):
    """Counts the bytes and messages that it was given."""

    taken: ClassVar[int] = 0

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        CountedConvention.taken += 1
        return super().read_message(topic, payload, retained=retained)


COUNTED = f"{__name__}:CountedConvention"


@pytest.fixture(autouse=True)
def _from_zero() -> None:
    CountedConvention.taken = 0


async def flood(house: House, topic: str, seconds: float, per_second: int = 1000) -> None:
    """Publish garbage that is never the same twice; a ``{}`` in *topic* is a number."""
    for number in range(int(seconds * per_second)):
        await house.devices.publish(topic.format(number), GARBAGE + b"%d" % number, qos=0)
        if number % (per_second // 20) == 0:
            await anyio.sleep(0.05)
    await settled()


def models(house: House) -> list[str]:
    return [one.name for one in house.sighted() if one.key == LAMP]


async def counts(house: House) -> dict[str, int]:
    return {one.name: one.count for one in (await house.health()).counts}


async def test_a_bridge_on_a_flooded_topic_is_heard_within_two_seconds() -> None:
    async with simple_house(conventions=(COUNTED,)) as house, anyio.create_task_group() as tasks:
        await house.announce("lamp1", name="first")
        tasks.start_soon(flood, house, "hello/lamp1", 12.0)
        await anyio.sleep(5)
        assert models(house) == ["first"]
        for name in ("second", "third", "fourth"):
            await house.announce("lamp1", name=name)
            await anyio.sleep(2)
            assert models(house) == [name]
        (one,) = (await house.health()).quarantined
        assert one.offender == "hello/lamp1"
        assert "is not JSON" in one.why


async def test_after_the_flood_all_is_as_before() -> None:
    async with simple_house(conventions=(COUNTED,)) as house:
        await house.announce("lamp1", name="first")
        await flood(house, "hello/lamp1", 5.0)
        event = house.quarantine.take()
        assert event is not None
        assert (event.offender, event.is_over) == ("hello/lamp1", False)
        await anyio.sleep(2)
        await house.announce("lamp1", name="second")
        assert models(house) == ["first", "second"]
        await anyio.sleep(20)
        event = house.quarantine.take()
        assert event is not None
        assert event.is_over
        assert (await house.health()).quarantined == ()
        assert (await counts(house))["quarantines"] == 1


@pytest.mark.no_cover
async def test_a_stranger_that_changes_topics_costs_no_more_than_on_one_topic() -> None:
    """Who stood announced is heard meanwhile as ever, and somebody new within seconds after."""
    async with simple_house(conventions=(COUNTED,)) as house, anyio.create_task_group() as tasks:
        await house.announce("lamp1", name="first")
        tasks.start_soon(flood, house, "hello/{}", 5.0, 2000)
        await anyio.sleep(4)
        await house.announce("lamp1", name="second")
        assert models(house) == ["first", "second"]
        await anyio.sleep(1.2)
        assert CountedConvention.taken <= SHARED_BURST // MESSAGE_WORK + 6 * PER_SECOND
        assert [one.offender for one in (await house.health()).quarantined] == ["hello/#"]
        await house.announce("newcomer")
        await anyio.sleep(1)
        assert [one.key for one in house.sighted()] == ["simple:newcomer"]
        await anyio.sleep(60)
        health = await counts(house)
        assert health["announcements_ignored"] == 0
        assert health["announcements_rejected"] == 10_000


async def test_a_house_that_is_announced_at_once_with_many_broken_devices_is_known_in_seconds() -> None:
    async with simple_house() as house:
        for number in range(1500):
            await house.devices.publish(f"hello/broken{number}", GARBAGE)
            await house.devices.publish(f"hello/{number}", b"{}")
        await anyio.sleep(5)
        assert house.gateway.counters.announcements_rejected == 1500
        assert house.gateway.counters.announcements == 3000
        for number in range(1500):
            assert house.gateway._described._registry.by_key.get(f"simple:{number}") is not None


async def test_a_device_withdrawn_in_a_flood_is_gone_and_does_not_come_back() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        await flood(house, "hello/lamp1", 1.0)
        await house.announce("lamp1", name="late")
        await house.say("hello/lamp1", "", retain=True)
        await anyio.sleep(15)
        assert [one.kind for one in house.sighted()] == ["appeared", "removed"]


async def test_states_of_a_device_are_read_while_its_announcements_wait() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        await flood(house, "hello/lamp1", 1.0)
        await house.say("lamp1/state", "on_off=on")
        assert house.told() == [(LAMP, {"lamp.on_off": True}, False)]


async def test_a_codec_that_fails_takes_nothing_from_the_announcements_of_its_prefix() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        for _ in range(3000):
            await house.devices.publish("lamp1/state", b"crash")
        await house.announce("newcomer")
        assert house.gateway.counters.failures == 3000
        assert {one.key for one in house.sighted()} == {LAMP, "simple:newcomer"}


@pytest.mark.no_cover
@pytest.mark.parametrize("seed", range(size(6, 12)))
async def test_in_any_interleaving_no_device_is_unheard_for_long_and_the_work_is_bounded(seed: int) -> None:
    """Four devices, floods of random topics and rates: each announcement is known two seconds later at most."""
    random = Random(seed)  # noqa: S311 - the same run each time
    async with simple_house(conventions=(COUNTED,)) as house, anyio.create_task_group() as tasks:
        for number in range(4):
            await house.announce(f"d{number}", name="0")
        started, offenders = anyio.current_time(), house.gateway._described.quarantine.budgets
        for _ in range(4):
            topic = random.choice(["hello/d{}", "hello/{}", "hello/d0", "hello/d1", "hello/d2"])
            topic = topic if topic != "hello/d{}" else f"hello/d{random.randrange(4)}"
            tasks.start_soon(flood, house, topic, random.uniform(1, 5), random.choice((40, 400, 1500)))
        for turn in range(1, 9):
            await anyio.sleep(random.random())
            key = f"d{random.randrange(4)}"
            house.sighted()
            await house.announce(key, name=f"{turn}")
            with anyio.fail_after(2.0):
                while all(one.name != f"{turn}" for one in house.sighted()):  # noqa: ASYNC110  # what a reader sees
                    await anyio.sleep(0.05)
        seconds = anyio.current_time() - started + 1
        assert offenders.work <= SHARED_BURST + seconds * (RATE + 4 * (BURST + RATE))


async def test_others_get_more_turns_the_longer_announcements_are() -> None:
    """A long one has many parts, and each is work."""

    async def most_in_a_turn(length: int) -> int:
        async with simple_house() as house, anyio.create_task_group() as tasks:
            most = 0

            async def count() -> None:
                nonlocal most
                while True:
                    await anyio.lowlevel.checkpoint()
                    most = max(most, len(house.sighted()))

            tasks.start_soon(count)
            for number in range(60):
                fields = json.dumps({"name": f"Lamp {number}", "rest": "x" * length})
                await house.devices.publish(f"hello/{number}", fields.encode(), qos=0)
            for _ in range(100):
                await anyio.lowlevel.checkpoint()
            tasks.cancel_scope.cancel()
        return most

    assert await most_in_a_turn(5000) < 12 < 20 < await most_in_a_turn(100)
