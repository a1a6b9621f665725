"""Damaged NDEF messages, codes and tags: refused in our words, or understood."""

import json
from contextlib import suppress

from tests.fuzz.conftest import Fuzz, Mutator
from tests.simulated.nfc.type4_card import Type4Card

from homebot.conventions.nfc.card_tag import CardTag
from homebot.conventions.nfc.ndef_message import NdefRecord, TagError, read_ndef, write_ndef
from homebot.conventions.nfc.pointer import pointer_of_code, pointer_of_records
from homebot.errors import WireError

THING = json.dumps(
    {
        "@context": "https://www.w3.org/2022/wot/td/v1.1",
        "id": "urn:dev:lamp:1",
        "title": "Lamp",
        "securityDefinitions": {"nosec": {"scheme": "nosec"}},
        "security": ["nosec"],
    }
)
MESSAGES = [
    write_ndef(NdefRecord("uri", b"homebot:device/lights/a"), NdefRecord("text", "Küche\narea: Bad".encode())),
    write_ndef(NdefRecord("uri", b"http://10.0.0.7:80/.well-known/wot")),
    write_ndef(NdefRecord("media", THING.encode(), "application/td+json")),
    write_ndef(NdefRecord("external", b'{"device": "lights/a", "area": "Bad"}', "homebot:device")),
]
CODES = [
    "homebot:device/a%20b",
    "MT:Y.K90AFN00KA0648G00",
    "X-HM://0023ISYWYABCD",
    "mqtt://b/home/a",
    "http://[::1]/",
    THING,
]
MOST_STEPS = 3 * 8192
"""APDUs that a tag may cost: it may give one byte each, and is read, written and found."""


def test_damaged_messages_are_refused_or_read(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("nfc messages"):
        message = mutate.damaged_bytes(rng.choice(MESSAGES))
        with suppress(WireError):
            pointer_of_records(read_ndef(message))


def test_damaged_codes_are_refused_or_read(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("nfc codes"):
        code = mutate.damaged_bytes(rng.choice(CODES).encode()).decode(errors="replace")
        with suppress(WireError):
            pointer_of_code(code)


def test_tags_that_answer_what_they_like_cost_a_bounded_number_of_steps(fuzz: Fuzz) -> None:
    for mutator, _ in fuzz("nfc tags"):
        card = LyingCard(mutator)
        with suppress(TagError):
            tag = CardTag(card.transmit)
            tag.read()
            tag.write(b"\xd0\x00\x00")
        assert card.asked < MOST_STEPS


class LyingCard:
    def __init__(self, mutator: Mutator) -> None:
        self.asked = 0
        self._mutator = mutator
        self._card = Type4Card(bytes.fromhex("04a1b2c3d4e5f6"), mutator.rng.choice(MESSAGES))

    def transmit(self, apdu: bytes) -> tuple[bytes, int]:
        self.asked += 1
        answer = self._card.answer(apdu)
        data = self._mutator.damaged_bytes(answer[:-2]) if self._mutator.rng.random() < 0.1 else answer[:-2]
        return data, int.from_bytes(answer[-2:], "big")
