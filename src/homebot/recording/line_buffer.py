"""Lines of a recording that wait to be written."""

from __future__ import annotations

from typing import Final, final

from homebot.recording.lines import LostLines, RecordingLine, line_text

__all__ = ["LineBuffer"]

_MOST_LINES: Final = 50_000
_MOST_BYTES: Final = 64 * 1024 * 1024


@final
class LineBuffer:
    """At most 50,000 lines and 64 MiB of text; while it is full, new lines are dropped, and a line says how many."""

    def __init__(self) -> None:
        self.lost = 0
        self._lines: list[str] = []
        self._bytes = 0
        self._gap = 0

    def add(self, line: RecordingLine) -> bool:
        """Add a line, or count it if there is no room; return whether it was added."""
        text = line_text(line)
        if len(self._lines) >= _MOST_LINES or self._bytes + len(text) > _MOST_BYTES:
            self.lost += 1
            self._gap += 1
            return False
        if self._gap:
            self._put(line_text(RecordingLine(line.at, LostLines(count=self._gap))))
            self._gap = 0
        self._put(text)
        return True

    def pop(self, most: int = _MOST_LINES, most_bytes: int = _MOST_BYTES) -> list[str]:
        """Remove and return the oldest lines, at least one if there is any, without their ends.

        Args:
            most: How many at most.
            most_bytes: How much text at most.
        """
        count, size = 0, 0
        for text in self._lines[:most]:
            if count and size + len(text) > most_bytes:
                break
            count, size = count + 1, size + len(text)
        taken, self._lines = self._lines[:count], self._lines[count:]
        self._bytes -= size
        return taken

    @property
    def is_empty(self) -> bool:
        """True if no line waits."""
        return not self._lines

    def _put(self, text: str) -> None:
        self._lines.append(text)
        self._bytes += len(text)
