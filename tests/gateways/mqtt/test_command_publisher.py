"""Commands on their way to the broker: how long it keeps them, and who is taken to be there; in virtual time."""

import anyio
import pytest
from tests.gateways.mqtt.simple_house import House, settled, simple_house

from homebot.devices import GatewayState

pytestmark = pytest.mark.virtual_time


async def announce_with_session(house: House) -> None:
    await house.listen("bell/lamp/set")
    await house.announce("bell", blind="yes")


async def test_the_broker_keeps_a_command_that_will_be_sent_again_no_longer_than_that() -> None:
    async with simple_house() as house:
        await announce_with_session(house)
        await house.command("simple:bell", "lamp", "on_off", True, expires_after=9.9, kept_for=1.9)
        assert [one.properties.message_expiry_interval for one in await house.heard()] == [1]


async def test_a_part_without_reports_gets_commands_as_soon_as_the_broker_is_back() -> None:
    """Nothing is ever heard of a scene, so that silence says nothing about it."""
    async with simple_house() as house:
        await announce_with_session(house)
        house.broker.links[-1].abort()
        await anyio.sleep(1.0)
        assert (await house.command("simple:bell", "lamp", "on_off", True)).success
        assert await house.heard()


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
