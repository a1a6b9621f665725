"""The failing day in a file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hypothesis.errors import HypothesisException

from homebot.testing.day import Day

__all__ = ["saved_if_failing"]


@contextmanager
def saved_if_failing(day: Day, path: str | Path) -> Iterator[None]:
    """Save *day* to *path* when the block raises; the error goes on, and says where the day is.

    Hypothesis runs the shrunk example last, so the file holds that one in the end.

    Args:
        day: The day that the block is about.
        path: The file; a relative one is relative to the working directory.

    Raises:
        UsageError: The file cannot be written.
    """
    try:
        yield
    except HypothesisException:
        raise  # an example that was turned down, not one that failed
    except Exception as exc:
        day.save(path)
        exc.add_note(f"the day is in {path}: Day.load({str(path)!r})")
        raise
