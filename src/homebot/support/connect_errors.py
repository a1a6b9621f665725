"""Reasons for failed connections, in words for people."""

import errno
import os
import socket
from typing import Final

_KNOWN: Final = {
    errno.ECONNREFUSED: "nothing is listening there (connection refused): start it, or correct the address",
    errno.ENETUNREACH: "no route to that network",
    errno.EHOSTUNREACH: "no route to that host",
    errno.ETIMEDOUT: "no answer",
}
_UNKNOWN_NAME: Final = {getattr(socket, name, socket.EAI_NONAME) for name in ("EAI_NONAME", "EAI_NODATA")}


def connect_problem(error: OSError) -> str:
    """Return the reason of *error*, without the address that asyncio includes as a Python tuple."""
    if isinstance(error, socket.gaierror):
        known = error.errno not in _UNKNOWN_NAME
        return (
            f"the host name cannot be looked up now ({error.strerror})"
            if known
            else "the host name is unknown: correct the address"
        )
    if error.errno in _KNOWN:
        return _KNOWN[error.errno]
    return os.strerror(error.errno) if error.errno else str(error) or type(error).__name__
