"""Damaged NDEF messages and codes: refused in our words, or understood."""

import json
from contextlib import suppress

from tests.fuzz.conftest import Fuzz

from homebot.conventions.nfc.ndef_message import NdefRecord, read_ndef, write_ndef
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
