"""Logging: the configuration of the output, and a rate limit for lines that outsiders can cause.

A line is an event name (a dotted constant such as ``discovery.appeared``) with facts as keys. The key ``message`` has
the same in plain words, and is shown in terminals.
"""

import logging
import re
import sys
import time
from collections.abc import Sequence
from functools import partial
from typing import Literal, TextIO, TypeAlias, cast, final

import structlog
from structlog.typing import EventDict, Processor, WrappedLogger

from homebot.clock import Clock
from homebot.errors import UsageError
from homebot.support.limits import Limiter
from homebot.support.logger import ConsoleRenderer, LineWriter, with_local_time
from homebot.support.logger import sentence as sentence
from homebot.support.output import CleanText, QueuedText, is_journal, wants_colour

LogFormat: TypeAlias = Literal["console", "json"]

LIBRARY_LINE = "log.library"
LINES_LOST = "log.lost"

_MAX_KEYS = 1000
_LEVELS = {"debug": 10, "info": 20, "warning": 30, "error": 40, "critical": 50}
_SECRETS = (
    re.compile(r"(://[^\s/@:]*:)[^\s/]+(?=@)"),
    re.compile(
        r"""( \bbearer\s+
             | \bauthorization\W{1,4}(?:\w+\s+)?
             | (?:password|passwd|passphrase|secret|token|api_?key)[\w-]{0,40}["']?\s*[=:]\s*["']?
             )[^\s"'&,;)}\]]+""",
        re.IGNORECASE | re.VERBOSE,
    ),
)


def configure_logging(
    log_format: LogFormat = "console",
    *,
    level: str = "info",
    stream: TextIO | None = None,
    processors: Sequence[Processor] = (),
) -> None:
    """Send every log line of the process to *stream*, by default standard error.

    This includes lines of libraries through the standard library's ``logging`` at warning or above, and Python's
    warnings: at a limited rate, and with secrets masked.

    Args:
        log_format: ``console`` for people, ``json`` for programs: one object per line.
        level: The lowest level shown: debug, info, warning, error or critical.
        stream: The stream to write to; colours are used only on a terminal.
        processors: Further structlog processors that see each line before it is written.

    Raises:
        UsageError: *level* is not a level.
    """
    if level not in _LEVELS:
        raise UsageError(f"{level!r} is not a log level; choose one of {', '.join(_LEVELS)}")
    out = _raw(stream or sys.stderr)
    renderer = _renderer(log_format, out)
    root = logging.getLogger()
    for handler in root.handlers:
        if isinstance(handler, _StdlibLines):
            root.removeHandler(handler)
    root.addHandler(_StdlibLines())
    logging.captureWarnings(capture=True)
    writer = LineWriter(out)
    structlog.configure(
        processors=[
            structlog.processors.add_log_level,
            with_local_time,
            structlog.processors.format_exc_info,
            _without_secrets,
            *processors,
            renderer,
        ],
        wrapper_class=structlog.make_filtering_bound_logger(_LEVELS[level]),
        logger_factory=lambda *_: writer,
        cache_logger_on_first_use=False,
    )


def _raw(stream: TextIO) -> TextIO:
    """Return the stream to write to, which may wrap a queue."""
    return stream.raw if isinstance(stream, CleanText) else stream


def _renderer(log_format: LogFormat, out: TextIO) -> Processor:
    """Return the renderer of lines for *out*; the queue of *out* also uses it to report lost lines."""
    renderer: Processor = (
        structlog.processors.JSONRenderer()
        if log_format == "json"
        else ConsoleRenderer(colours=wants_colour(out), times=not is_journal(out))
    )
    if isinstance(out, QueuedText):
        out.queue.loss_text = partial(_loss_line, renderer)
    return renderer


def _loss_line(renderer: Processor, lines: int) -> str:
    """Return the log line that reports *lines* dropped lines."""
    event: EventDict = {
        "event": LINES_LOST,
        "level": "warning",
        "node": "/homebot",
        "lost": lines,
        "message": f"{lines:,} lines of the log were lost here, because they were not read in time",
    }
    line = renderer(None, "warning", with_local_time(None, "warning", event))
    return f"{cast('str', line)}\n"


@final
class LogLimit:
    """Allows a few lines of a kind per interval and counts the others, so that no outsider can flood the log.

    Args:
        interval: Seconds after which a kind is allowed again.
        burst: Lines of one kind per interval.
    """

    def __init__(self, clock: Clock, interval: float = 10.0, burst: int = 1) -> None:
        self._clock = clock
        self._burst = burst
        self._kinds = Limiter[str, None](interval, _MAX_KEYS)

    def allows(self, kind: str) -> int | None:
        """Return how many lines of *kind* were held back since the last one, or None to hold back this one too.

        The 1,000 most recently used kinds are remembered.
        """
        current = self._kinds.of(kind, self._clock.monotonic())
        if current.passed >= self._burst:
            current.held_back += 1
            return None
        current.passed += 1
        held_back, current.held_back = current.held_back, 0
        return held_back


def more_like_this(held_back: int) -> str:
    """Return the suffix of a line that counts those that a :class:`LogLimit` held back; empty if there are none."""
    return f" (and {held_back} more like this)" if held_back else ""


FORGOTTEN_AWAIT = "python.forgotten_await"

_WARNINGS = "py.warnings"
_FORGOTTEN = re.compile(r"coroutine '([^']+)' was never awaited")


class _StdlibLines(logging.Handler):
    """Forwards records of the standard library's ``logging`` to our log."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._limit = LogLimit(_SinceStart())

    def emit(self, record: logging.LogRecord) -> None:
        held_back = self._limit.allows(f"{record.name} {record.msg}")
        if held_back is None:
            return
        if record.name == _WARNINGS and (forgotten := _FORGOTTEN.search(text := _text(record))) is not None:
            place = text.partition(": RuntimeWarning")[0]
            called = forgotten[1].removesuffix(".__aenter__")  # for an async context manager
            word = "await" if called == forgotten[1] else "`async with`"
            message = f"{called}() was called without {word}, so it did nothing: {place}"
            structlog.get_logger(node=record.name).error(FORGOTTEN_AWAIT, message=message, held_back=held_back)
            return
        facts = {"exc_info": record.exc_info} if record.exc_info else {}
        structlog.get_logger(node=record.name).log(
            min(record.levelno, logging.CRITICAL) // 10 * 10,
            LIBRARY_LINE,
            message=f"{_text(record)}{more_like_this(held_back)}",
            held_back=held_back,
            **facts,
        )


def _text(record: logging.LogRecord) -> str:
    try:
        return record.getMessage()
    except (KeyError, TypeError, ValueError):  # a library's mistake must not become ours
        return str(record.msg)


class _SinceStart:
    """Clock for lines from any thread, with or without an event loop."""

    def monotonic(self) -> float:
        return time.monotonic()

    def now(self) -> float:
        return time.time()


def _without_secrets(_logger: WrappedLogger, _method: str, event: EventDict) -> EventDict:
    """Mask secrets in log lines of libraries; homebot's own lines contain none."""
    if event.get("event") == LIBRARY_LINE:
        for key in ("message", "exception"):
            if key in event:
                for secret in _SECRETS:
                    event[key] = secret.sub(r"\1***", str(event[key]))
    return event
