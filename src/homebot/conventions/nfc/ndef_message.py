"""Contents of NFC tags: NDEF messages, read and written by ndeflib. The only file that imports it.

NFC Forum: NDEF 1.0; RTD URI 1.0 (identifier codes), RTD Text 1.0, Smart Poster 1.1.
"""

import codecs
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any, Final, Literal, TypeAlias

from homebot.devices.tags import TagProblem
from homebot.errors import PeerError, WireError

NdefKind: TypeAlias = Literal["uri", "text", "media", "external"]

_MAX_RECORDS: Final = 32
_EXTERNAL: Final = "urn:nfc:ext:"
_SMART_POSTER: Final = "urn:nfc:wkt:Sp"
_WELL_KNOWN: Final = frozenset({"urn:nfc:wkt:U", "urn:nfc:wkt:T"})

MAX_MESSAGE = 8192
"""The longest NDEF message, in bytes, that homebot reads from a tag."""


class TagError(PeerError):
    """A tag that cannot be read or written.

    Attributes:
        problem: The reason, for programs.
    """

    def __init__(self, problem: TagProblem, text: str) -> None:
        super().__init__(text)
        self.problem: TagProblem = problem


@dataclass(frozen=True, slots=True)
class TagContent:
    """The content of a tag.

    Attributes:
        message: The NDEF message, not decoded; empty for none.
        capacity: The longest message that it holds, in bytes.
        is_writable: Whether it can be written.
    """

    message: bytes
    capacity: int
    is_writable: bool


@dataclass(frozen=True, slots=True)
class NdefRecord:
    """A record of a message.

    Attributes:
        kind: Whether it is a URI, a text, a document of a media type, or of an external type.
        data: The URI, the text, or the document.
        type: The media type, or the type after ``urn:nfc:ext:``, in lower case.
    """

    kind: NdefKind
    data: bytes
    type: str = ""

    def text(self) -> str:
        """Return its data as text.

        Raises:
            WireError: It is not UTF-8.
        """
        try:
            return self.data.decode()
        except UnicodeDecodeError as exc:
            raise WireError("a record of an NDEF message is not text in UTF-8", self.data) from exc


def load_ndef() -> None:
    """Load the library with the encodings that it uses, which reads files; call it in a thread, before the others."""
    _ndef()
    for name in ("latin", "idna"):  # the first use of an encoding loads its module
        codecs.lookup(name)


def read_ndef(message: bytes) -> tuple[NdefRecord, ...]:
    """Return the records of *message* that can point to something; those of other types are passed over.

    Raises:
        WireError: It is not an NDEF message, or too long, or one of too many records, or none of them can be read.
    """
    if len(message) > MAX_MESSAGE:
        raise WireError(f"an NDEF message has {len(message)} bytes; homebot reads {MAX_MESSAGE} at most")
    if not message or message in {b"\x00", b"\xd0\x00\x00"}:
        return ()
    records: list[NdefRecord] = []
    damaged: WireError | None = None
    for record in _decode(message, {}):
        try:
            records.extend(_read(record))
        except WireError as exc:
            damaged = exc
    if damaged is not None and not records:
        raise damaged
    return tuple(records)


def write_ndef(*records: NdefRecord) -> bytes:
    """Return *records* as a message."""
    ndef = _ndef()

    made = []
    for record in records:
        if record.kind == "uri":
            made.append(ndef.UriRecord(record.text()))
        elif record.kind == "text":
            made.append(ndef.TextRecord(record.text()))
        else:
            made.append(ndef.Record(f"{_EXTERNAL if record.kind == 'external' else ''}{record.type}", "", record.data))
    return b"".join(ndef.message_encoder(made))


def _decode(message: bytes, known: Mapping[str, object] | None = None) -> list[object]:
    """Return the records of *message*; those that are not of a *known* type, by default the library's, undecoded.

    Raises:
        WireError: It is not an NDEF message, or one of too many records.
    """
    ndef = _ndef()

    more = {} if known is None else {"known_types": dict(known)}
    try:
        decoded = list(islice(ndef.message_decoder(message, errors="strict", **more), _MAX_RECORDS + 1))
    except Exception as exc:  # the library lets through the errors of its parsing of a damaged message
        raise WireError(f"not an NDEF message: {exc}", message) from exc
    if len(decoded) > _MAX_RECORDS:
        raise WireError(f"an NDEF message has more than {_MAX_RECORDS} records")
    return decoded


def _read(record: object) -> Iterator[NdefRecord]:
    """Yield the records in an undecoded record; only the types that can point to something are read.

    Raises:
        WireError: It is one of these, and damaged.
    """
    ndef = _ndef()

    if not isinstance(record, ndef.Record):
        return
    kind = str(record.type)
    if kind in _WELL_KNOWN:
        yield from _well_known(record)
    elif kind == _SMART_POSTER:
        inner = [within for within in _decode(bytes(record.data), {}) if isinstance(within, ndef.Record)]
        known = [within for within in inner if str(within.type) in _WELL_KNOWN]
        for within in sorted(known, key=lambda within: str(within.type), reverse=True):  # the address, then the titles
            yield from _well_known(within)
    elif kind.startswith(_EXTERNAL):
        yield NdefRecord("external", bytes(record.data), kind.removeprefix(_EXTERNAL).casefold())
    elif "/" in kind:
        yield NdefRecord("media", bytes(record.data), kind.partition(";")[0].strip().casefold())


def _well_known(record: object) -> Iterator[NdefRecord]:
    """Yield the content of an undecoded URI or text.

    Raises:
        WireError: It is damaged.
    """
    ndef = _ndef()

    for decoded in _decode(b"".join(ndef.message_encoder([record]))):
        if isinstance(decoded, ndef.UriRecord):
            yield NdefRecord("uri", decoded.iri.encode())
        elif isinstance(decoded, ndef.TextRecord):
            yield NdefRecord("text", decoded.text.encode())


def _ndef() -> Any:
    """Return the library, which has no types."""
    import ndef  # noqa: PLC0415 - an extra

    return ndef
