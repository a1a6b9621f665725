"""Routines that are tried on a recorded day."""

import asyncio
import gzip
from pathlib import Path

import pytest
from tests.apps.houses import hall
from tests.replay.recorded_days import MemorySink

from homebot.cli.main import main
from homebot.testing import VirtualTimeLoop, virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.rooms("homeassistant")]

ROUTINE = """
[home]
zone = "UTC"
[[routines]]
name = "Night light"
when = ["hall motion occupied"]
do = ["hall lamp on"]
"""


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Half an hour in which Anna comes twice, and turns the lamp off by hand after she came the second time."""
    sink = MemorySink()
    world = hall(("08:05", "hall"), ("08:06", "outside"), ("08:20", "hall"))

    async def live() -> None:
        async with virtual_house_of(world=world, start="2026-01-01 08:00", record_into=sink) as house:
            await house.run_until("08:19")
            await house.press("hall_lamp", "on")
            await house.run_until("08:23")
            await house.press("hall_lamp", "off")
            await house.run_until("08:30")

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live())
    path = tmp_path_factory.mktemp("recorded") / "day.jsonl.gz"
    path.write_bytes(gzip.compress("".join(f"{line}\n" for line in sink.lines).encode()))
    return path


def test_a_trial_tells_what_would_have_been_done_and_what_somebody_did_then(
    day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TZ", "UTC")
    (tmp_path / "new.toml").write_text(ROUTINE)
    assert main(["routine", "try", str(tmp_path / "new.toml"), "--on", str(day)]) == 0
    first, second, summary = capsys.readouterr().out.splitlines()
    assert "hall_lamp  on  night_light, because hall_motion reported occupied" in first
    assert "somebody" not in first
    assert second.endswith("later somebody: off")
    assert summary.endswith("night_light would have given 2 commands, 1 of which somebody changed within ten minutes")


def test_a_file_without_routines_is_refused(day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "none.toml").write_text("[home]\n")
    assert main(["routine", "try", str(tmp_path / "none.toml"), "--on", str(day)]) != 0
    assert "has no table [[routines]]" in capsys.readouterr().err
