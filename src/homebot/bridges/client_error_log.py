"""The rate-limited log of mistakes of a bridge's clients."""

from __future__ import annotations

from typing import Literal

from homebot.graph import Node
from homebot.log import LogLimit, more_like_this

__all__ = ["ClientErrorLog", "short_text"]

_LINES = 20  # of one kind in ten seconds
_LONGEST = 300  # a client may send a text of a megabyte


class ClientErrorLog:
    """Logs mistakes of clients.

    Args:
        node: Name in the log.
    """

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

        Returns the number of lines held back before it; None where it is held back itself.

        Args:
            kind: Group for the rate limit, such as one client's mistakes.
            event: The constant name.
            message: The same in plain words; cut, as are the texts among the facts, to 300 characters.
            level: How bad it is.
            error: Shown with its traceback.
            facts: Further facts.
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


def short_text(text: str, longest: int = _LONGEST) -> str:
    """Return *text*, cut to the *longest* length."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"
