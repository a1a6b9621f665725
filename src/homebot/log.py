"""Logging: one place that decides how lines look, and a limit for lines that outsiders can cause.

A line is an event name (a dotted constant such as ``discovery.appeared``) with facts as keys. The key ``message`` says
the same in plain words for people: it is what the terminal shows.
"""

from __future__ import annotations

import logging
import re
import sys
import time
from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import Literal, TextIO, TypeAlias, cast, final

import structlog
from structlog.typing import EventDict, Processor, WrappedLogger

from homebot.clock import Clock
from homebot.errors import UsageError
from homebot.output import CONTROL, CleanText, QueuedText

__all__ = ["LogFormat", "LogLimit", "configure_logging", "sentence"]

LogFormat: TypeAlias = Literal["console", "json"]

LIBRARY_LINE = "log.library"
LINES_LOST = "log.lost"

_MAX_KEYS = 1000
_LEVELS = {"debug": 10, "info": 20, "warning": 30, "error": 40, "critical": 50}
_COLOURS = {"debug": "2", "warning": "33", "error": "31", "critical": "1;31"}
_SECRETS = (
    re.compile(r"(://[^\s/@:]*:)[^\s/]+(?=@)"),
    re.compile(
        r"""\b( bearer\s+
             | authorization\W{1,4}(?:\w+\s+)?
             | [\w-]*(?:password|passwd|passphrase|secret|token|api_?key)[\w-]*["']?\s*[=:]\s*["']?
             )[^\s"'&,;)}\]]+""",
        re.IGNORECASE | re.VERBOSE,
    ),
)
_LONGEST = 1000
_MOST_LINES = 400
_NOT_FACTS = {"event", "level", "node", "timestamp", "message", "exception"}


def configure_logging(
    log_format: LogFormat = "console",
    *,
    level: str = "info",
    stream: TextIO | None = None,
    processors: Sequence[Processor] = (),
) -> None:
    """Send every log line of the process to *stream*, by default standard error.

    What libraries log with the standard library's ``logging``, at warning or above, and Python's own warnings come the
    same way: limited, and with what looks like a secret taken out.

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
    if isinstance(out, CleanText):
        out = out.raw  # a line is made harmless where its parts are known, and may have colours
    renderer: Processor = structlog.processors.JSONRenderer() if log_format == "json" else _Console(out.isatty())
    if isinstance(out, QueuedText):
        out.queue.loss_text = partial(_loss_line, renderer)
    _take_in_stdlib_lines()
    structlog.configure(
        processors=[
            structlog.processors.add_log_level,
            _with_local_time,
            structlog.processors.format_exc_info,
            _without_secrets,
            *processors,
            renderer,
        ],
        wrapper_class=structlog.make_filtering_bound_logger(_LEVELS[level]),
        logger_factory=lambda *_: _Writer(out),
        cache_logger_on_first_use=False,
    )


def _loss_line(renderer: Processor, lines: int) -> str:
    """Return the line of the log that stands for *lines* which nobody read in time."""
    event: EventDict = {
        "event": LINES_LOST,
        "level": "warning",
        "node": "/homebot",
        "lost": lines,
        "message": f"{lines:,} lines of the log were lost here, as nobody read them in time",
    }
    line = renderer(None, "warning", _with_local_time(None, "warning", event))
    return f"{cast('str', line)}\n"


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


class _Writer:
    """Writes lines. Whoever read them may have gone; the house does not go down with them."""

    def __init__(self, out: TextIO) -> None:
        self._out = out

    def msg(self, line: str) -> None:
        with suppress(OSError, ValueError):  # a broken pipe, or a stream that was closed: nowhere left to say it
            self._out.write(f"{line}\n")
            self._out.flush()

    log = debug = info = warning = error = critical = msg


class _StdlibLines(logging.Handler):
    """Brings a line of the standard library's ``logging`` into our log."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._limit = LogLimit(_SinceStart())

    def emit(self, record: logging.LogRecord) -> None:
        held_back = self._limit.allows(f"{record.name} {record.msg}")
        if held_back is None:
            return
        facts = {"exc_info": record.exc_info} if record.exc_info else {}
        more = f" (and {held_back} more like this)" if held_back else ""
        structlog.get_logger(node=record.name).log(
            min(record.levelno, logging.CRITICAL) // 10 * 10,
            LIBRARY_LINE,
            message=f"{_text(record)}{more}",
            held_back=held_back,
            **facts,
        )


def _text(record: logging.LogRecord) -> str:
    try:
        return record.getMessage()
    except (KeyError, TypeError, ValueError):  # the library's own slip must not become ours
        return str(record.msg)


class _SinceStart:
    """The clock of lines that come from any thread, with an event loop or without."""

    def monotonic(self) -> float:
        return time.monotonic()

    def now(self) -> float:
        return time.time()


def _take_in_stdlib_lines() -> None:
    root = logging.getLogger()
    for handler in root.handlers:
        if isinstance(handler, _StdlibLines):
            root.removeHandler(handler)
    root.addHandler(_StdlibLines())
    logging.captureWarnings(capture=True)


def _without_secrets(_logger: WrappedLogger, _method: str, event: EventDict) -> EventDict:
    """Take secrets out of what libraries say; our own lines never hold any."""
    if event.get("event") == LIBRARY_LINE:
        for key in ("message", "exception"):
            if key in event:
                for secret in _SECRETS:
                    event[key] = secret.sub(r"\1***", str(event[key]))
    return event


def _with_local_time(_logger: WrappedLogger, _method: str, event: EventDict) -> EventDict:
    """Stamp a line in ISO 8601, in the computer's own time, with how far that is from UTC."""
    event["timestamp"] = datetime.now().astimezone().isoformat(timespec="microseconds")
    return event


class _Console:
    """Renders a line as ``12:30:01  node  words``, in local time, and a traceback below it, set in.

    What outsiders wrote cannot break the line, look like another, or steer the terminal.
    """

    def __init__(self, colours: bool) -> None:  # noqa: FBT001  # private, one caller
        self._colours = colours

    def __call__(self, _logger: WrappedLogger, _method: str, event: EventDict) -> str:
        level = str(event.get("level", "info"))
        node = _harmless(str(event.get("node", "")).lstrip("/"))
        mark = "" if level in {"info", "debug"} else f"{level}: "
        text = f"{str(event.get('timestamp', ''))[11:19]}  {node:<14} {mark}{_harmless(sentence(event))}"
        if "exception" in event:
            text = f"{text}\n{_harmless_lines(str(event['exception']))}"
        if self._colours and level in _COLOURS:
            return f"\x1b[{_COLOURS[level]}m{text}\x1b[0m"
        return text


def _harmless_lines(text: str) -> str:
    """Return a traceback, of which the end says most, as lines that are each harmless and set in."""
    lines = text.split("\n")
    if len(lines) > _MOST_LINES:
        left_out = len(lines) - _MOST_LINES
        lines = [*lines[: _MOST_LINES // 4], f"  … ({left_out:,} lines)", *lines[left_out + _MOST_LINES // 4 :]]
    return "\n".join(f"  {_harmless(line)}" for line in lines)


def _harmless(text: str) -> str:
    shown = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}… ({len(text):,} characters)"
    return CONTROL.sub(lambda found: ascii(found[0])[1:-1], shown)
