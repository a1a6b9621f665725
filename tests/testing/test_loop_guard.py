"""The watch over the loop of a test: code that blocks it is ended with its line, and that of an app is named."""

import asyncio
import select
import signal
from collections.abc import Callable

import pytest

from homebot.errors import ExitError, UsageError
from homebot.support.isolation import run_as
from homebot.testing.loop_guard import LoopGuard

pytestmark = pytest.mark.slow

NEVER = 1e6


def guarded(code: Callable[[], object], *, is_app: bool = True, ended_after: float = 1.5) -> LoopGuard:
    """Run *code* on a loop with a guard, as an app, or as a test itself."""

    async def call() -> None:
        code()

    with asyncio.Runner() as runner, LoopGuard(runner.get_loop(), ended_after) as guard:
        runner.run(run_as("app", call) if is_app else call())
    return guard


def wait(seconds: float) -> None:
    select.select((), (), (), seconds)


def spin() -> None:
    while True:
        pass


@pytest.mark.parametrize("code", [spin, lambda: wait(NEVER)])
def test_code_that_never_ends_its_turn_is_ended_with_its_line(code: Callable[[], object]) -> None:
    """Also while it waits for the system, without a processor."""
    with pytest.raises(UsageError, match=r"test_loop_guard\.py:\d+ \((spin|wait)\) has blocked the event loop"):
        guarded(code)


def test_code_that_catches_every_exception_is_ended_too() -> None:
    def stubborn() -> None:
        while True:
            try:
                spin()
            except UsageError:
                continue

    with pytest.raises(ExitError, match="has blocked the event loop"):
        guarded(stubborn)


def test_an_app_that_blocks_for_a_second_is_named_and_goes_on() -> None:
    (place,) = guarded(lambda: wait(2.5), ended_after=NEVER).blocked_by
    assert place.endswith("(wait)")


def test_a_test_may_compute_for_seconds_itself() -> None:
    assert not guarded(lambda: wait(2.5), is_app=False, ended_after=NEVER).blocked_by


def test_a_debugger_may_wait_for_its_user() -> None:
    module: dict[str, object] = {"__name__": "pdb", "wait": wait}
    exec("def prompt(): wait(3)", module)  # noqa: S102 - as a debugger does
    prompt = module["prompt"]
    assert callable(prompt)
    assert not guarded(prompt, ended_after=1.0).blocked_by


def test_time_between_two_runs_of_the_loop_does_not_count() -> None:
    """A fixture that is no coroutine takes its time while the loop stands still."""

    async def nothing() -> None: ...

    with asyncio.Runner() as runner, LoopGuard(runner.get_loop(), ended_after=1.0) as guard:
        runner.run(nothing())
        wait(2.5)
        runner.run(nothing())
    assert not guard.blocked_by


def test_the_signal_has_its_old_handler_afterwards() -> None:
    before = signal.getsignal(signal.SIGURG)
    guarded(lambda: None)
    assert signal.getsignal(signal.SIGURG) is before
