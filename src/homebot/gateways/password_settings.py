"""The keys by which a table of the configuration names a password, or the credentials of a server."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final, Literal, Self, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, SecretStr, field_validator, model_validator

from homebot.config import PeerAddress, SecretFile, SecretName
from homebot.errors import UsageError
from homebot.support.file_access import check_secret_file as check_secret_file
from homebot.support.file_access import read_secret


class PasswordSettings(BaseModel):
    """A table, or a part of one, that may name a password.

    Attributes:
        password_file: File with the password in its first line, readable by its owner only. Relative paths begin at the
            folder of the configuration's file.
        password_env: Environment variable that holds the password.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    password_file: SecretFile | None = None
    password_env: SecretName | None = None

    @model_validator(mode="after")
    def _check_one_source(self) -> Self:
        if self.password_file and self.password_env:
            raise ValueError("give password_file or password_env, not both")
        return self

    def read_password(self, table: str = "") -> SecretStr | None:
        """Return the password; None where none is named.

        Args:
            table: Prefix of its keys in errors: ``devices.hall.``

        Raises:
            UsageError: It cannot be read; names the key.
        """
        return read_password(self.password_file, self.password_env, f"{table}password")


def read_password(password_file: Path | None, password_env: str | None, name: str = "password") -> SecretStr | None:
    """Return the password, or other secret, that a table names by one of these keys; None where it names none.

    Args:
        password_file: File with the password in its first line.
        password_env: Environment variable that holds the password.
        name: Prefix of the keys.

    Raises:
        UsageError: It cannot be read; names the key.
    """
    if password_env is not None:
        if password_env not in os.environ:
            raise UsageError(f"{name}_env: the environment variable {password_env} is not set")
        return SecretStr(os.environ[password_env])
    if password_file is not None:
        try:
            return SecretStr(read_secret(password_file))
        except UsageError as exc:
            raise UsageError(f"{name}_file: {exc}") from exc
    return None


LoginScheme: TypeAlias = Literal["basic", "bearer"]
"""The ways in which credentials are sent to things."""

_GONE: Final = ("digest", "apikey")


class HttpLoginSettings(PasswordSettings):
    """The credentials for the things of one host; the password may be a token.

    Attributes:
        host: The name or address of the host, with a port where it is for that alone: ``lamp.local``,
            ``192.168.1.20:8443``. They are sent to no other.
        scheme: The only way in which they are sent, and then also to read descriptions; by default the way that the
            description of a thing asks for.
        user: The user's name, for ``basic``.
    """

    host: Annotated[PeerAddress, Field(min_length=1)]
    scheme: LoginScheme | None = None
    user: str = ""

    @field_validator("scheme", mode="before")
    @classmethod
    def _check_scheme(cls, scheme: object) -> object:
        if scheme in _GONE:
            raise ValueError(f"{scheme} is gone; things get their password by basic or bearer")
        return scheme

    @model_validator(mode="after")
    def _check_password(self) -> Self:
        if self.password_file is None and self.password_env is None:
            raise ValueError("give either password_file or password_env")
        if ":" in self.user and self.scheme != "bearer":
            raise ValueError("a user's name contains no colon")
        return self


@dataclass(frozen=True, slots=True)
class HttpLogin:
    """Credentials for one server. They are sent to no other, wherever that one redirects to.

    Attributes:
        origin: The server, as :func:`homebot.gateways.http_address.http_origin` returns it.
        scheme: ``basic`` sends user and password, ``bearer`` the password as a token, ``header`` the password in the
            header field called *user* (an API key).
        user: The user's name; for ``basic`` without a colon.
    """

    origin: str
    scheme: LoginScheme | Literal["header"]
    user: str
    password: SecretStr


@dataclass(frozen=True, slots=True)
class ThingLogin:
    """The credentials for the things of one host.

    Attributes:
        hosts: The names and addresses of the host, in lower case, each with or without a port.
        scheme: The only way in which they are sent; None for any.
    """

    hosts: frozenset[str]
    scheme: LoginScheme | None
    user: str
    password: SecretStr

    def is_for(self, host: str, port: int | None) -> bool:
        """Return whether it is for the server at *host* and *port*."""
        name = host.lower().removesuffix(".")
        shown = f"[{name}]" if ":" in name else name
        return not self.hosts.isdisjoint({name, shown, f"{shown}:{port}"})

    def with_hosts(self, *others: str) -> ThingLogin:
        """Return the same for a host that has these further names or addresses."""
        return ThingLogin(self.hosts | {host.lower() for host in others}, self.scheme, self.user, self.password)


def read_logins(credentials: Sequence[HttpLoginSettings]) -> tuple[ThingLogin, ...]:
    """Return the credentials with their passwords; raise UsageError, with its key, for one that cannot be read."""
    logins = []
    for number, settings in enumerate(credentials):
        password = settings.read_password(f"credentials[{number}].")
        if password is not None:
            hosts = frozenset({settings.host.lower().removesuffix(".")})
            logins.append(ThingLogin(hosts, settings.scheme, settings.user, password))
    return tuple(logins)
