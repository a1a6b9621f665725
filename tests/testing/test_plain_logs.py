"""The log of a house, where nobody has chosen another."""

from __future__ import annotations

import asyncio

import pytest
import structlog

from homebot.apps import App
from homebot.testing import VirtualTimeLoop, virtual_house_of
from homebot.testing.contexts import plain_logs


class Broken(App):
    """An app that crashes with something in its variables that is nobody's business."""

    async def run(self) -> None:
        pin = "8" * 4
        raise RuntimeError(f"a pin of {len(pin)} digits")


async def a_house_with_a_crash() -> tuple[str, ...]:
    async with virtual_house_of(f"{Broken.__module__}:{Broken.__qualname__}") as house:
        await house.run_for(1)
        return house.crashed


def test_a_crash_in_a_house_is_told_without_the_variables_and_in_its_time(capsys: pytest.CaptureFixture[str]) -> None:
    structlog.reset_defaults()
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        assert runner.run(a_house_with_a_crash()) == ("app_1",)
    told = capsys.readouterr().out
    assert "RuntimeError: a pin of 4 digits" in told
    assert "8888" not in told
    assert "00:00:00  homebot        homebot is running\n" in told
    assert "debug" not in told
    assert not structlog.is_configured()


def test_a_log_that_the_program_has_set_up_is_left_alone() -> None:
    mine = [structlog.processors.KeyValueRenderer()]
    structlog.configure(processors=mine)
    with plain_logs():
        assert structlog.get_config()["processors"] is mine
    assert structlog.get_config()["processors"] is mine


def test_a_log_that_is_set_up_meanwhile_stays() -> None:
    structlog.reset_defaults()
    mine = [structlog.processors.KeyValueRenderer()]
    with plain_logs():
        structlog.configure(processors=mine)
    assert structlog.get_config()["processors"] is mine
