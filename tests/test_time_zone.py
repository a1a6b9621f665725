"""Time zones: by name, or the computer's, with its days of 23 and 25 hours."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from homebot.clock import read_zone, zone_name

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
