"""Fixtures: a home with control, as in ``tests/control``."""

from tests.control.conftest import home, home_settings, open_home

__all__ = ["home", "home_settings", "open_home"]
