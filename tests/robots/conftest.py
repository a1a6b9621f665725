"""The home of the tests of control, whose devices report what a test says."""

from tests.control.conftest import open_home

__all__ = ["open_home"]
