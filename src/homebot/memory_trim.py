"""Gives memory that is free again back to the system, which glibc does only at the end of its heap."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Final, Protocol, TypeAlias, final

__all__ = ["MemoryTrimmer"]

_WORTH_IT: Final = 8 * 1024 * 1024  # bytes; giving back takes some milliseconds


class _MallocInfo(Protocol):
    """``struct mallinfo2`` of glibc 2.33; its field ``fordblks`` says how many bytes the allocator holds unused."""

    fordblks: int


_Allocator: TypeAlias = tuple[Callable[[], _MallocInfo], Callable[[int], int]]
"""Functions that report what the allocator holds, and give back what is free."""


@final
class MemoryTrimmer:
    """Asks the allocator to give back what is free, when something was freed since it was asked last."""

    def __init__(self) -> None:
        self._seen = 0

    def trim_if_worthwhile(self, activity: int) -> None:
        """Give back what is free, where it is worth the time.

        Args:
            activity: A count that grows with all that may have freed memory.
        """
        if activity == self._seen or (allocator := _allocator()) is None:
            return
        self._seen = activity
        info, trim = allocator
        if info().fordblks >= _WORTH_IT:
            trim(0)


@cache
def _allocator() -> _Allocator | None:
    import ctypes  # noqa: PLC0415 - ten milliseconds, which no start needs

    class MallocInfo(ctypes.Structure):
        _fields_ = tuple(
            (name, ctypes.c_size_t)
            for name in (
                *("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks"),
                *("fordblks", "keepcost"),
            )
        )
        fordblks: int

    try:
        libc = ctypes.CDLL(None)
        info, trim = libc.mallinfo2, libc.malloc_trim
    except (AttributeError, OSError, TypeError):  # another libc than glibc, or an old one
        return None
    info.restype = MallocInfo
    return info, trim
