"""Test runs inside of tests."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _inner_runs_are_the_same_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever options the outer run was given by the environment, and if a plug-in that shuffles is installed."""
    monkeypatch.setenv("PYTEST_ADDOPTS", "-p no:randomly")
