"""The packages here are somebody else's: their tests run where they are installed, not with ours."""

from __future__ import annotations

import pytest

collect_ignore_glob = ["homebot-*"]


def pytest_itemcollected(item: pytest.Item) -> None:
    item.add_marker(pytest.mark.slow)
