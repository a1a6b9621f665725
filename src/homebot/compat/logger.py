"""rclpy's loggers."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from enum import IntEnum
from functools import partial
from inspect import currentframe
from typing import Any, Final

from homebot.support.logger import get_logger as logger_of

LoggingSeverity = IntEnum(
    "LoggingSeverity", {"UNSET": 0, "DEBUG": 10, "INFO": 20, "WARN": 30, "ERROR": 40, "FATAL": 50}
)
_LEVELS: Final = {"warning": "warn"}


class get_logger:  # noqa: N801 - rclpy's name
    """The logger *name*, which also writes to ``/rosout``: ``info``, ``warn``, ``error`` and so on.

    With ``once``, ``skip_first`` or ``throttle_duration_sec`` a line of the program is logged only once, except the
    first time, or once in that time.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self._log = logger_of(node=name)
        self._least = 0
        self._next: dict[tuple[str, int], float] = {}

    def __getattr__(self, level: str) -> Callable[..., None]:
        return partial(self._write, _LEVELS.get(level, level))

    def get_child(self, name: str) -> get_logger:
        """Return a child logger."""
        return get_logger(f"{self.name}.{name}")

    def set_level(self, level: int) -> None:
        """Drop lines below *level*; homebot itself drops debug lines."""
        self._least = level

    def _write(
        self,
        level: str,
        message: object,
        *,
        once: bool = False,
        skip_first: bool = False,
        throttle_duration_sec: float = 0.0,
    ) -> None:
        frame: Any = currentframe()
        line = (frame.f_back.f_code.co_filename, frame.f_back.f_lineno)
        is_first = line not in self._next
        if LoggingSeverity[level.upper()] >= self._least and time.monotonic() >= self._next.setdefault(line, 0.0):
            if is_first and skip_first:
                return
            if pause := math.inf if once else throttle_duration_sec:
                self._next[line] = time.monotonic() + pause
            getattr(self._log, "critical" if level == "fatal" else level)(str(message))
