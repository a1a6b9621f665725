"""The table ``[thing_directory]``."""

from typing import Annotated

from pydantic import Field

from homebot.bridges.admission import AccessSettings, Count
from homebot.config import FilePath

__all__ = ["DirectoryBridgeSettings", "ThingDirectoryTable"]


class DirectoryBridgeSettings(AccessSettings):
    """The settings of homebot's directory for other programs.

    Attributes:
        port: TCP port; 0 takes a free one.
        allows_commands: Whether properties can be set; else they can be read alone.
        max_devices: Devices that are listed; further ones are counted.
    """

    port: Annotated[int, Field(ge=0, le=65535)] = 8081
    allows_commands: bool = True
    max_devices: Count = 10_000


class ThingDirectoryTable(DirectoryBridgeSettings):
    """The keys of the table ``[thing_directory]``.

    Attributes:
        token_file: File with the token in its first line, readable by its owner only.
    """

    token_file: FilePath | None = None
