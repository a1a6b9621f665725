"""The field of a simulated reader, into which tags are held, as nfcpy drives it by ``udp:HOST:PORT``.

Each datagram is a bit rate with its modulation, such as ``106A``, and hexadecimal digits. Tags answer as Type A targets
(ISO/IEC 14443-3) and in blocks of ISO/IEC 14443-4. It is served in a thread, as a reader asks again after milliseconds.
"""

import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from threading import Event
from typing import Final

import anyio
from anyio import CapacityLimiter, to_thread
from tests.simulated.nfc.type4_card import Type4Card

from homebot.conventions.nfc.ndef_message import NdefRecord, write_ndef
from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.tag import AWAY
from homebot.house.wire import hardware_address

_SENSE: Final = b"\x26"
_SENSED: Final = b"\x44\x03"
_CASCADE: Final = b"\x93\x95\x97"
_IS_ISO_DEP: Final = 0x20
_NOT_COMPLETE: Final = 0x04
_ANSWER_TO_SELECT: Final = bytes.fromhex("057880D002")
"""Frames of 256 bytes, and 2.5 seconds for an answer: a computer may be busier than a tag."""

_NOBODY: Final = b"RFOFF"


class TagField:
    """The field of one reader; entered by :meth:`served`.

    Args:
        port: The UDP port on loopback; 0 for any.

    Attributes:
        card: The tag that is in the field; None for none.
        port: Likewise, the one that it has while it is served.
    """

    def __init__(self, port: int = 0) -> None:
        self.card: Type4Card | None = None
        self.port = port
        self._last = b""
        self._activated: Type4Card | None = None

    @property
    def path(self) -> str:
        """Its name in nfcpy."""
        return f"udp:127.0.0.1:{self.port}"

    @asynccontextmanager
    async def served(self) -> AsyncIterator[None]:
        """Serve the reader inside the block."""
        stopped = Event()
        with _bound(self.port) as server:
            server.settimeout(0.05)
            self.port = server.getsockname()[1]
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(partial(to_thread.run_sync, self._serve, server, stopped, limiter=CapacityLimiter(1)))
                try:
                    yield
                finally:
                    stopped.set()

    def _serve(self, server: socket.socket, stopped: Event) -> None:
        while not stopped.is_set():
            try:
                datagram, sender = server.recvfrom(1024)
            except (TimeoutError, ConnectionError):
                continue
            rate, _, digits = datagram.partition(b" ")
            if not digits:
                continue  # the reader has turned its field off
            answer = self._answer(rate, bytes.fromhex(digits.decode()))
            server.sendto(rate + b" " + answer.hex().encode() if answer else _NOBODY, sender)

    def _answer(self, rate: bytes, command: bytes) -> bytes:
        """Return the tag's answer, or nothing without a tag."""
        card = self.card
        if card is None or rate != b"106A":
            return b""
        if command == _SENSE:
            return _SENSED
        if command[:1] in {b"\x93", b"\x95", b"\x97"}:
            return _select(card.uid, command)
        if command[:1] == b"\xe0":
            self._activated = card
            return _ANSWER_TO_SELECT
        return self._answer_block(card, command) if card is self._activated else b""

    def _answer_block(self, card: Type4Card, block: bytes) -> bytes:
        kind = block[0]
        if kind & 0xE2 == 0x02:  # information
            self._last = bytes([kind]) + card.answer(block[1:])
            return self._last if self.card is card else b""
        if kind & 0xF6 == 0xB2:  # not acknowledged: repeat the last block, or test for presence
            return self._last if self._last[:1] == bytes([kind & 1 | 2]) else bytes([0xA2 | kind & 1])
        return block[:1] if kind & 0xF7 == 0xC2 else b""  # deselected


def _bound(port: int) -> socket.socket:
    """Return a socket at it; any port that is free has no name in the list of services, for nfcpy reads a number."""
    server = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    server.bind(("127.0.0.1", port))
    if port == 0 and not socket.getnameinfo(server.getsockname(), socket.NI_NUMERICHOST)[1].isdecimal():
        with server:
            return _bound(0)
    return server


def _select(uid: bytes, command: bytes) -> bytes:
    """Return the answer in anti-collision: four bytes of the number and their sum, or that they are selected."""
    level = _CASCADE.index(command[0])
    parts = [uid] if len(uid) == 4 else [b"\x88" + uid[:3], uid[3:]]
    if level >= len(parts):
        return b""
    if command[1] == 0x20:
        part = parts[level]
        return part + bytes([part[0] ^ part[1] ^ part[2] ^ part[3]])
    return bytes([_IS_ISO_DEP if level == len(parts) - 1 else _NOT_COMPLETE])


class ServedTag(ServedDevice):
    """A tag with a text, and its room as its area, for the field of a reader; it takes no commands."""

    def __init__(self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], field: TagField) -> None:
        super().__init__(device, on_command)
        self._field = field
        self._card = Type4Card(bytes.fromhex(f"04{hardware_address(device)[:12]}"))

    async def serve(self) -> None:
        """Do nothing: it is at the reader, or away."""
        await anyio.sleep_forever()

    def show(self) -> None:
        """Hold the tag to the reader, or take it away."""
        if self.state.text != AWAY:
            self._card.put(write_ndef(NdefRecord("text", f"{self.state.text}\narea: {self.device.room}".encode())))
            self._field.card = self._card
        elif self._field.card is self._card:
            self._field.card = None
