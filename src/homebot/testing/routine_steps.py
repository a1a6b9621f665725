"""The steps that an exported routine takes, for its test."""

from collections.abc import AsyncIterator, Collection
from typing import Protocol


class ExportedRoutine(Protocol):
    """An app that a routine was exported as."""

    async def perform(self) -> None:
        """Take the steps."""


async def steps_of(kind: type[ExportedRoutine], holds: Collection[str] = ()) -> list[str]:
    """Return the steps that an app takes in one run, without a house.

    Args:
        holds: The conditions that hold; all others do not.
    """
    taken: list[str] = []

    class Noted(kind):  # type: ignore[valid-type, misc]
        """Takes down its steps."""

        async def step(self, text: str) -> bool:
            taken.append(text)
            return True

        async def holds(self, *conditions: str) -> bool:
            return set(conditions) <= set(holds)

        async def turns(self, _: str) -> AsyncIterator[None]:
            yield

    await Noted.perform(object.__new__(Noted))
    return taken
