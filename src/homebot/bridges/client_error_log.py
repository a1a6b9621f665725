"""The rate-limited log of the mistakes of a bridge's clients, including lines of its server's library."""

import logging
from collections.abc import Callable
from typing import Literal, final

from homebot.errors import HomebotError
from homebot.graph import Node
from homebot.log import LogLimit, more_like_this

_LINES = 20  # per kind in ten seconds
_MAX_CHARACTERS = 300  # a client may send a text of a megabyte


class ClientErrorLog:
    """Logs the mistakes of clients."""

    def __init__(self, node: Node) -> None:
        self._log = node.log
        self._limit = LogLimit(node.graph.clock, burst=_LINES)

    def log(
        self,
        kind: str,
        event: str,
        message: str,
        *,
        level: Literal["warning", "error"] = "warning",
        error: BaseException | None = None,
        **facts: str | int,
    ) -> int | None:
        """Log one line, unless there were 20 of its *kind* in the last ten seconds.

        Returns the number of lines suppressed before it; None if it is suppressed itself.

        Args:
            kind: Group for the rate limit, such as one client's mistakes.
            message: The message, cut to 300 characters like the texts among the facts.
        """
        if (held_back := self._limit.allows(kind)) is None:
            return None
        known: dict[str, object] = {
            key: short_text(fact) if isinstance(fact, str) else fact for key, fact in facts.items()
        }
        if error is not None:
            known["exc_info"] = error
        write = self._log.error if level == "error" else self._log.warning
        write(event, message=f"{short_text(message)}{more_like_this(held_back)}", held_back=held_back, **known)
        return held_back


def short_text(text: str, longest: int = _MAX_CHARACTERS) -> str:
    """Return *text*, cut to the *longest* length."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


@final
class LibraryLog(logging.Handler):
    """Handler that writes the lines of a library, which serves clients, to the limited log.

    Args:
        server: The prefix of its events, such as ``door``.
        mistake: Describes the mistake of a client that a line reports.
        crash_in: Describes the crash that a line reports instead; empty for none.
    """

    def __init__(
        self, error_log: ClientErrorLog, server: str, mistake: str, crash_in: Callable[[logging.LogRecord], str]
    ) -> None:
        super().__init__()
        self._error_log = error_log
        self._server = server
        self._mistake = mistake
        self._crash_in = crash_in

    def emit(self, record: logging.LogRecord) -> None:
        """Write *record*."""
        kind, error = str(record.msg), record.exc_info[1] if record.exc_info else None
        if crash := self._crash_in(record):
            self._error_log.log(kind, f"{self._server}.request_crashed", crash, level="error", error=error)
        else:
            # The texts of libraries quote the request, perhaps with a token.
            problem = str(error) if isinstance(error, HomebotError) else type(error).__name__ if error else kind
            self._error_log.log(kind, f"{self._server}.invalid_http", f"{self._mistake}: {problem}", problem=problem)
