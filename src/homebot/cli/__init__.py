"""The command line."""

from homebot.cli.main import main

__all__ = ["main"]
