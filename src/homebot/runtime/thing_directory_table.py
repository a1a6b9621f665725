"""The table ``[thing_directory]`` of a configuration."""

from __future__ import annotations

from homebot.bridges.thing_directory import DirectoryBridgeSettings
from homebot.config import FilePath

__all__ = ["ThingDirectoryTable"]


class ThingDirectoryTable(DirectoryBridgeSettings):
    """The keys of the table ``[thing_directory]``.

    Attributes:
        token_file: File whose first line is the token, for nobody else to read.
    """

    token_file: FilePath | None = None
