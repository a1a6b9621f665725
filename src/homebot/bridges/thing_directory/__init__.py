"""homebot's directory for other programs: a W3C Thing Description Directory over HTTP."""

from homebot.bridges.thing_directory.settings import DirectoryBridgeSettings

__all__ = ["DirectoryBridgeSettings"]
