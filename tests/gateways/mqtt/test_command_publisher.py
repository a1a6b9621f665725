"""Commands on their way to the broker: how long it keeps them, and who is taken to be there; in virtual time."""

import anyio
import pytest
from tests.gateways.mqtt.simple_house import House, settled, simple_house

from homebot.devices import GatewayState

pytestmark = pytest.mark.virtual_time


async def announce_with_session(house: House, online: str = "") -> None:
    await house.listen("bell/lamp/set")
    await house.announce("bell", blind="yes", online=online)


async def test_the_broker_keeps_a_command_that_will_be_sent_again_no_longer_than_that() -> None:
    async with simple_house() as house:
        await announce_with_session(house)
        await house.command("simple:bell", "lamp", "on_off", True, expires_after=9.9, kept_for=1.9)
        assert [one.properties.message_expiry_interval for one in await house.heard()] == [1]


async def test_a_part_without_reports_gets_no_command_until_it_is_heard_after_the_broker_came_back() -> None:
    """The broker may keep it for a device that does not come back in time."""
    async with simple_house() as house:
        await announce_with_session(house)
        house.broker.links[-1].abort()
        await anyio.sleep(1.0)
        answer = await house.command("simple:bell", "lamp", "on_off", True)
        assert (answer.success, answer.problem) == (False, "unreachable")
        assert answer.message.endswith(": the broker has just come back, and the device was not heard since")
        assert not await house.heard()
        await house.announce("bell", blind="yes")
        assert (await house.command("simple:bell", "lamp", "on_off", True)).success


async def test_after_ten_seconds_it_gets_commands_as_before() -> None:
    async with simple_house() as house:
        await announce_with_session(house)
        house.broker.links[-1].abort()
        await anyio.sleep(11.0)
        assert (await house.command("simple:bell", "lamp", "on_off", True)).success


async def test_a_device_with_a_later_report_of_availability_is_present() -> None:
    async with simple_house() as house:
        await announce_with_session(house, online="bell/online")
        house.broker.links[-1].abort()
        await anyio.sleep(1.0)
        await house.say("bell/online", "offline")
        assert not (await house.command("simple:bell", "lamp", "on_off", True)).success
        await house.say("bell/online", "online")
        assert (await house.command("simple:bell", "lamp", "on_off", True)).success


async def test_a_part_with_reports_shows_by_itself_that_it_obeyed() -> None:
    async with simple_house() as house:
        await house.listen("bell/lamp/set")
        await house.announce("bell")
        house.broker.links[-1].abort()
        await anyio.sleep(1.0)
        assert (await house.command("simple:bell", "lamp", "on_off", True)).success


async def test_a_link_that_is_made_again_at_once_was_lost_all_the_same() -> None:
    async with simple_house() as house:
        states: list[str] = []
        house.watcher.create_subscription(
            GatewayState, house.gateway.names.state, lambda one: states.append(one.state), 10
        )
        await anyio.sleep(6.0)  # a link that broke sooner is not made again at once
        house.broker.links[-1].abort()
        await settled()
        assert states == ["unavailable", "active"]
