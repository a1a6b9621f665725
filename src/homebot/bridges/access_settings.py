"""Settings of a server for other programs: where it listens, and whom it lets in."""

import errno
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, SecretStr

__all__ = ["AccessSettings", "Count"]

Count = Annotated[int, Field(ge=1)]


class AccessSettings(BaseModel):
    """The settings that all servers for other programs have.

    Attributes:
        host: Name or address to listen on. Any other than a loopback one needs a token.
        port: TCP port; 0 takes a free one.
        token: What a client must show, as ``Authorization: Bearer TOKEN`` or, for browsers, as ``?token=TOKEN``.
        allowed_origins: Web pages that may connect besides those of the same host and of loopback, for example
            ``https://panel.example.org``; ``null`` is a page opened from a file.
        max_clients: Clients at a time; one more is turned away.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    host: str = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535)] = 0
    token: Annotated[SecretStr, Field(min_length=1)] | None = None
    allowed_origins: tuple[str, ...] = ()
    max_clients: Count = 64

    def listening_problem(self, error: OSError, key: str) -> str:
        """Return why the address cannot be listened on, and what to do: another port is chosen by *key*."""
        where = f"{self.host}:{self.port}"
        if error.errno == errno.EADDRINUSE:
            return f"{where} is in use, maybe by another homebot; stop that one, or choose another port ({key})"
        if error.errno == errno.EACCES:
            return f"{where} is reserved by the system; choose a port from 1024 on ({key})"
        return f"cannot listen on {where}: {error.strerror or error}"
