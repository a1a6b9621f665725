"""Routines that are tried on a recorded day."""

import asyncio
import gzip
import tomllib
from pathlib import Path

import pytest
from tests.apps.houses import hall
from tests.replay.recorded_days import MemorySink

from homebot.cli.main import main
from homebot.config import parse_config
from homebot.features.routines.command_trial import trial_lines
from homebot.recording.recording import load_recording
from homebot.testing import VirtualTimeLoop, virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.rooms("homeassistant", "recording")]

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
        async with virtual_house_of(world=world, start="2026-01-01 08:00", observers=sink.observers()) as house:
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
    (tmp_path / "toggle.toml").write_text(ROUTINE.replace("lamp on", "lamp toggle"))
    assert main(["routine", "try", str(tmp_path / "toggle.toml"), "--on", str(day)]) == 0
    first, second, _ = capsys.readouterr().out.splitlines()
    assert "hall_lamp  on  night_light" in first
    assert "hall_lamp  off  night_light" in second
    assert "toggled from what it was then" in second
    assert summary.endswith("night_light would have given 2 commands, 1 of which somebody changed within ten minutes")


def test_the_acts_of_robots_are_told_and_scenes_and_groups_of_the_file_are_known(day: Path) -> None:
    more = """
[[groups]]
name = "Night"
members = "lights in hall"
[[scenes]]
name = "Dim"
values = { "hall lamp" = "on, 20 %" }
"""
    text = ROUTINE.replace('["hall lamp on"]', '["scene Dim", "group=Night off", "rosie go to kitchen"]')
    lines = trial_lines("day", load_recording(day), parse_config(tomllib.loads(text + more), "new.toml"))
    assert [line.partition("  ")[2] for line in lines if "rosie" in line] == [
        "would send: rosie go to kitchen  night_light"
    ] * 2
    assert any("hall_lamp  on, level 20 %  night_light, because the scene Dim was applied" in line for line in lines), (
        lines
    )
    assert any("hall_lamp  off  night_light" in line for line in lines), lines
    assert lines[-1].endswith("and sent a robot 2 times")


def test_what_the_history_does_not_have_is_told_in_the_summary(day: Path) -> None:
    given = parse_config(tomllib.loads(ROUTINE), "new.toml")
    unseen = {"night_light": ["hall button press", "rosie leaves hall"]}
    summary = trial_lines("the last week", load_recording(day), given, unseen)[-1]
    assert "; the history does not have 'hall button press', 'rosie leaves hall': record some days" in summary


def test_a_wrong_routine_is_refused_with_its_line(
    day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "new.toml"
    file.write_text(f'{ROUTINE}[[routines]]\nname = "Film"\nwhen = ["sunset"]\ndo = ["hall lamp on"]\n')
    assert main(["routine", "try", str(file), "--on", str(day)]) == 1
    assert f"{file}:8: routines.film: 'sunset' needs the place of the home: set latitude" in capsys.readouterr().err


def test_every_wrong_text_of_a_file_is_named_with_its_line_without_a_running_homebot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "new.toml"
    film = '[[routines]]\nname = "Film"\nwhen = ["22:60"]\ndo = ["wait 999999999h", "hall lamp onn"]\n'
    file.write_text(f"{ROUTINE.replace('occupied', 'ocupied')}{film}")
    assert main(["routine", "try", str(file)]) == 1
    assert [line.split(": ")[1:3] for line in capsys.readouterr().err.splitlines()] == [
        [f"{file}:6", "routines.night_light.when.0"],
        [f"{file}:10", "routines.film.when.0"],
        [f"{file}:11", "routines.film.do.0"],
        [f"{file}:11", "routines.film.do.1"],
    ]


@pytest.mark.parametrize("time", ["0s", "", "-3d", "yesterday", "nan", "99999999h"])
def test_a_time_that_is_none_is_refused_with_examples(
    time: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "new.toml").write_text(ROUTINE)
    assert main(["routine", "try", str(tmp_path / "new.toml"), f"--on={time}"]) == 1
    problem = f"--on {time!r}: neither a recording nor a time; write it like last-week, last-day, 3d or 12h"
    assert problem in capsys.readouterr().err


def test_a_file_without_routines_is_refused(day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "none.toml").write_text("[home]\n")
    assert main(["routine", "try", str(tmp_path / "none.toml"), "--on", str(day)]) != 0
    assert "has no table [[routines]]" in capsys.readouterr().err
