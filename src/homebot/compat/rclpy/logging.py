"""The logger of a node, with rclpy's names."""

from __future__ import annotations

from functools import partialmethod

from homebot.support.logger import get_logger as logger_of

__all__ = ["Logger", "get_logger"]

_LINE = "rclpy.line"


class Logger:
    """Writes to the log, and to ``/rosout``."""

    def __init__(self, name: str) -> None:
        self._log = logger_of(node=name)

    def log(self, message: str, severity: str) -> None:
        """Write *message*; *severity* is ``debug``, ``info``, ``warning``, ``error`` or ``critical``."""
        getattr(self._log, severity)(_LINE, message=str(message))

    debug = partialmethod(log, severity="debug")
    info = partialmethod(log, severity="info")
    warn = warning = partialmethod(log, severity="warning")
    error = partialmethod(log, severity="error")
    fatal = partialmethod(log, severity="critical")


def get_logger(name: str) -> Logger:
    """Return the logger of *name*."""
    return Logger(name)
