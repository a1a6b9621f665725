"""Pointers: how a tag or a code refers to a device. Pure.

homebot writes a URI ``homebot:device/ID`` and a text with the name of the device; a line ``area: ROOM`` in it is the
room of the tag. It also reads any other URI, a text with the id, the name or an identifier of a device, a Thing
Description, and a record of the external type ``homebot:device`` (``urn:nfc:ext:homebot:device``), which is a JSON
object of ``device``, ``name`` and ``area``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final
from urllib.parse import quote, unquote, urlsplit

from homebot.conventions.described_thing import DescribedThing, read_thing
from homebot.conventions.ecosystem import SetupCode, read_setup_code
from homebot.conventions.nfc.ndef_message import NdefRecord
from homebot.conventions.payload import clean_text, parse_object
from homebot.errors import WireError

_DEVICE: Final = "homebot:device/"
_EXTERNAL: Final = "homebot:device"
_THING: Final = "application/td+json"
_MAX_CODE: Final = 4096
_MAX_TEXT: Final = 500
_AREA = re.compile(r"\s*(?:area|room)\s*[:=]\s*(.+)", re.IGNORECASE)
_SCHEME = re.compile(r"[a-z][a-z0-9+.-]*:", re.IGNORECASE)
_URLS: Final = frozenset({"http", "https", "coap", "coaps", "coap+tcp", "coaps+tcp", "ws", "wss"})


@dataclass(frozen=True, slots=True)
class Pointer:
    """A reference to a device, by one or more of these attributes.

    Attributes:
        kind: The kind of code; see :class:`homebot.devices.tags.ScanCodeResponse`.
        text: The reference in words; empty if there is none.
        id: The id of the device in the directory.
        words: Texts that may be its id, its name, or an identifier.
        address: The topic on which it publishes, or a level above that topic.
        urls: Addresses of the device, or of its description.
        thing: Its Thing Description.
        codes: Its setup codes.
        area: The room that is named.
        problems: Texts about records that are invalid.
    """

    kind: str = "text"
    text: str = ""
    id: str = ""
    words: tuple[str, ...] = ()
    address: str = ""
    urls: tuple[str, ...] = ()
    thing: DescribedThing | None = None
    codes: tuple[SetupCode, ...] = ()
    area: str = ""
    problems: tuple[str, ...] = field(default=(), compare=False)

    @property
    def facts(self) -> Mapping[str, str]:
        """Further facts in the code, without secrets."""
        return self.codes[0].facts if self.codes else {}

    def joined(self, other: Pointer) -> Pointer:
        """Return both in one; where they differ, this one counts."""
        if not (self.text or self.area):
            return replace(other, problems=(*self.problems, *other.problems))
        return Pointer(
            kind=self.kind if self.text else other.kind,
            words=(*self.words, *other.words),
            urls=(*self.urls, *other.urls),
            codes=(*self.codes, *other.codes),
            problems=(*self.problems, *other.problems),
            **{name: getattr(self, name) or getattr(other, name) for name in _SINGLE},
        )


_SINGLE: Final = ("text", "id", "address", "thing", "area")


def pointer_of_device(device: str) -> Pointer:
    """Return a pointer to the device of this id or name."""
    return Pointer(text=device, words=(device,))


def pointer_of_code(text: str) -> Pointer:
    """Return the pointer in the text of a code.

    Raises:
        WireError: The text is empty, too long or invalid.
    """
    code = text.strip()
    if not code or len(code) > _MAX_CODE:
        raise WireError("the code is empty" if not code else f"the code has {len(code)} characters")
    if code.startswith("{"):
        return _of_thing(code.encode())
    return _of_uri(code) if _SCHEME.match(code) else _of_text(code)


def pointer_of_records(records: Iterable[NdefRecord]) -> Pointer:
    """Return the pointer in all records of a tag together; invalid records are among its problems."""
    whole = Pointer()
    for record in records:
        try:
            said = _of_record(record)
        except WireError as exc:
            said = Pointer(problems=(str(exc),))
        whole = whole.joined(said)
    return whole


def records_for(device: str, name: str, area: str = "") -> tuple[NdefRecord, ...]:
    """Return the records of a tag that points to *device*."""
    records = [NdefRecord("uri", f"{_DEVICE}{quote(device, safe='/')}".encode()), NdefRecord("text", name.encode())]
    if area:
        records[1] = NdefRecord("text", f"{name}\narea: {area}".encode())
    return tuple(records)


def _of_record(record: NdefRecord) -> Pointer:
    if record.kind == "uri":
        return _of_uri(record.text())
    if record.kind == "text":
        return _of_text(record.text())
    if record.kind == "external" and record.type == _EXTERNAL:
        return _of_external(record)
    if record.kind == "media" and record.type == _THING:
        return _of_thing(record.data)
    return Pointer()


def _of_uri(uri: str) -> Pointer:
    if not uri.isprintable() or len(uri) > _MAX_CODE:
        raise WireError("a URI has unprintable characters, or is too long", uri.encode())
    if (code := read_setup_code(uri)) is not None:
        return Pointer(code.kind, code.text, codes=(code,))
    if uri.lower().startswith(_DEVICE):
        device = unquote(uri[len(_DEVICE) :])
        if not device or not device.isprintable() or len(device) > _MAX_TEXT:
            raise WireError("the URI homebot:device/ names no device", uri.encode())
        return Pointer("homebot", device, id=device)
    try:
        parts = urlsplit(uri)
        _ = parts.port
    except ValueError as exc:
        raise WireError(f"a URI is invalid: {exc}", uri.encode()) from exc
    shown = clean_text(uri, 200)
    if parts.scheme in {"mqtt", "mqtts"}:
        topic = unquote(parts.path).strip("/")
        return Pointer("mqtt", shown, address=topic) if topic else Pointer("mqtt", shown)
    if parts.scheme in _URLS and parts.hostname:
        bare = parts._replace(netloc=parts.netloc.rpartition("@")[2])  # a login in it is a secret
        return Pointer("url", clean_text(bare.geturl(), 200), urls=(bare.geturl(),))
    return Pointer("text", shown, words=(uri[:_MAX_TEXT],))


def _of_text(text: str) -> Pointer:
    lines = [line.strip() for line in text[:_MAX_CODE].splitlines() if line.strip()]
    area = next((clean_text(match[1], 100) for line in lines if (match := _AREA.fullmatch(line))), "")
    words = tuple(clean_text(line, _MAX_TEXT) for line in lines if not _AREA.fullmatch(line))[:4]
    return Pointer("text", words[0] if words else "", words=words, area=area)


def _of_external(record: NdefRecord) -> Pointer:
    text = record.text()
    if not text.lstrip().startswith("{"):
        return replace(_of_text(text), kind="homebot")
    said = parse_object(record.data)
    texts = {key: clean_text(value, _MAX_TEXT) for key, value in said.items() if isinstance(value, str)}
    device, name = texts.get("device", ""), texts.get("name", "")
    return Pointer(
        "homebot", device or name, id=device, words=(name,) if name else (), area=texts.get("area", "")[:100]
    )


def _of_thing(document: bytes) -> Pointer:
    thing = read_thing(parse_object(document))
    return Pointer("thing", thing.title, thing=thing, area=thing.area[:100])
