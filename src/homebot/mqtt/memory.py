"""Give memory that is free again back to the system, which glibc does only at the end of its heap."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Final, final

__all__ = ["MemoryKeeper"]

_WORTH_IT: Final = 8 * 1024 * 1024  # bytes; giving back takes some milliseconds


class _MallocInfo(ctypes.Structure):
    """``struct mallinfo2`` of glibc 2.33; its field ``fordblks`` says how many bytes the allocator holds unused."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            *("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks"),
            *("fordblks", "keepcost"),
        )
    )
    fordblks: int


@final
class MemoryKeeper:
    """Asks the allocator to give back what is free, when something was freed since it was asked last."""

    def __init__(self) -> None:
        self._seen = 0

    def look(self, activity: int) -> None:
        """Look whether there may be something to give back.

        Args:
            activity: A count that grows with all that may have freed memory.
        """
        if activity == self._seen or _info is None or _trim is None:
            return
        self._seen = activity
        if _info().fordblks >= _WORTH_IT:
            _trim(0)


def _find() -> tuple[Callable[[], _MallocInfo] | None, Callable[[int], int] | None]:
    try:
        libc = ctypes.CDLL(None)
        info, trim = libc.mallinfo2, libc.malloc_trim
    except (AttributeError, OSError, TypeError):  # another libc than glibc, or an old one
        return None, None
    info.restype = _MallocInfo
    return info, trim


_info, _trim = _find()
