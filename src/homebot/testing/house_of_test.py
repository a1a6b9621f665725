"""The house of a test: made from the marks, held open on the loop of the test, and reported where that fails."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, contextmanager
from typing import TypeVar, final

import pytest

from homebot.errors import UsageError
from homebot.testing.contexts import hold_open
from homebot.testing.event_log import EventLog, house_report
from homebot.testing.house import TestHouse
from homebot.testing.house_marks import allows_crashes, homebot_of, house_by_mark
from homebot.testing.virtual_house import VirtualHouse

__all__ = ["HouseOfTest"]

HouseT = TypeVar("HouseT", bound=TestHouse)


@final
class HouseOfTest:
    """The house that a fixture gives to a test.

    Args:
        reports: Gets, while the house is open, the maker of its title and text for the report of a failed test.
    """

    def __init__(self, test: pytest.Item, fixture: str, reports: list[Callable[[], tuple[str, str]]]) -> None:
        self._test = test
        self._fixture = fixture
        self._reports = reports

    def virtual_house(self) -> AbstractAsyncContextManager[VirtualHouse]:
        """Return the virtual house of the marks; the test fails where they are invalid."""
        with _explained():
            return house_by_mark(self._test)

    def homebot(self, config: object) -> AbstractAsyncContextManager[TestHouse]:
        """Return the homebot with *config* of the marks; the test fails where they are invalid."""
        with _explained():
            return homebot_of(self._test, config)

    @contextmanager
    def shown(self, loop: asyncio.AbstractEventLoop, made: AbstractAsyncContextManager[HouseT]) -> Iterator[HouseT]:
        """Run the house on *loop*, with a log of it for the report of a failed test."""
        with _explained(), hold_open(loop, _with_log(made)) as house:
            self._reports.append(lambda: (f"what happened in `{self._fixture}`", house_report(house)))
            yield house
        self._reports.clear()

    def check_crashes(self, house: TestHouse, *, has_failed: bool) -> None:
        """Fail the test where an app crashed: it was started again, so that the test might not notice."""
        if house.crashed and not allows_crashes(self._test, self._fixture) and not has_failed:
            parts = ", ".join(house.crashed)
            mark = f"@pytest.mark.{self._fixture}(allow_crashes=True)"
            pytest.fail(f"{parts} crashed; where that is meant, {mark}", pytrace=False)


@asynccontextmanager
async def _with_log(made: AbstractAsyncContextManager[HouseT]) -> AsyncIterator[HouseT]:
    async with made as house, EventLog.of(house):
        yield house


@contextmanager
def _explained() -> Iterator[None]:
    """Fail with a message for the test's author, without our code in the traceback."""
    try:
        yield
    except UsageError as exc:
        pytest.fail(str(exc), pytrace=False)
