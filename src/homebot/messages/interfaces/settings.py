"""Table ``[ros]`` of the configuration: the interfaces that clients may name, and the link to robots."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from homebot.config import FilePath, SecretFile, Table, parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.messages.interfaces.interface_text import parse_interface
from homebot.messages.interfaces.interfaces import Interfaces
from homebot.support.addresses import is_loopback

_ADDRESS = re.compile(r"(tcp|tls)/(.+):(\d{1,5})")


def _check_address(text: str) -> str:
    match = _ADDRESS.fullmatch(text)
    if match is None:
        raise ValueError(
            f"{text[:100]!r} is no address of Zenoh; write it like tcp/127.0.0.1:7447 or tls/robot.lan:7447"
        )
    if match[1] == "tcp" and not is_loopback(match[2]):
        raise ValueError(f"{text} could be changed on its way; use tls/… for another computer, and its ca")
    return text


def _check_listen(text: str) -> str:
    return text and _check_address(text)


def _check_pattern(text: str) -> str:
    if not re.fullmatch(r"(/[\w*]+)+", text):
        raise ValueError(f"{text[:100]!r} is no name of topics or services such as /map, /rosie/* or /rosie/**")
    return text


_Patterns: TypeAlias = tuple[Annotated[str, AfterValidator(_check_pattern)], ...]


class RosSettings(BaseModel):
    """The keys of the table ``[ros]``.

    Attributes:
        interfaces: Folders with ``.msg``, ``.srv`` and ``.action`` files at any depth, such as a workspace's ``src``.
        distro: The ROS 2 distribution whose definitions are used if they differ.
        connect: Addresses of Zenoh routers to connect to.
        listen: The address at which homebot is the router; empty for none. With ``connect`` that of ``homebot router``.
        ca: File with the certificate that vouches for those to connect to at addresses of ``tls/``.
        cert_file: File with the certificate to listen with at an address of ``tls/`` (PEM).
        key_file: File with its key, readable by its owner only.
        user: The name with which homebot logs in at the routers to connect to; by default *machine*, or that of the
            owner at its own ``homebot router``, if there is *listen*.
        password_file: File with the password of *user*, or the secret of *machine*, in its first line, readable by its
            owner only.
        machine: The name of this machine in the house whose homebot has its gateways; empty if this has them.
        domain: The ROS domain.
        export: Names of topics and services that robots may see; ``*`` is a part of a name, ``**`` any number of parts.
        imports: Names of topics and services that come from robots, by the robots, each of which needs a token.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    interfaces: tuple[FilePath, ...] = ()
    distro: Literal["humble", "jazzy", "kilted"] = "jazzy"
    connect: tuple[Annotated[str, AfterValidator(_check_address)], ...] = ()
    listen: Annotated[str, AfterValidator(_check_listen)] = ""
    ca: FilePath | None = None
    cert_file: FilePath | None = None
    key_file: SecretFile | None = None
    user: str = ""
    password_file: SecretFile | None = None
    machine: str = ""
    domain: Annotated[int, Field(ge=0, le=232)] = 0
    export: _Patterns = ()
    imports: Mapping[str, _Patterns] = Field(default_factory=dict, alias="import")

    @model_validator(mode="after")
    def _check_files(self) -> Self:
        if self.machine and self.password_file is None:
            raise ValueError("a machine needs password_file, with the secret that it shares with the house")
        if bool(self.user or self.machine) != (self.password_file is not None):
            raise ValueError("give user and password_file together")
        if self.listen.startswith("tls/") and (self.cert_file is None or self.key_file is None):
            raise ValueError(f"{self.listen} needs cert_file and key_file; make them: homebot router --certificate")
        return self

    @property
    def has_link(self) -> bool:
        """True if there is a link to robots."""
        return bool(self.connect or self.listen)


def read_interfaces(table: Table, source: str, folder: Path) -> Interfaces:
    """Return the interfaces in the *table* ``[ros]`` of the file *source*, with paths relative to *folder*.

    Each file is parsed; its class is built on first use.

    Raises:
        ConfigError: A key, a folder or a definition is wrong.
    """
    settings = parse_settings(RosSettings, table, source, "ros", folder)
    texts: dict[str, str] = {}
    try:
        for interface in settings.interfaces:
            texts |= Interfaces.read_folder(interface)
        for key, text in texts.items():
            parse_interface(key, text)
    except (OSError, UsageError) as exc:
        raise ConfigError(source, "ros.interfaces", str(exc)) from exc
    return Interfaces(texts, settings.distro)
