"""Readers that nfcpy drives, over USB, a serial port or UDP. The only file that imports nfcpy."""

import logging
import time
from typing import cast

import nfc

from homebot.conventions.nfc.ndef_message import MAX_MESSAGE, TagContent, TagError
from homebot.errors import LinkError
from homebot.gateways.nfc.reader import ReaderDesk, TagReader

_TECHNOLOGIES = ("106A", "106B", "212F")
_POLL = 0.1
"""Seconds between two polls for a tag, or for whether it is still there."""

_DENIED = 13
_MAX_EXCHANGES = 4096
"""Exchanges that a tag may cost each time: nfcpy asks one that answers nothing for ever."""


class _Frontend(nfc.ContactlessFrontend):  # type: ignore[misc]  # the library has no types
    """nfcpy's reader, which lets a tag time out that costs too many exchanges, or at the end of the *desk*."""

    def __init__(self, path: str, desk: ReaderDesk) -> None:
        super().__init__(path)
        self._desk = desk
        self.exchanges = 0

    def exchange(self, send_data: bytes, timeout: float) -> bytes:
        self.exchanges += 1
        if self.exchanges > _MAX_EXCHANGES or self._desk.is_stopped:
            raise nfc.clf.TimeoutError
        return cast("bytes", super().exchange(send_data, timeout))


class NfcpyReader(TagReader):
    """The reader at a path of nfcpy: ``usb``, ``tty:USB0:pn532``, ``udp:HOST:PORT``."""

    def __init__(self, path: str) -> None:
        self._path = path

    def run(self, desk: ReaderDesk) -> None:
        """Read tags until the *desk* is stopped."""
        log = logging.getLogger("nfc")
        if not log.handlers:  # it would report each tag that is taken away early as an error in the terminal
            log.addHandler(logging.NullHandler())
        try:
            frontend = _Frontend(self._path, desk)
        except Exception as exc:
            raise LinkError(self._why(exc)) from exc
        try:
            desk.found(self._path)
            while not desk.is_stopped:
                self._look(frontend, desk)
        finally:
            frontend.close()

    def _look(self, frontend: _Frontend, desk: ReaderDesk) -> None:
        """Wait for a tag, read it, and watch it until it is taken away."""
        options = {
            "targets": list(_TECHNOLOGIES),
            "iterations": 1,
            "interval": _POLL,
            "on-connect": lambda _tag: False,
        }
        deadline = time.monotonic() + _POLL
        frontend.exchanges = 0
        try:
            tag = frontend.connect(rdwr=options, terminate=lambda: desk.is_stopped or time.monotonic() > deadline)
        except Exception as exc:  # noqa: BLE001 - nfcpy does not check the length of answers
            desk.unreadable(self._path, f"something at the reader gave an invalid answer ({type(exc).__name__})")
            desk.wait(_POLL)
            return
        if tag is False:
            raise LinkError(f"the reader {self._path} stopped answering")
        if tag is None:
            return
        present = _NfcpyTag(tag)
        desk.arrived(self._path, present)
        while not desk.wait(_POLL) and present.is_there():
            desk.stayed(self._path, present)
        desk.left(present.uid)

    def _why(self, error: Exception) -> str:
        if isinstance(error, OSError) and error.errno == _DENIED:
            return f"this user has no permission to use the reader {self._path}; nfcpy's udev rule gives it"
        if isinstance(error, OSError):
            return f"nfcpy finds no reader {self._path}, or another program holds it, such as pcscd"
        return f"the reader {self._path} cannot be used: {type(error).__name__} {error}"


class _NfcpyTag:
    def __init__(self, tag: nfc.tag.Tag) -> None:
        self._tag = tag
        self.uid: str = tag.identifier.hex()
        self.tag_type: str = f"NFC Forum {tag.type.removesuffix('Tag').replace('Type', 'Type ')}"

    def is_there(self) -> bool:
        self._tag.clf.exchanges = 0
        try:
            return bool(self._tag.is_present)
        except Exception:  # noqa: BLE001 - as in read()
            return False

    def read(self) -> TagContent:
        ndef = self._ndef()
        if ndef.length > MAX_MESSAGE:
            raise TagError("unreadable", f"its message has {ndef.length} bytes; homebot reads {MAX_MESSAGE} at most")
        return TagContent(ndef.octets, ndef.capacity, ndef.is_writeable)

    def write(self, message: bytes) -> None:
        ndef = self._ndef()
        if not ndef.is_writeable:
            raise TagError("protected", "it is write-protected")
        if len(message) > ndef.capacity:
            raise TagError("too_small", f"it holds {ndef.capacity} bytes, and the message has {len(message)}")
        try:
            ndef.octets = message
        except Exception as exc:
            raise TagError("lost", f"it was taken away, or refused to be written ({exc})") from exc

    def _ndef(self) -> nfc.tag.Tag.NDEF:
        """Read the tag again, and return its NDEF data."""
        self._tag.clf.exchanges = 0
        try:
            ndef = self._tag.ndef
            changed = ndef is not None and ndef.has_changed
            ndef = self._tag.ndef if changed else ndef
        except Exception as exc:
            raise TagError("unreadable", f"its memory cannot be read: {type(exc).__name__}") from exc
        if ndef is None:
            raise TagError("not_a_tag", "it is not formatted for NDEF")
        return ndef
