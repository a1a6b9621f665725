"""Counts the Python calls inside homebot, and the files they are in."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from types import FrameType, TracebackType
from typing import Self

import homebot

__all__ = ["CallCount"]

_SOURCE = f"{Path(homebot.__file__).parent}/"
_BROKER = f"{_SOURCE}mqtt/broker/"
_OUTSIDE = (f"{_SOURCE}mqtt/client/memory_transport.py", f"{_SOURCE}testing/", f"{_SOURCE}support/virtual_time.py")


class CallCount:
    """Counts in the thread that enters it, until it is left.

    A coroutine counts as often as it is resumed, and so does a generator. The broker in memory and the link to it stand
    for the network: what they do, and whatever the broker calls, does not count. Nor does the virtual clock.

    Attributes:
        files: How many calls were in each file, relative to the package; in the order of the first call.
    """

    def __init__(self) -> None:
        self.files: Counter[str] = Counter()

    @property
    def calls(self) -> int:
        return self.files.total()

    def __enter__(self) -> Self:
        missing = [path for path in (_BROKER, *_OUTSIDE) if not Path(path).exists()]
        assert not missing, f"moved, so it would be counted: {missing}"
        sys.setprofile(self._on_event)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        sys.setprofile(None)

    def _on_event(self, frame: FrameType, event: str, _argument: object) -> None:
        if event != "call":
            return
        file = frame.f_code.co_filename
        if file.startswith(_SOURCE) and not file.startswith(_OUTSIDE) and not _is_of_broker(frame):
            self.files[file.removeprefix(_SOURCE)] += 1


def _is_of_broker(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith(_BROKER):
            return True
        frame = frame.f_back
    return False
