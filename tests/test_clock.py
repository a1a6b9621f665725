"""The clocks, and the zone of the computer."""

import asyncio
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from homebot.clock import LoopClock, ManualClock, read_zone, zone_name
from homebot.errors import UsageError


@pytest.mark.virtual_time
async def test_both_readings_of_a_loop_clock_run_with_virtual_time() -> None:
    clock = LoopClock(epoch=1_000.0)
    start = clock.monotonic()
    await asyncio.sleep(86_400)
    assert clock.monotonic() - start == 86_400
    assert clock.now() == 87_400


@pytest.mark.virtual_time
async def test_without_an_epoch_virtual_time_starts_at_the_computers_own() -> None:
    before = time.time()
    clock = LoopClock()
    await asyncio.sleep(3_600)
    assert before <= clock.now() - 3_600 <= time.time()


async def test_on_a_real_loop_now_is_the_computers_time_even_after_it_was_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hub that slept, or whose clock was set, must not stamp with the old offset for ever."""
    times = iter([1_000.0, 1_000.0, 2_000_000_000.0])
    monkeypatch.setattr(time, "time", lambda: next(times))
    clock = LoopClock()
    assert clock.now() == 1_000.0
    assert clock.now() == 2_000_000_000.0
    assert clock.monotonic() == pytest.approx(asyncio.get_running_loop().time(), abs=1)


async def test_on_a_real_loop_a_given_epoch_is_kept() -> None:
    assert LoopClock(epoch=0.0).now() == pytest.approx(0.0, abs=1)


def test_a_manual_clock_stands_still_until_it_is_moved() -> None:
    clock = ManualClock(10.0)
    assert (clock.monotonic(), clock.now()) == (10.0, 10.0)
    clock.advance(2.5)
    assert (clock.monotonic(), clock.now()) == (12.5, 12.5)


def test_a_manual_clock_does_not_go_back() -> None:
    with pytest.raises(UsageError, match="does not go back: -1"):
        ManualClock().advance(-1)


SUMMER = datetime(2026, 7, 1, tzinfo=UTC)


@pytest.mark.parametrize("value", ["Asia/Tokyo", ":Asia/Tokyo", ":/usr/share/zoneinfo/Asia/Tokyo"])
def test_the_environment_names_the_zone_of_the_computer(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, value: str
) -> None:
    monkeypatch.setenv("TZ", value)
    assert zone_name("", tmp_path) == "Asia/Tokyo"


def test_the_zone_of_the_computer_is_that_of_its_settings(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A link into the folder of zones has a name; a copy of a zone's file has none, and the same summer time."""
    monkeypatch.delenv("TZ", raising=False)
    folder = tmp_path / "zoneinfo" / "Europe"
    folder.mkdir(parents=True)
    (folder / "Berlin").write_bytes(Path("/usr/share/zoneinfo/Europe/Berlin").read_bytes())
    (link := tmp_path / "localtime").symlink_to(folder / "Berlin")
    assert zone_name("", link) == "Europe/Berlin"
    copy = folder.rename(tmp_path / "copies") / "Berlin"
    assert zone_name("", copy) == ""
    assert SUMMER.astimezone(read_zone("", copy)).utcoffset() == timedelta(hours=2)


def test_a_computer_without_settings_is_in_utc(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("TZ", "CET-1CEST,M3.5.0,M10.5.0/3")
    assert read_zone("", tmp_path / "missing") is UTC
