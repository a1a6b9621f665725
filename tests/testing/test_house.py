"""A house in a test: the devices' side of the wire, and a clear word when nothing comes."""

from __future__ import annotations

import pytest

from homebot.errors import UsageError
from homebot.testing import TestHouse, house_of


async def test_an_app_in_a_house_hears_devices_and_is_heard() -> None:
    """Each topic has its own line of payloads."""
    async with house_of("light_service", root="villa") as house:
        await house.says("villa/lights/a/out", "on")
        await house.says("villa/lights/b/out", "on")
        assert await house.hears("villa/lights/b/in") == "off"
        assert await house.hears("villa/lights/a/in") == "off"


async def test_what_does_not_come_is_told_with_what_came_instead() -> None:
    """And with the apps that crashed; here none."""
    async with house_of("light_service") as house:
        await house.says("home425/lights/a/out", "on")
        with pytest.raises(TimeoutError) as caught:
            await house.hears("home425/lights/b/in", within="300ms")
    assert str(caught.value) == (
        "nothing came on home425/lights/b/in within 0.3 s; "
        "received elsewhere: {'home425/lights/a/in': ['off']}; crashed: nothing"
    )


def test_pytest_does_not_take_the_house_for_a_test() -> None:
    """Its name begins with Test."""
    assert not TestHouse.__test__


async def test_a_test_hears_wherever_it_listens_and_not_itself() -> None:
    """Also what was said before it listens, and outside of the home; it used to say that nothing came."""
    async with house_of(root="villa") as house, house.client("somebody") as somebody:
        await somebody.wait_connected()
        await house.says("attic/lamp/orders", "mine")
        await somebody.publish("attic/lamp/orders", b"OFF", qos=1)
        assert await house.hears("attic/lamp/orders") == "OFF"
        with pytest.raises(TimeoutError, match="nothing came on attic/lamp/orders within"):
            await house.hears("attic/lamp/orders", within=0.01)


async def test_a_test_listens_on_one_topic() -> None:
    async with house_of() as house:
        with pytest.raises(UsageError, match="give a topic without wildcards"):
            await house.hears("attic/#")
