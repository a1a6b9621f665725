"""The frames of one client, whole or in fragments. No I/O."""

from __future__ import annotations

from collections.abc import Generator
from typing import Final, final

from homebot.bridges.rosbridge.protocol import Fragment, FrameError, Identifier, Operation, parse_frame

__all__ = ["FrameAssembler"]

_MOST_OPEN: Final = 10


@final
class FrameAssembler:
    """Reads operations; a fragmented one after its last fragment, in any order.

    The fragments of ten frames may wait for others; those of one more replace those that have waited longest.

    Args:
        limit: Characters that may wait.

    Attributes:
        dropped: Frames whose fragments were replaced.
    """

    def __init__(self, limit: int) -> None:
        self.dropped = 0
        self._limit = limit
        self._open: dict[Identifier, _Collected] = {}

    def read(self, frame: str) -> Generator[None, None, Operation | None]:
        """Return the operation that *frame* asks for; None where it is a fragment, and others are to come.

        Between two steps others may have a turn.

        Raises:
            FrameError: It is no operation, or a fragment that does not fit; those that came before it are forgotten.
        """
        op = yield from parse_frame(frame)
        if not isinstance(op, Fragment):
            return op
        whole = self._collect(op)
        if whole is None:
            return None
        op = yield from parse_frame(whole)
        if isinstance(op, Fragment):
            raise FrameError("a fragment cannot be made of fragments", op.op, op.id)
        return op

    def _collect(self, fragment: Fragment) -> str | None:
        collected = self._open.pop(fragment.id, None) or _Collected(fragment.total)
        if fragment.total != collected.total or fragment.num >= fragment.total:
            raise FrameError(f"number {fragment.num} of {fragment.total} does not fit", fragment.op, fragment.id)
        collected.add(fragment)
        if collected.size + sum(one.size for one in self._open.values()) > self._limit:
            raise FrameError(f"the fragments have more than {self._limit:,} characters", fragment.op, fragment.id)
        if len(collected.parts) == collected.total:
            return "".join(part for _, part in sorted(collected.parts.items()))
        self._open[fragment.id] = collected
        if len(self._open) > _MOST_OPEN:
            del self._open[next(iter(self._open))]
            self.dropped += 1
        return None


class _Collected:
    """The fragments of one frame so far."""

    def __init__(self, total: int) -> None:
        self.total = total
        self.size = 0
        self.parts: dict[int, str] = {}

    def add(self, fragment: Fragment) -> None:
        self.size += len(fragment.data) - len(self.parts.get(fragment.num, ""))
        self.parts[fragment.num] = fragment.data
