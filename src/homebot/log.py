"""Logging: one place that decides how lines look, and a limit for lines that outsiders can cause.

A line is an event name (a dotted constant such as ``discovery.appeared``) with facts as keys. The key ``message`` says
the same in plain words for people: it is what the terminal shows.
"""

from __future__ import annotations

import re
import sys
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TextIO, TypeAlias, final

import structlog
from structlog.typing import EventDict, Processor, WrappedLogger

from homebot.clock import Clock
from homebot.errors import UsageError

__all__ = ["LogFormat", "LogLimit", "configure_logging", "sentence"]

LogFormat: TypeAlias = Literal["console", "json"]

_MAX_KEYS = 1000
_LEVELS = {"debug": 10, "info": 20, "warning": 30, "error": 40, "critical": 50}
_COLOURS = {"debug": "2", "warning": "33", "error": "31", "critical": "1;31"}
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]")
_NOT_FACTS = {"event", "level", "node", "timestamp", "message", "exception"}


def configure_logging(
    log_format: LogFormat = "console",
    *,
    level: str = "info",
    stream: TextIO | None = None,
    processors: Sequence[Processor] = (),
) -> None:
    """Send every log line of the process to *stream*, by default standard error.

    Args:
        log_format: ``console`` for people, ``json`` for programs: one object a line.
        level: Least level shown: debug, info, warning, error or critical.
        stream: Where to; colours are used only on a terminal.
        processors: Further structlog processors that see each line before it is written.

    Raises:
        UsageError: *level* is no level.
    """
    if level not in _LEVELS:
        raise UsageError(f"no log level {level!r}; there are {', '.join(_LEVELS)}")
    out = stream or sys.stderr
    renderer: Processor = structlog.processors.JSONRenderer() if log_format == "json" else _Console(out.isatty())
    structlog.configure(
        processors=[
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso", utc=True),
            structlog.processors.format_exc_info,
            *processors,
            renderer,
        ],
        wrapper_class=structlog.make_filtering_bound_logger(_LEVELS[level]),
        logger_factory=structlog.PrintLoggerFactory(out),
        cache_logger_on_first_use=False,
    )


def sentence(event: EventDict) -> str:
    """Return the line's plain words: its ``message``, or the event name with its facts."""
    if "message" in event:
        return str(event["message"])
    facts = "  ".join(f"{key}={value}" for key, value in event.items() if key not in _NOT_FACTS)
    return f"{event.get('event', '')}  {facts}" if facts else str(event.get("event", ""))


@final
class LogLimit:
    """Lets a few lines of a kind through per interval and counts the others, so that no outsider can flood the log.

    Args:
        clock: The time to go by.
        interval: Seconds after which a kind may be heard again.
        burst: Lines of one kind let through per interval.
    """

    def __init__(self, clock: Clock, interval: float = 10.0, burst: int = 1) -> None:
        self._clock = clock
        self._interval = interval
        self._burst = burst
        self._kinds: OrderedDict[str, _Interval] = OrderedDict()

    def allows(self, kind: str) -> int | None:
        """Return how many lines of *kind* were held back since the last one, or None when this one must be too.

        The 1,000 kinds used last are remembered.
        """
        now = self._clock.monotonic()
        current = self._kinds.get(kind)
        if current is None or now - current.start >= self._interval:
            current = self._kinds[kind] = _Interval(now, held_back=current.held_back if current else 0)
            if len(self._kinds) > _MAX_KEYS:
                self._kinds.popitem(last=False)
        self._kinds.move_to_end(kind)
        if current.passed >= self._burst:
            current.held_back += 1
            return None
        current.passed += 1
        held_back, current.held_back = current.held_back, 0
        return held_back


@dataclass(slots=True)
class _Interval:
    start: float
    passed: int = 0
    held_back: int = 0


class _Console:
    """Renders a line as ``12:30:01  node  words``; what outsiders wrote cannot break the line or steer the terminal."""

    def __init__(self, colours: bool) -> None:  # noqa: FBT001  # private, one caller
        self._colours = colours

    def __call__(self, _logger: WrappedLogger, _method: str, event: EventDict) -> str:
        level = str(event.get("level", "info"))
        node = str(event.get("node", "")).lstrip("/")
        mark = "" if level in {"info", "debug"} else f"{level}: "
        text = f"{str(event.get('timestamp', ''))[11:19]}  {node:<14} {mark}{_harmless(sentence(event))}"
        if "exception" in event:
            text = f"{text}\n{event['exception']}"
        if self._colours and level in _COLOURS:
            return f"\x1b[{_COLOURS[level]}m{text}\x1b[0m"
        return text


def _harmless(text: str) -> str:
    return _CONTROL.sub(lambda found: repr(found[0])[1:-1], text)
