"""Guessing tokens becomes slow, and stays bearable for whoever knows the right one."""

import anyio
import pytest
from pydantic import SecretStr

from homebot.bridges.token_check import TokenCheck
from homebot.clock import LoopClock

pytestmark = pytest.mark.virtual_time

LONG, SHORT = "0123456789abcdef", "1234"


def checked() -> TokenCheck:
    return TokenCheck({"robot": SecretStr(LONG), "page": SecretStr(SHORT)}, LoopClock())


async def waited(check: TokenCheck, address: str, token: str = "wrong") -> float:
    """The seconds that a token from an address waits."""
    began = anyio.current_time()
    assert await check.check(address, token) is not None
    return anyio.current_time() - began


async def guessed(*addresses: str) -> TokenCheck:
    """A check that was shown thirty wrong tokens from some addresses by turns."""
    check = checked()
    for number in range(30):
        await check.check(addresses[number % len(addresses)], "wrong")
    return check


async def test_the_first_wrong_tokens_cost_nothing_and_then_each_waits_longer_up_to_a_second() -> None:
    check = checked()
    waits = [await waited(check, "10.0.0.5") for _ in range(12)]
    assert waits[:6] == pytest.approx([0.0] * 5 + [0.1])
    assert waits[5:] == sorted(waits[5:])
    assert waits[-1] == pytest.approx(1.0)
    assert check.wrong == 12


async def test_the_right_token_waits_as_long_as_a_wrong_one_and_is_not_counted() -> None:
    check = await guessed("10.0.0.5")
    assert await waited(check, "10.0.0.5", SHORT) == pytest.approx(1.0)
    assert check.wrong == 30
    assert await waited(check, "10.0.0.6") == 0.0


async def test_only_four_tokens_of_an_address_wait_at_a_time() -> None:
    check = await guessed("10.0.0.5")
    async with anyio.create_task_group() as tasks:
        for _ in range(4):
            tasks.start_soon(check.check, "10.0.0.5", "wrong")
        await anyio.sleep(0.5)
        assert await check.check("10.0.0.5", LONG) is None
    assert await check.check("10.0.0.5", LONG) == "robot"


async def test_wrong_tokens_are_forgotten_in_time() -> None:
    check = await guessed("10.0.0.5")
    assert check.problems() == ("wrong tokens were received from 10.0.0.5",)
    await anyio.sleep(155.0)
    assert await waited(check, "10.0.0.5") == 0.0
    await anyio.sleep(145.0)
    assert check.problems() == ()
    assert not check._attempts


async def test_addresses_of_one_network_are_one_address() -> None:
    check = await guessed(*(f"2001:db8::{number:x}" for number in range(30)))
    assert await waited(check, "2001:db8::ffff") == pytest.approx(1.0)
    assert await waited(check, "2001:db8:0:1::1") == 0.0
    check = await guessed("::ffff:10.0.0.5")
    assert await waited(check, "10.0.0.5") == pytest.approx(1.0)


async def test_it_remembers_a_thousand_addresses_and_programs_at_most() -> None:
    check = checked()
    for number in range(1001):
        for token in ("wrong", LONG):
            await check.check(f"10.0.{number // 256}.{number % 256}", token)
    assert len(check._attempts) == len(check._proven) == 1000
    assert ("10.0.0.0", "robot") not in check._proven


async def test_a_long_token_that_was_right_does_not_wait_and_a_short_one_tells_no_guesser_anything() -> None:
    check = checked()
    for token in (LONG, SHORT):
        await check.check("10.0.0.5", token)
    for number in range(60):
        await check.check(f"10.0.0.{5 + number % 2}", "wrong")
    assert await waited(check, "10.0.0.5", LONG) == 0.0
    assert await waited(check, "10.0.0.5", SHORT) == pytest.approx(1.0)
    assert await waited(check, "10.0.0.6", LONG) == pytest.approx(1.0)
