"""Routines have the time zone of the home; their commands are tried as in ``tests/cli``."""

from tests.cli.conftest import homebot, homebot_with

from homebot.clock import read_zone

__all__ = ["homebot", "homebot_with"]

read_zone("UTC")  # read from the disk before any loop runs
