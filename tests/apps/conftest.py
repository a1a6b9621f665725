"""The home of the tests of control, for apps whose commands are to be seen one by one."""

from __future__ import annotations

from tests.control.conftest import open_home

__all__ = ["open_home"]
