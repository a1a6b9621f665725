"""Where the index is kept: another broker has another file."""

from __future__ import annotations

from pathlib import Path

import pytest

from homebot.config import parse_config
from homebot.runtime.plan import index_place


@pytest.fixture(autouse=True)
def _data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path))


def place(url: str, home: str = "villa") -> tuple[str, ...]:
    gateway = {"url": url} if url else {}
    return index_place(parse_config({"home": {"name": home}, "gateways": {"mqtt": gateway}}, "test")).parts[-3:]


def test_each_broker_of_a_home_has_its_own() -> None:
    assert place("") == ("villa", "embedded", "index.sqlite")
    assert len({place(url) for url in ("", "mqtt://a", "mqtt://b", "mqtt://a:1884", "mqtts://a")}) == 5


def test_how_a_broker_is_spelt_makes_no_difference() -> None:
    assert place("mqtt://Broker.example") == place("mqtt://broker.example:1883")
