"""Readers of the computer's smart-card service (PC/SC), by pyscard. The only file that imports it.

Only pyscard's thin layer over the service is used, as its monitors start threads of their own.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import partial
from types import ModuleType
from typing import Final

from homebot.conventions.nfc.card_tag import CardTag
from homebot.conventions.nfc.ndef_message import TagError
from homebot.errors import LinkError
from homebot.gateways.nfc.reader import ReaderDesk, TagReader

_ANY_CHANGE: Final = "\\\\?PnP?\\Notification"
"""The name under which the service reports that a reader was plugged in or out."""

_MAX_WAIT: Final = 200
"""Milliseconds after which the thread checks whether it should end, or write a tag."""

_TRIES: Final = 3
"""Attempts to connect to a card: one that is still moving answers the second."""

_SETTLE: Final = 0.05
"""Seconds between two attempts."""


@dataclass(slots=True, eq=False)
class _Slot:
    """One reader.

    Attributes:
        state: Its last known state, which the service compares with the current one.
        tag: The card as a tag; None if it is not a tag.
    """

    state: int
    card: object = None
    protocol: int = 0
    tag: CardTag | None = None


class PcscReader(TagReader):
    """All readers of the service, or those with a *wanted* text in their names."""

    def __init__(self, wanted: Collection[str]) -> None:
        self._wanted = [name.casefold() for name in wanted]

    def run(self, desk: ReaderDesk) -> None:
        """Read tags until the *desk* is stopped."""
        try:
            from smartcard import scard  # noqa: PLC0415 - an extra
        except ImportError as exc:
            raise LinkError(f"pyscard cannot be loaded: {exc}") from exc
        result, context = scard.SCardEstablishContext(scard.SCARD_SCOPE_USER)
        if result != scard.SCARD_S_SUCCESS:
            raise LinkError(
                f"the smart-card service (pcscd) is not running ({scard.SCardGetErrorMessage(result).strip()})"
            )
        session = _Session(scard, context, desk, self._wanted)
        try:
            session.run()
        finally:
            session.close()


class _Session:
    def __init__(self, library: ModuleType, context: object, desk: ReaderDesk, wanted: list[str]) -> None:
        self._scard = library
        self._context = context
        self._desk = desk
        self._wanted = wanted
        self._slots: dict[str, _Slot] = {}
        self._any_change = 0

    def run(self) -> None:
        """Follow the readers, which may come and go."""
        self._find_readers(is_first=True)
        while not self._desk.is_stopped:
            asked = [(_ANY_CHANGE, self._any_change), *((name, slot.state) for name, slot in self._slots.items())]
            result, states = self._scard.SCardGetStatusChange(self._context, _MAX_WAIT, asked)
            if result == self._scard.SCARD_E_TIMEOUT:
                self._work()
            elif result in {self._scard.SCARD_E_UNKNOWN_READER, self._scard.SCARD_E_READER_UNAVAILABLE}:
                self._find_readers()
            else:
                self._check(result, "was lost")
                for name, state, _ in states:
                    self._update_slot(name, state)
                self._work()
                self._find_readers()

    def close(self) -> None:
        """Release the cards and the service."""
        for slot in self._slots.values():
            self._release(slot)
        self._scard.SCardReleaseContext(self._context)

    def _find_readers(self, *, is_first: bool = False) -> None:
        try:
            result, names = self._scard.SCardListReaders(self._context, [])
        except (SystemError, UnicodeDecodeError) as exc:  # a service that is stopping may give names that are no text
            raise LinkError("the smart-card service (pcscd) gave invalid names of readers") from exc
        if result != self._scard.SCARD_E_NO_READERS_AVAILABLE:
            self._check(result, "lists no readers")
        readers = [reader for reader in (names or ()) if self._is_wanted(reader)]
        if readers == list(self._slots) and not is_first:
            return
        for gone in [slot for slot in self._slots if slot not in readers]:
            self._leave(self._slots.pop(gone))
        self._slots = {reader: self._slots.get(reader) or _Slot(self._scard.SCARD_STATE_UNAWARE) for reader in readers}
        self._desk.found(*readers)

    def _is_wanted(self, name: str) -> bool:
        return not self._wanted or any(wanted in name.casefold() for wanted in self._wanted)

    def _update_slot(self, name: str, state: int) -> None:
        if name == _ANY_CHANGE:
            self._any_change = state & ~self._scard.SCARD_STATE_CHANGED
            return
        slot = self._slots.get(name)
        if slot is None:
            return
        is_other = slot.state >> 16 != state >> 16  # a counter of inserted and removed cards
        slot.state = state & ~self._scard.SCARD_STATE_CHANGED
        is_there = bool(state & self._scard.SCARD_STATE_PRESENT) and not state & self._scard.SCARD_STATE_MUTE
        if slot.card is not None and (not is_there or is_other):
            self._leave(slot)
        if is_there and slot.card is None:
            self._arrive(name, slot)

    def _arrive(self, name: str, slot: _Slot) -> None:
        protocols = self._scard.SCARD_PROTOCOL_T0 | self._scard.SCARD_PROTOCOL_T1
        for _ in range(_TRIES):
            result, card, protocol = self._scard.SCardConnect(
                self._context, name, self._scard.SCARD_SHARE_SHARED, protocols
            )
            if result == self._scard.SCARD_S_SUCCESS:
                break
            self._desk.wait(_SETTLE)
        else:
            return
        slot.card, slot.protocol = card, protocol
        try:
            slot.tag = CardTag(partial(self._transmit, slot))
        except TagError as exc:
            self._desk.unreadable(name, str(exc))
            return
        self._desk.arrived(name, slot.tag)

    def _work(self) -> None:
        """Write tags that were at a reader before the order came."""
        for name, slot in self._slots.items():
            if slot.tag is not None:
                self._desk.stayed(name, slot.tag)

    def _leave(self, slot: _Slot) -> None:
        tag = slot.tag
        self._release(slot)
        if tag is not None:
            self._desk.left(tag.uid)

    def _release(self, slot: _Slot) -> None:
        if slot.card is not None:
            self._scard.SCardDisconnect(slot.card, self._scard.SCARD_LEAVE_CARD)
        slot.card, slot.tag = None, None

    def _transmit(self, slot: _Slot, apdu: bytes) -> tuple[bytes, int]:
        is_t0 = slot.protocol == self._scard.SCARD_PROTOCOL_T0
        header = self._scard.SCARD_PCI_T0 if is_t0 else self._scard.SCARD_PCI_T1
        result, answer = self._scard.SCardTransmit(slot.card, header, list(apdu))
        if result != self._scard.SCARD_S_SUCCESS or len(answer) < 2:
            raise TagError("lost", f"it was taken away ({self._scard.SCardGetErrorMessage(result).strip()})")
        return bytes(answer[:-2]), answer[-2] << 8 | answer[-1]

    def _check(self, result: int, what: str) -> None:
        if result != self._scard.SCARD_S_SUCCESS:
            why = self._scard.SCardGetErrorMessage(result).strip()
            raise LinkError(f"the smart-card service (pcscd) {what} ({why})")
