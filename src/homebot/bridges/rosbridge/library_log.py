"""The log of the WebSocket library."""

from __future__ import annotations

import logging
from typing import Final

from homebot.bridges.client_error_log import ClientErrorLog

__all__ = ["LibraryLog"]

_CRASHES: Final = {
    "connection handler failed": "a client's session crashed",
    "process_request failed": "the answer to a client's request crashed",
}


class LibraryLog(logging.Handler):
    """Handler that writes the lines of the WebSocket library to the limited log."""

    def __init__(self, error_log: ClientErrorLog) -> None:
        super().__init__()
        self._error_log = error_log

    def emit(self, record: logging.LogRecord) -> None:
        """Write *record*."""
        error = record.exc_info[1] if record.exc_info else None
        if record.msg in _CRASHES:
            self._error_log.log(record.msg, "door.session_crashed", _CRASHES[record.msg], level="error", error=error)
        else:
            problem = str(error or record.msg)
            message = f"a client of the rosbridge server sent what is no WebSocket and no HTTP: {problem}"
            self._error_log.log(record.msg, "door.handshake_failed", message, problem=problem)
