"""A simulated tag: an NFC Forum Type 4 Tag 2.0 that answers APDUs (ISO/IEC 7816-4). Pure."""

from typing import Final

_APPLICATION: Final = bytes.fromhex("D2760000850101")
_CONTAINER: Final = 0xE103
_FILE: Final = 0xE104
_MAX_BYTES: Final = 0xF0
"""Bytes that it takes or gives in one answer."""

_OK: Final = b"\x90\x00"
_NOT_FOUND: Final = b"\x6a\x82"
_DENIED: Final = b"\x69\x82"
_WRONG_OFFSET: Final = b"\x6b\x00"
_UNKNOWN: Final = b"\x6d\x00"


class Type4Card:
    """A tag with an NDEF message, which may have *capacity* bytes."""

    def __init__(self, uid: bytes, message: bytes = b"", *, capacity: int = 888, is_writable: bool = True) -> None:
        self.uid = uid
        self._is_writable = is_writable
        size = (capacity + 2).to_bytes(2, "big")
        most = _MAX_BYTES.to_bytes(2, "big")
        access = bytes([0x00, 0x00 if is_writable else 0xFF])
        container = b"\x00\x0f\x20" + most + most + b"\x04\x06" + _FILE.to_bytes(2, "big") + size + access
        self._files = {_CONTAINER: bytearray(container), _FILE: bytearray(capacity + 2)}
        self._selected = 0
        self.put(message)

    @property
    def message(self) -> bytes:
        """The NDEF message that is on it."""
        file = self._files[_FILE]
        return bytes(file[2 : 2 + int.from_bytes(file[:2], "big")])

    def put(self, message: bytes) -> None:
        """Write *message* to it, ignoring its protection."""
        whole = len(message).to_bytes(2, "big") + message
        self._files[_FILE][: len(whole)] = whole

    def answer(self, apdu: bytes) -> bytes:
        """Return its answer to *apdu*, with the status word at the end."""
        if apdu[:2] == b"\x00\xa4":
            if apdu[2:4] == b"\x04\x00":
                return _OK if apdu[5 : 5 + apdu[4]] == _APPLICATION else _NOT_FOUND
            if apdu[2] != 0:
                return _UNKNOWN
            self._selected = int.from_bytes(apdu[5:7], "big")
            return _OK if self._selected in self._files else _NOT_FOUND
        offset, file = int.from_bytes(apdu[2:4], "big"), self._files.get(self._selected)
        if file is None or apdu[:1] != b"\x00":
            return _UNKNOWN
        if apdu[1:2] == b"\xb0":
            return bytes(file[offset : offset + (apdu[4] or 256)]) + _OK
        if apdu[1:2] == b"\xd6":
            return self._update(file, offset, apdu[5 : 5 + apdu[4]])
        return _UNKNOWN

    def _update(self, file: bytearray, offset: int, data: bytes) -> bytes:
        if not self._is_writable or self._selected != _FILE:
            return _DENIED
        if offset + len(data) > len(file):
            return _WRONG_OFFSET
        file[offset : offset + len(data)] = data
        return _OK
