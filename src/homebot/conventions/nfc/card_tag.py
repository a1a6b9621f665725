"""A tag that is reached by APDUs, as PC/SC readers pass them on. Pure but for the one call that sends an APDU.

NFC Forum Type 4 Tag 1.2, chapters 5 (NDEF application, capability container) and 7 (reading and writing); NFC Forum
Type 2 Tag 1.2, chapters 2 (TLVs) and 6 (capability container), read and written by the storage card commands of PC/SC
2.01 part 3, section 3.2.2.1: ``FF CA`` (number), ``FF B0`` (read binary), ``FF D6`` (update binary).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple, TypeAlias

from homebot.conventions.nfc.ndef_message import MAX_MESSAGE, TagContent, TagError

Transmit: TypeAlias = Callable[[bytes], tuple[bytes, int]]
"""Sends an APDU and returns the answer with its status word; raises :class:`TagError` where the card was taken away."""

_OK: Final = 0x9000
_NDEF_APPLICATION: Final = bytes.fromhex("D2760000850101")
_CONTAINER: Final = 0xE103
_PAGE: Final = 4
_FIRST_PAGE: Final = 4
_MAX_SHORT: Final = 0xFE
_MAGIC: Final = 0xE1
_NULL, _MESSAGE, _END = 0x00, 0x03, 0xFE


class CardTag:
    """A tag behind a PC/SC reader.

    Raises:
        TagError: It has no number, or was taken away.
    """

    def __init__(self, transmit: Transmit) -> None:
        self._transmit = transmit
        number, status = transmit(b"\xff\xca\x00\x00\x00")
        if status != _OK or not 4 <= len(number) <= 10:
            raise TagError("not_a_tag", f"it has no number (status {status:04x})")
        self.uid = number.hex()
        self.tag_type = "NFC Forum Type 4" if self._has_application() else "NFC Forum Type 2"

    def read(self) -> TagContent:
        """Return its content."""
        return self._memory().read()

    def write(self, message: bytes) -> None:
        """Replace its content by *message*."""
        self._memory().write(message)

    def _has_application(self) -> bool:
        select = bytes([0x00, 0xA4, 0x04, 0x00, len(_NDEF_APPLICATION), *_NDEF_APPLICATION, 0x00])
        return self._transmit(select)[1] == _OK

    def _memory(self) -> _Type4Memory | _Type2Memory:
        return _Type4Memory(self._transmit) if self._has_application() else _Type2Memory(self._transmit)


class _Type4Memory:
    """The NDEF file of a Type 4 tag with a selected application."""

    def __init__(self, transmit: Transmit) -> None:
        self._transmit = transmit
        self._select(_CONTAINER)
        container = self._read(0, 15)
        if len(container) < 15 or container[2] >> 4 not in {1, 2, 3} or container[7:9] != b"\x04\x06":
            raise TagError("not_a_tag", "its capability container is not that of a Type 4 tag")
        # At least 1, so that a container of zeros does not make us ask for ever.
        self._most_read = max(1, min(int.from_bytes(container[3:5], "big"), 255))
        self._most_written = max(1, min(int.from_bytes(container[5:7], "big"), 255))
        self._file = int.from_bytes(container[9:11], "big")
        self._capacity = max(0, int.from_bytes(container[11:13], "big") - 2)
        self._is_readable, self._is_writable = container[13] == 0, container[14] == 0

    def read(self) -> TagContent:
        if not self._is_readable:
            raise TagError("protected", "it is read-protected")
        self._select(self._file)
        length = int.from_bytes(self._read(0, 2), "big")
        if length > min(self._capacity, MAX_MESSAGE):
            raise TagError("unreadable", f"it announces a message of {length} bytes, but holds {self._capacity}")
        message = b""
        while len(message) < length:
            more = self._read(2 + len(message), min(self._most_read, length - len(message)))
            if not more:
                raise TagError("unreadable", "its message ends early")
            message += more
        return TagContent(message[:length], self._capacity, self._is_writable)

    def write(self, message: bytes) -> None:
        """Write *message*, its length last: a tag that is taken away too early has no message, not half of one."""
        _check_room(len(message), self._capacity, is_writable=self._is_writable)
        self._select(self._file)
        self._update(0, b"\x00\x00")
        for start in range(0, len(message), self._most_written):
            self._update(2 + start, message[start : start + self._most_written])
        self._update(0, len(message).to_bytes(2, "big"))

    def _select(self, file: int) -> None:
        _, status = self._transmit(bytes.fromhex("00A4000C02") + file.to_bytes(2, "big"))
        if status != _OK:
            raise TagError("not_a_tag", f"it has no file {file:04x} (status {status:04x})")

    def _read(self, offset: int, count: int) -> bytes:
        data, status = self._transmit(b"\x00\xb0" + offset.to_bytes(2, "big") + bytes([count]))
        if status != _OK:
            raise TagError("unreadable", f"reading failed (status {status:04x})")
        return data[:count]

    def _update(self, offset: int, data: bytes) -> None:
        _, status = self._transmit(b"\x00\xd6" + offset.to_bytes(2, "big") + bytes([len(data)]) + data)
        if status != _OK:
            raise _not_written(status)


class _Found(NamedTuple):
    """The NDEF message TLV in the memory of a Type 2 tag: where it begins, and its value."""

    start: int
    message: bytes


class _Type2Memory:
    """The memory of a Type 2 tag, such as NTAG21x and MIFARE Ultralight."""

    def __init__(self, transmit: Transmit) -> None:
        self._transmit = transmit
        container = self._read_pages(3)[:4]
        if len(container) < 4 or container[0] != _MAGIC or container[1] >> 4 != 1:
            raise TagError("not_a_tag", "it is not formatted for NDEF")
        self._size = container[2] * 8
        self._is_readable, self._is_writable = container[3] >> 4 == 0, container[3] & 0xF == 0

    def read(self) -> TagContent:
        if not self._is_readable:
            raise TagError("protected", "it is read-protected")
        area = self._find(self._read_area())
        return TagContent(area.message, self._room(area.start), self._is_writable)

    def write(self, message: bytes) -> None:
        """Write *message*, its length last, as on a Type 4 tag."""
        area = bytearray(self._read_area())
        start = self._find(bytes(area)).start
        _check_room(len(message), self._room(start), is_writable=self._is_writable)
        is_short = len(message) <= _MAX_SHORT
        length = bytes([len(message)]) if is_short else b"\xff" + len(message).to_bytes(2, "big")
        whole = bytes([_MESSAGE]) + length + message
        if start + len(whole) < self._size:
            whole += bytes([_END])
        area[start : start + len(whole)] = whole
        hidden = bytearray(area)
        hidden[start + 1 : start + 1 + len(length)] = bytes(len(length))
        first, last = start // _PAGE, (start + len(whole) - 1) // _PAGE
        for page in range(first, last + 1):
            self._update_page(page, bytes(hidden[page * _PAGE : (page + 1) * _PAGE]))
        for page in range(first, (start + len(length)) // _PAGE + 1):
            self._update_page(page, bytes(area[page * _PAGE : (page + 1) * _PAGE]))

    def _room(self, start: int) -> int:
        """Return the longest message at *start*: above 254 bytes, its length takes two more bytes."""
        left = self._size - start
        return max(0, left - 2 if left - 2 <= _MAX_SHORT else left - 4)

    def _read_area(self) -> bytes:
        """Return the data area."""
        if self._size > MAX_MESSAGE:
            raise TagError("unreadable", f"it announces a memory of {self._size} bytes, more than {MAX_MESSAGE}")
        area = b""
        while len(area) < self._size:
            more = self._read_pages(_FIRST_PAGE + len(area) // _PAGE)
            if len(more) < _PAGE:
                raise TagError("unreadable", "its memory ends early")
            area += more
        return area[: self._size]

    def _find(self, area: bytes) -> _Found:
        """Return the NDEF message TLV; an empty one at its place if there is none."""
        at = 0
        while at < len(area):
            kind = area[at]
            if kind == _NULL:
                at += 1
                continue
            if kind == _END or at + 1 >= len(area):
                break
            head = 4 if area[at + 1] == 0xFF else 2
            length = int.from_bytes(area[at + 2 : at + 4], "big") if head == 4 else area[at + 1]
            if at + head + length > len(area):
                raise TagError("unreadable", f"it announces {length} bytes, but {len(area) - at - head} are left")
            if kind == _MESSAGE:
                return _Found(at, area[at + head : at + head + length])
            at += head + length
        return _Found(min(at, len(area)), b"")

    def _read_pages(self, page: int) -> bytes:
        """Return four pages, or fewer if the reader gives fewer."""
        data, status = self._transmit(bytes([0xFF, 0xB0, page >> 8, page & 0xFF, 16]))
        if status != _OK:
            raise TagError("not_a_tag", f"reading failed (status {status:04x})")
        return data[: len(data) // _PAGE * _PAGE][:16]

    def _update_page(self, page: int, data: bytes) -> None:
        number = _FIRST_PAGE + page
        _, status = self._transmit(bytes([0xFF, 0xD6, number >> 8, number & 0xFF, _PAGE]) + data.ljust(_PAGE, b"\x00"))
        if status != _OK:
            raise _not_written(status)


def _check_room(length: int, capacity: int, *, is_writable: bool) -> None:
    if not is_writable:
        raise TagError("protected", "it is write-protected")
    if length > capacity:
        raise TagError("too_small", f"it holds {capacity} bytes, and the message has {length}")


def _not_written(status: int) -> TagError:
    return TagError("protected", f"it refuses to be written (status {status:04x})")
