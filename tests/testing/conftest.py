"""Test runs inside of tests."""

from __future__ import annotations

import gc
import warnings
from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True)
def _inner_runs_keep_their_order(request: pytest.FixtureRequest) -> Iterator[None]:
    """Also where a plug-in that shuffles is installed: the tests read what an inner run says, in its order."""
    if "pytester" in request.fixturenames:
        request.getfixturevalue("pytester")  # it removes these options when it is made
        with warnings.catch_warnings():  # of what earlier tests left: the inner run would fail with them
            warnings.simplefilter("ignore")
            gc.collect()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTEST_ADDOPTS", "-p no:randomly")
        yield
