"""``homebot mcp`` without its libraries; with them, tests/peers/test_agents.py speaks to it."""

from __future__ import annotations

import pytest

from homebot.cli import main


def test_without_the_extra_the_command_that_installs_it_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    assert main(["mcp", "--door", "9"]) == 1
    assert capsys.readouterr().err == 'homebot: homebot mcp needs mcp; install it with: pip install "homebot[mcp]"\n'
