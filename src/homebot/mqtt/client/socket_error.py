"""Text for the failures of a socket; it does not name the broker, because the caller does."""

from __future__ import annotations

import errno
import os
import socket
import ssl
from typing import Final

from homebot.errors import LinkError, RefusedError

__all__ = ["socket_error"]

_WORDS: Final = {
    errno.ECONNREFUSED: "nobody listens there (connection refused)",
    errno.ENETUNREACH: "no route to that network",
    errno.EHOSTUNREACH: "no route to that host",
    errno.ETIMEDOUT: "no answer",
    errno.ECONNRESET: "the broker cut the connection",
    errno.EPIPE: "the broker closed the connection",
}
_UNKNOWN_NAME: Final = {getattr(socket, name, socket.EAI_NONAME) for name in ("EAI_NONAME", "EAI_NODATA")}

_NO_TLS: Final = "what answers there speaks no TLS; is it the port for mqtt://?"
_TLS_WORDS: Final = (
    ("CERTIFICATE_REQUIRED", "client certificate required; set cert_file and key_file"),
    ("HANDSHAKE_FAILURE", "hand-shake failure; does the broker want a client certificate (cert_file)?"),
    ("UNKNOWN_CA", "the broker does not know the authority of the client certificate (cert_file)"),
    ("WRONG_VERSION_NUMBER", _NO_TLS),
    ("RECORD_LAYER_FAILURE", _NO_TLS),  # the same since OpenSSL 3.2
)


def socket_error(error: OSError) -> LinkError | RefusedError:
    """Return the error for a failure of a socket: a refused TLS hand-shake is a refusal, all else is the link."""
    if isinstance(error, ssl.SSLEOFError | ssl.SSLZeroReturnError):
        return LinkError("the broker closed the connection")
    if isinstance(error, ssl.SSLError):
        reason = error.reason or "hand-shake failed"
        plain = reason.lower().replace("_", " ")
        return RefusedError("TLS", next((words for part, words in _TLS_WORDS if part in reason), plain))
    return LinkError(_words(error))


def _words(error: OSError) -> str:
    if isinstance(error, socket.gaierror):
        known = error.errno not in _UNKNOWN_NAME
        return f"the name cannot be looked up now ({error.strerror})" if known else "the name is not known"
    if error.errno in _WORDS:
        return _WORDS[error.errno]
    # asyncio puts the address into the text, as a tuple of Python.
    return os.strerror(error.errno) if error.errno else str(error)
