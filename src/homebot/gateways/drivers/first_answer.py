"""The first of several addresses of a device that answers."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from typing import Final, TypeVar

from homebot.errors import LinkError

__all__ = ["first_answer"]

Answer = TypeVar("Answer")

MAX_ASKED: Final = 4
"""Addresses that are asked; a device has an IPv4 address and up to three of IPv6."""


async def first_answer(name: str, addresses: Sequence[str], ask: Callable[[str], Awaitable[Answer]]) -> Answer:
    """Ask one address after the other, and return the first answer.

    Args:
        name: The name of the device, for errors.
        addresses: Its addresses, best first.
        ask: Asks an address; a LinkError means that it does not answer.

    Raises:
        LinkError: None of them answers; the error of the last one.
    """
    failed = LinkError(f"{name} has no address")
    for address in addresses[:MAX_ASKED]:
        try:
            return await ask(address)
        except LinkError as exc:
            failed = exc
    raise failed
