"""The problems of listening on an address, in words."""

from __future__ import annotations

import errno

from homebot.bridges.access_settings import AccessSettings

__all__ = ["listening_problem"]


def listening_problem(settings: AccessSettings, error: OSError) -> str:
    """Return why the address of *settings* cannot be listened on, and what to do."""
    where = f"{settings.host}:{settings.port}"
    if error.errno == errno.EADDRINUSE:
        return f"{where} is in use, maybe by another homebot; stop that one, or choose another port"
    if error.errno == errno.EACCES:
        return f"{where} is reserved by the system; choose a port from 1024 on"
    return f"cannot listen on {where}: {error.strerror or error}"
