"""The home of the tests of control, for apps whose commands are to be seen one by one."""

from tests.control.conftest import open_home

from homebot.clock import read_zone

__all__ = ["open_home"]

read_zone("UTC")  # that of apps in tests, read from the disk before any loop runs
