"""Tags behind a PC/SC reader: Type 4 by its files, Type 2 by the storage card commands of the reader."""

from collections.abc import Callable

import pytest
from tests.gateways.nfc.world import UID, card, uri
from tests.simulated.nfc.type4_card import Type4Card

from homebot.conventions.nfc.card_tag import CardTag
from homebot.conventions.nfc.ndef_message import MAX_MESSAGE, TagError

LONG = uri(f"http://example.org/{'a' * 500}")


class StorageCard:
    """An NTAG21x behind a reader: pages of four bytes, of which the reader gives sixteen bytes at once."""

    def __init__(self, size: int = 496, access: int = 0) -> None:
        self.memory = bytearray(16 + size)
        self.memory[12:16] = bytes([0xE1, 0x10, size // 8, access])

    def put(self, data: bytes) -> None:
        self.memory[16 : 16 + len(data)] = data

    def transmit(self, apdu: bytes) -> tuple[bytes, int]:
        if apdu[:2] == b"\xff\xca":
            return bytes.fromhex(UID), 0x9000
        at = int.from_bytes(apdu[2:4], "big") * 4
        if apdu[:2] == b"\xff\xb0" and at < len(self.memory):
            return bytes((self.memory + bytes(16))[at : at + 16]), 0x9000
        if apdu[:2] == b"\xff\xd6" and 16 <= at < len(self.memory) and len(apdu) == 9:
            self.memory[at : at + 4] = apdu[5:]
            return b"", 0x9000
        return b"", 0x6300


def transmit_to(tag: Type4Card) -> Callable[[bytes], tuple[bytes, int]]:
    def transmit(apdu: bytes) -> tuple[bytes, int]:
        answer = tag.answer(apdu)
        return answer[:-2], int.from_bytes(answer[-2:], "big")

    return transmit


def test_a_type_4_tag_is_written_and_read_again() -> None:
    for message in (uri("homebot:device/a"), LONG, b""):
        tag = CardTag(transmit_to(card(uri("http://before/"))))
        tag.write(message)
        assert (tag.uid, tag.tag_type, tag.read().message) == (UID, "NFC Forum Type 4", message)


def test_a_type_2_tag_is_written_and_read_again() -> None:
    for message in (uri("homebot:device/a"), uri("http://b/" + "b" * 300), b""):
        storage = StorageCard()
        storage.put(b"\x03\x00\xfe")
        tag = CardTag(storage.transmit)
        tag.write(message)
        content = tag.read()
        assert (tag.tag_type, content.message, content.is_writable) == ("NFC Forum Type 2", message, True)


def test_other_blocks_of_a_type_2_tag_stay_as_they_are() -> None:
    storage = StorageCard()
    lock = b"\x01\x03\xa0\x0c\x34"  # the lock control TLV of an NTAG213 as it is delivered
    storage.put(lock + b"\x03\x00\xfe")
    tag = CardTag(storage.transmit)
    tag.write(uri("homebot:device/a"))
    assert storage.memory[16:21] == lock
    assert tag.read().message == uri("homebot:device/a")


def test_a_too_small_tag_is_an_error_and_stays_unchanged() -> None:
    storage, before = StorageCard(48), uri("http://a/")
    storage.put(b"\x03" + bytes([len(before)]) + before + b"\xfe")
    for tag in (CardTag(storage.transmit), CardTag(transmit_to(card(before, capacity=46)))):
        with pytest.raises(TagError, match="holds 46 bytes") as caught:
            tag.write(LONG)
        assert caught.value.problem == "too_small"
        assert tag.read().message == before
        exact = uri("http://" + "c" * (46 - len(uri("http://"))))
        tag.write(exact)
        assert tag.read().message == exact


def test_a_protected_tag_is_an_error() -> None:
    storage = StorageCard(access=0x0F)
    storage.put(b"\x03\x00\xfe")
    for tag in (CardTag(storage.transmit), CardTag(transmit_to(card(is_writable=False)))):
        with pytest.raises(TagError, match="write-protected") as caught:
            tag.write(b"\xd0\x00\x00")
        assert caught.value.problem == "protected"


@pytest.mark.parametrize(
    "area",
    [b"\x03\xf0", b"\x03\xff\xff\xff", b"\x01\xff\x10\x00", b"\x03\xfe" + bytes(20)],
    ids=["past the end", "64 KiB", "a block that never ends", "more than there is"],
)
def test_a_tag_that_announces_more_than_it_has_cannot_be_read(area: bytes) -> None:
    storage = StorageCard(48)
    storage.put(area)
    with pytest.raises(TagError) as caught:
        CardTag(storage.transmit).read()
    assert caught.value.problem == "unreadable"


def test_a_type_4_tag_that_announces_more_than_it_has_cannot_be_read() -> None:
    tag = card()
    tag._files[0xE104][:2] = b"\xff\xff"
    with pytest.raises(TagError, match="65535 bytes"):
        CardTag(transmit_to(tag)).read()
    assert MAX_MESSAGE < 65535


def test_a_tag_without_number_is_refused() -> None:
    with pytest.raises(TagError, match="no number"):
        CardTag(lambda _apdu: (b"", 0x6A81))
    with pytest.raises(TagError, match="reading failed"):
        CardTag(lambda apdu: (bytes.fromhex(UID), 0x9000) if apdu[1] == 0xCA else (bytes(16), 0x6300)).read()
