"""The logger of homebot's modules, and the format of its lines.

Lines go where the program has configured structlog, or :func:`homebot.log.configure_logging`, to send them. Without
either, homebot is a guest in another program: warnings and worse go to standard error, the rest only to ``/rosout``.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from typing import Final, TextIO, cast, final

import structlog
from structlog.typing import EventDict, FilteringBoundLogger, Processor, WrappedLogger

from homebot.support.output import CONTROL, CleanText

_COLOURS = {"debug": "2", "warning": "33", "error": "31", "critical": "1;31"}
_MAX_CHARACTERS = 1000
_MAX_LINES = 400
_NOT_FACTS = {"event", "level", "node", "timestamp", "message", "exception"}

_observers: Final[list[Processor]] = []


def get_logger(**facts: object) -> FilteringBoundLogger:
    """Return a logger that adds *facts* to each line, and looks up the output when a line is written."""
    return cast("FilteringBoundLogger", _Logger(facts))


@contextmanager
def observed_lines(observer: Processor) -> Iterator[None]:
    """Pass every line to *observer* during the block; of any level if logging is not configured."""
    if not structlog.is_configured():
        _observers.append(observer)
        try:
            yield
        finally:
            _observers.remove(observer)
        return
    before = structlog.get_config()["processors"]
    structlog.configure(processors=[*before[:-1], observer, before[-1]])
    try:
        yield
    finally:
        structlog.configure(processors=before)


def sentence(event: EventDict) -> str:
    """Return the text of a line: its ``message``, or the event name with its facts."""
    if "message" in event:
        return str(event["message"])
    facts = "  ".join(f"{key}={value}" for key, value in event.items() if key not in _NOT_FACTS)
    return f"{event.get('event', '')}  {facts}" if facts else str(event.get("event", ""))


def with_local_time(_logger: WrappedLogger, _method: str, event: EventDict) -> EventDict:
    """Add a time stamp in ISO 8601: local time with its offset from UTC."""
    event["timestamp"] = datetime.now().astimezone().isoformat(timespec="microseconds")
    return event


@final
class ConsoleRenderer:
    """Renders a line as ``12:30:01  node  words``, in local time, with any traceback indented below it.

    The time is left out without *times*.

    Text from outside cannot break the line, imitate another one or control the terminal.
    """

    def __init__(self, *, colours: bool, times: bool = True) -> None:
        self._colours = colours
        self._times = times

    def __call__(self, _logger: WrappedLogger, _method: str, event: EventDict) -> str:
        """Return the line of *event*."""
        level = str(event.get("level", "info"))
        node = _harmless(str(event.get("node", "")).lstrip("/"))
        mark = "" if level in {"info", "debug"} else f"{level}: "
        time = f"{str(event.get('timestamp', ''))[11:19]}  " if self._times else ""
        text = f"{time}{node:<14} {mark}{_harmless(sentence(event))}"
        if "exception" in event:
            text = f"{text}\n{_harmless_lines(str(event['exception']))}"
        if self._colours and level in _COLOURS:
            return f"\x1b[{_COLOURS[level]}m{text}\x1b[0m"
        return text


class LineWriter:
    """Writes lines; a closed reader is not an error.

    Args:
        out: The stream; None for the current standard error.
    """

    def __init__(self, out: TextIO | None = None) -> None:
        self._out = out

    def msg(self, line: str) -> None:
        """Write *line*."""
        out = self._out or sys.stderr
        if isinstance(out, CleanText):
            out = out.raw  # lines are sanitized where their parts are known, and may have colours
        with suppress(OSError, ValueError):  # a broken pipe or a closed stream: there is nowhere to report it
            out.write(f"{line}\n")
            out.flush()

    log = debug = info = warning = error = critical = msg


def _shown_to_observers(logger: WrappedLogger, method: str, event: EventDict) -> EventDict:
    for observer in tuple(_observers):
        observer(logger, method, event)
    return event


def _only_warnings(_logger: WrappedLogger, _method: str, event: EventDict) -> EventDict:
    if event["level"] in {"debug", "info"}:
        raise structlog.DropEvent
    return event


_DEFAULT_PROCESSORS: Final[tuple[Processor, ...]] = (
    structlog.processors.add_log_level,
    _shown_to_observers,
    _only_warnings,
    with_local_time,
    structlog.processors.format_exc_info,
    ConsoleRenderer(colours=False),
)
_DEFAULT_LOGGER: Final = structlog.wrap_logger(
    LineWriter(), processors=_DEFAULT_PROCESSORS, wrapper_class=structlog.make_filtering_bound_logger(0)
)


class _Logger:
    """A proxy for structlog's logger, or that of a guest, chosen at each call."""

    def __init__(self, facts: dict[str, object]) -> None:
        self._configured = structlog.get_logger(**facts)
        self._default = _DEFAULT_LOGGER.bind(**facts)

    def __getattr__(self, name: str) -> object:
        if name.startswith("__"):  # copying and pickling ask before attributes exist
            raise AttributeError(name)
        return getattr(self._configured if structlog.is_configured() else self._default, name)


def _harmless_lines(text: str) -> str:
    """Return the last lines of a traceback, sanitized and indented."""
    lines = text.split("\n")
    if len(lines) > _MAX_LINES:
        left_out = len(lines) - _MAX_LINES
        lines = [*lines[: _MAX_LINES // 4], f"  … ({left_out:,} lines)", *lines[left_out + _MAX_LINES // 4 :]]
    return "\n".join(f"  {_harmless(line)}" for line in lines)


def _harmless(text: str) -> str:
    shown = text if len(text) <= _MAX_CHARACTERS else f"{text[:_MAX_CHARACTERS]}… ({len(text):,} characters)"
    return CONTROL.sub(lambda found: ascii(found[0])[1:-1], shown)
