"""Asking a phone whether it is there."""

import anyio

from homebot.features.people.people_gateway import answers


async def test_a_computer_that_refuses_the_connection_is_there() -> None:
    with anyio.fail_after(10):
        assert await answers("127.0.0.1") is True


async def test_a_name_that_nobody_knows_tells_nothing() -> None:
    with anyio.fail_after(10):
        assert await answers("no-such-phone.invalid") is None
