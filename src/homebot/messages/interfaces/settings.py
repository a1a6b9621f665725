"""Table ``[ros]`` of the configuration: the interfaces that clients may name."""

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict

from homebot.config import FilePath, Table, parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.messages.interfaces.interface_text import parse_interface
from homebot.messages.interfaces.interfaces import Interfaces

__all__ = ["RosSettings", "read_interfaces"]


class RosSettings(BaseModel):
    """The keys of the table ``[ros]``.

    Attributes:
        interfaces: Folders with ``.msg``, ``.srv`` and ``.action`` files, such as from ``homebot interface import``.
        distro: The ROS 2 distribution whose definitions are used if they differ.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    interfaces: tuple[FilePath, ...] = ()
    distro: Literal["humble", "jazzy", "kilted"] = "jazzy"


def read_interfaces(table: Table, source: str, folder: Path) -> Interfaces:
    """Return the interfaces in the *table* ``[ros]`` of the file *source*, with paths relative to *folder*.

    Each file is parsed; its class is built on first use.

    Raises:
        ConfigError: A key, a folder or a definition is wrong.
    """
    settings = parse_settings(RosSettings, table, source, "ros", folder)
    texts: dict[str, str] = {}
    try:
        for one in settings.interfaces:
            texts |= Interfaces.read_folder(one)
        for key, text in texts.items():
            parse_interface(key, text)
    except (OSError, UsageError) as exc:
        raise ConfigError(source, "ros.interfaces", str(exc)) from exc
    return Interfaces(texts, settings.distro)
