"""A limit on the frames of a client. No I/O."""

from __future__ import annotations

from typing import final

__all__ = ["FrameRate"]


@final
class FrameRate:
    """Computes how long a client's next frame has to wait so that it sends no more than *limit* a second on average.

    A client that was quiet may send the frames of a whole second at once.
    """

    def __init__(self, limit: int, now: float) -> None:
        self._limit = limit
        self._tokens = float(limit)
        self._filled_at = now

    def take(self, now: float) -> float:
        """Count one frame; return the seconds to wait before it is handled, mostly 0."""
        self._tokens = min(float(self._limit), self._tokens + (now - self._filled_at) * self._limit) - 1
        self._filled_at = now
        return max(0.0, -self._tokens / self._limit)
