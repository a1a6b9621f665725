"""Credentials for things that are used over HTTP, as configurations name them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, Self

from pydantic import Field, SecretStr, model_validator

from homebot.gateways.password_settings import PasswordSettings

__all__ = ["HttpLoginSettings", "ThingLogin", "read_logins"]


class HttpLoginSettings(PasswordSettings):
    """The credentials for the things of one host; the password may be a token or a key.

    Attributes:
        host: The name or address of the host, with a port where it is for that alone: ``lamp.local``,
            ``192.168.1.20:8443``. They are sent to no other.
        scheme: The only way in which they are sent: ``basic``, ``digest``, ``bearer`` or ``apikey``, and then also to
            read descriptions; by default the way that the description of a thing asks for.
        user: The user's name, for ``basic`` and ``digest``.
    """

    host: Annotated[str, Field(min_length=1)]
    scheme: Literal["basic", "digest", "bearer", "apikey"] | None = None
    user: str = ""

    @model_validator(mode="after")
    def _check_password(self) -> Self:
        if self.password_file is None and self.password_env is None:
            raise ValueError("give either password_file or password_env")
        if ":" in self.user and self.scheme in {None, "basic"}:
            raise ValueError("a user's name contains no colon")
        return self


@dataclass(frozen=True, slots=True)
class ThingLogin:
    """The credentials for the things of one host.

    Attributes:
        hosts: The names and addresses of the host, in lower case, each with or without a port.
        scheme: The only way in which they are sent; empty for any.
    """

    hosts: frozenset[str]
    scheme: str
    user: str
    password: SecretStr

    def is_for(self, host: str, port: int | None) -> bool:
        """Return whether it is for the server at *host* and *port*."""
        name = host.lower().removesuffix(".")
        shown = f"[{name}]" if ":" in name else name
        return not self.hosts.isdisjoint({name, shown, f"{shown}:{port}"})

    def with_hosts(self, *others: str) -> ThingLogin:
        """Return the same for a host that has these further names or addresses."""
        return ThingLogin(self.hosts | {one.lower() for one in others}, self.scheme, self.user, self.password)


def read_logins(credentials: Sequence[HttpLoginSettings]) -> tuple[ThingLogin, ...]:
    """Return the credentials with their passwords; raise UsageError, with its key, for one that cannot be read."""
    found = []
    for number, one in enumerate(credentials):
        password = one.read_password(f"credentials[{number}].")
        if password is not None:
            hosts = frozenset({one.host.lower().removesuffix(".")})
            found.append(ThingLogin(hosts, one.scheme or "", one.user, password))
    return tuple(found)
