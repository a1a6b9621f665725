"""Table ``[ros]`` of the configuration: the interfaces that clients may name."""

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict

from homebot.config import FilePath
from homebot.messages.interfaces.interface_text import parse_interface
from homebot.messages.interfaces.interfaces import DISTRIBUTIONS, Interfaces

__all__ = ["RosSettings"]


def _known(distribution: str) -> str:
    if distribution not in DISTRIBUTIONS:
        raise ValueError(f"known are {', '.join(DISTRIBUTIONS)}")
    return distribution


class RosSettings(BaseModel):
    """The keys of the table ``[ros]``.

    Attributes:
        interfaces: Folders with ``.msg``, ``.srv`` and ``.action`` files, as in a workspace of ROS.
        distro: The distribution of ROS 2 whose definitions count, where they differ.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    interfaces: tuple[FilePath, ...] = ()
    distro: Annotated[str, AfterValidator(_known)] = "jazzy"

    def read(self) -> Interfaces:
        """Return the interfaces of these settings; each file is parsed, its class made when it is first named.

        Raises:
            OSError: A folder cannot be read.
            UsageError: A file is invalid; the message names its type and line.
        """
        texts: dict[str, str] = {}
        for folder in self.interfaces:
            texts |= Interfaces.read_folder(folder)
        for key, text in texts.items():
            parse_interface(key, text)
        return Interfaces(texts, self.distro)
