"""The log of a test, where nobody has chosen another."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import structlog

__all__ = ["plain_logs"]


@contextmanager
def plain_logs() -> Iterator[None]:
    """Write tracebacks as Python does during the block, unless the program has set up structlog itself.

    Where ``rich`` is installed, structlog's default draws them with the values of all variables: hundreds of lines and
    a tenth of a second for an app that crashed, and whatever is secret among the values.
    """
    if structlog.is_configured():
        yield
        return
    writer = structlog.dev.ConsoleRenderer(colors=False, exception_formatter=structlog.dev.plain_traceback)
    structlog.configure(processors=[*structlog.get_config()["processors"][:-1], writer])
    try:
        yield
    finally:
        if structlog.get_config()["processors"][-1] is writer:  # else the program has set it up meanwhile
            structlog.reset_defaults()
