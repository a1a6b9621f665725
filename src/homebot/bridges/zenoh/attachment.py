"""The attachment of each ROS 2 message on Zenoh: its number, its time and its writer. Pure.

Source: rmw_zenoh, ``attachment_helpers.cpp``; before version 0.2.4 of Jazzy (2025-04) with the name of each value.
"""

import struct
from typing import NamedTuple, Self

from homebot.errors import TypeMismatchError

_FORM = struct.Struct("<qqB16s")
_OLD_FORM = struct.Struct("<16sq17sq11sB16s")
_OLD_NAMES = (b"\x0fsequence_number", b"\x10source_timestamp", b"\x0asource_gid")
_GID_SIZE = 16


class Attachment(NamedTuple):
    """Facts beside a message.

    Attributes:
        number: Counts the messages of the writer.
        time: When it was published, in nanoseconds since 1970.
        gid: The 16 bytes that identify the writer.
    """

    number: int
    time: int
    gid: bytes

    def to_bytes(self) -> bytes:
        """Return the 33 bytes that are sent."""
        return _FORM.pack(self.number, self.time, _GID_SIZE, self.gid)

    @classmethod
    def of_bytes(cls, data: bytes) -> Self:
        """Return the attachment that *data* is, also in the old form.

        Raises:
            TypeMismatchError: It has neither form.
        """
        if len(data) == _FORM.size:
            number, time, size, gid = _FORM.unpack(data)
            if size == _GID_SIZE:
                return cls(number, time, gid)
        elif len(data) == _OLD_FORM.size:
            one, number, two, time, three, size, gid = _OLD_FORM.unpack(data)
            if (one, two, three, size) == (*_OLD_NAMES, _GID_SIZE):
                return cls(number, time, gid)
        raise TypeMismatchError(
            f"{len(data)} bytes beside a message are not those of ROS 2 on Zenoh ({_FORM.size} or {_OLD_FORM.size}); "
            "is its sender rmw_zenoh?"
        )
