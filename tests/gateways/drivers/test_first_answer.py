"""The addresses of a device are asked one after the other."""

import pytest

from homebot.errors import LinkError, RefusedError
from homebot.gateways.drivers.base import MAX_ASKED, first_answer

ADDRESSES = tuple(f"10.0.0.{number}" for number in range(1, 9))


async def test_the_first_answer_counts() -> None:
    async def ask(address: str) -> str:
        if address != "10.0.0.3":
            raise LinkError(f"{address} does not answer")
        return address

    assert await first_answer("Hall", ADDRESSES, ask) == "10.0.0.3"


async def test_a_refusal_is_an_answer() -> None:
    async def ask(address: str) -> str:
        raise RefusedError(address, "give a password")

    with pytest.raises(RefusedError, match="give a password"):
        await first_answer("Hall", ADDRESSES, ask)


async def test_only_a_few_addresses_are_asked() -> None:
    asked: list[str] = []

    async def ask(address: str) -> str:
        asked.append(address)
        raise LinkError(f"{address} does not answer")

    with pytest.raises(LinkError, match=ADDRESSES[MAX_ASKED - 1]):
        await first_answer("Hall", ADDRESSES, ask)
    assert len(asked) == MAX_ASKED


async def test_a_device_without_an_address_cannot_be_asked() -> None:
    async def ask(address: str) -> str:
        return address

    with pytest.raises(LinkError, match="Hall has no address"):
        await first_answer("Hall", (), ask)
