"""The address and the token of the running homebot that a client command connects to.

In this order: `--home` or `--door`, the table ``[door]`` of ``homebot.toml`` in the working directory, HOMEBOT_DOOR,
the default. The token of that table is only sent to that homebot.

``--home`` names a table of ``homes.toml`` in the user's configuration folder::

    [villa]
    door = "192.168.1.10:9090"
    token_file = "villa.token"       # beside this file
"""

import argparse
import os
import ssl
from pathlib import Path
from typing import Final, NamedTuple

from platformdirs import user_config_path

from homebot.cli.arguments import DEFAULT_CONFIG, DEFAULT_SERVER, ServerHost, server_address, server_of_environment
from homebot.errors import ConfigError, UsageError
from homebot.support.data_folder import data_directory
from homebot.support.file_access import why_not_trusted
from homebot.support.names import did_you_mean, unknown_key
from homebot.support.toml_file import TomlTable, read_toml

_USUAL: Final = frozenset({"host", "port", "token", "token_file", "tokens", "scope", "tls", "certificate", "key"})
"""Keys of the table; for the others, its settings would have to be loaded."""

_LOOPBACK: Final = {"0.0.0.0": "127.0.0.1", "::": "::1"}  # noqa: S104 - a wildcard address is reached here


_EXAMPLE: Final = 'write a table [{name}] with door = "HOST:PORT" and, if it needs one, token_file = "FILE"'


class ServerAddress(NamedTuple):
    """The address of a rosbridge server, with its token.

    Attributes:
        token: The token to send; empty for none.
        source: The file that contains the address; empty for the command line and the environment.
        home: The name that the home must have, according to the configuration; empty for any.
        has_tls: Whether it listens with TLS.
    """

    host: str
    port: int
    token: str = ""
    source: str = ""
    home: str = ""
    has_tls: bool = False

    @property
    def where(self) -> str:
        """Host and port, as in addresses."""
        return f"{f'[{self.host}]' if ':' in self.host else self.host}:{self.port}"


def server_of(options: argparse.Namespace) -> ServerAddress:
    """Return the rosbridge server named by *options*, the configuration or the environment.

    Raises:
        ConfigError: The configuration, the variable or a file with a token cannot be used.
    """
    if options.home is not None:
        return _of_home(options)
    table, home = ({}, "") if options.door else _table(DEFAULT_CONFIG)
    source = str(DEFAULT_CONFIG) if table.keys() & {"host", "port"} else ""
    host, port, has_tls = options.door or (None if source else server_of_environment()) or ServerHost(*_address(table))
    has_tls = has_tls or "certificate" in table or table.get("tls") is True
    if options.token_file is not None:
        token = _read_token(Path(options.token_file), "--token-file")
    else:
        token = _token(table) or os.environ.get("HOMEBOT_DOOR_TOKEN", "")
    return ServerAddress(host, port, token, source, home, has_tls)


def _of_home(options: argparse.Namespace) -> ServerAddress:
    """Return the rosbridge server of the home that ``--home`` names; no token from the environment is sent there."""
    if options.door:
        raise UsageError("--home and --door both give the address of homebot; use one of them")
    path = user_config_path("homebot", appauthor=False) / "homes.toml"
    (host, port, has_tls), token_file = _named_home(options.home, path)
    file, said_by = (token_file, str(path)) if options.token_file is None else (options.token_file, "--token-file")
    token = "" if file is None else _read_token(Path(file), said_by)
    return ServerAddress(_LOOPBACK.get(host, host), port, token, str(path), has_tls=has_tls)


def client_context() -> ssl.SSLContext:
    """Return a context for TLS with the authorities that this computer knows, and that of its own homebot."""
    context = ssl.create_default_context()
    if (authority := data_directory() / "door" / "authority.crt").exists():
        context.load_verify_locations(authority)
    return context


def _named_home(name: str, path: Path) -> tuple[ServerHost, Path | None]:
    """Return the address and token file of the home *name* in *path*, which others must not be able to change."""
    source, example = str(path), _EXAMPLE.format(name=name)
    if not path.exists():
        raise ConfigError(source, "", f"does not exist; {example}")
    homes = read_toml(path)
    if problem := why_not_trusted(path):
        raise ConfigError(source, "", f"has addresses of homes, so others must not be able to change it: {problem}")
    if name not in homes:
        raise ConfigError(source, name, f"there is no such home; {did_you_mean(name, homes, example)}")
    table = homes[name]
    if not isinstance(table, dict) or not isinstance(table.get("door"), str):
        raise ConfigError(source, name, f"has no address; {example}")
    file = table.get("token_file")
    for key in table.keys() - {"door", "token_file"}:
        raise ConfigError(source, f"{name}.{key}", unknown_key(key, ("door", "token_file")))
    try:
        address = server_address(str(table["door"]))
    except argparse.ArgumentTypeError as exc:
        raise ConfigError(source, f"{name}.door", str(exc)) from exc
    if file is not None and not isinstance(file, str):
        raise ConfigError(source, f"{name}.token_file", f"must be a text in quotes, got {file!r}")
    return address, path.parent / file if file else None


def _table(path: Path) -> tuple[TomlTable, str]:
    """Return the table ``[door]`` and the home's name in the file *path*; both empty if there is no such file."""
    if not path.exists():
        return {}, ""
    tables = read_toml(path)
    table = tables.get("door", {})
    if problem := why_not_trusted(path):
        raise ConfigError(str(path), "", f"has the address of homebot; others must not be able to change it: {problem}")
    if not isinstance(table, dict):
        raise ConfigError(str(path), "door", "must be a table, [door]")
    if others := table.keys() - _USUAL:
        # a misspelt ``port`` would lead to another homebot
        from homebot.runtime.rosbridge_table import RosbridgeTable  # noqa: PLC0415 - few tables need it

        known = RosbridgeTable.model_fields
        for key in sorted(others):
            if key not in known:
                raise ConfigError(str(path), f"door.{key}", unknown_key(key, known))
    home = tables.get("home")
    name = home.get("name") if isinstance(home, dict) else None
    return table, name if isinstance(name, str) else ""


def _address(table: TomlTable) -> tuple[str, int]:
    host, port = table.get("host", DEFAULT_SERVER[0]), table.get("port", DEFAULT_SERVER[1])
    if not isinstance(host, str) or not host:
        raise ConfigError(str(DEFAULT_CONFIG), "door.host", f"must be a host, got {host!r}")
    if isinstance(port, bool) or not isinstance(port, int) or not 0 < port <= 65_535:
        raise ConfigError(str(DEFAULT_CONFIG), "door.port", f"must be a port for clients, got {port!r}; give --door")
    return _LOOPBACK.get(host, host), port


def _token(table: TomlTable) -> str:
    token, file = table.get("token", ""), table.get("token_file")
    if isinstance(file, str):
        return _read_token(DEFAULT_CONFIG.parent / file, f"{DEFAULT_CONFIG}: door.token_file")
    return token if isinstance(token, str) else ""


def _read_token(file: Path, source: str) -> str:
    try:
        return file.read_text(encoding="utf-8").partition("\n")[0].strip()
    except OSError as exc:
        raise ConfigError(source, str(file), f"cannot be read: {exc.strerror}") from exc
    except ValueError as exc:
        raise ConfigError(source, str(file), "is not text in UTF-8") from exc
