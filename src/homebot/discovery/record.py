"""Devices and tombstones as rows of the index file, and back. Pure."""

import json
import math
from typing import NamedTuple, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from homebot.devices import Sighting
from homebot.discovery.entry import Entry, ReportInterval
from homebot.discovery.ids import Tombstone
from homebot.discovery.merging.part_ids import PartPlace
from homebot.discovery.merging.trust import MAX_TRUSTED
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.errors import InvalidNameError, WireError
from homebot.messages import Time
from homebot.names import validate_node_name

MAX_RECORD = 4_000_000
"""Most characters of one record; longer ones are not read."""


class Records(NamedTuple):
    """Rows of the index file: id and record."""

    devices: tuple[tuple[str, str], ...] = ()
    tombstones: tuple[tuple[str, str], ...] = ()
    owner: tuple[tuple[str, str], ...] = ()


class _SavedSource(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    sighting: Sighting
    first_seen: Time
    part_ids: dict[str, str] = {}


class _EntryRecord(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    first_seen: Time
    gaps: tuple[float, ...] = ()
    claims: tuple[_SavedSource, ...]
    trusted: tuple[tuple[str, str], ...] = ()


class _TombstoneRecord(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    keys: tuple[tuple[str, str], ...]
    hardware: tuple[str, ...] = ()
    is_ghost: bool
    at: float
    trusted: tuple[tuple[str, str], ...] = ()
    first_seen: float = 0.0


_RecordT = TypeVar("_RecordT", bound=BaseModel)


def entry_record(entry: Entry) -> str:
    """Return the record of a device, without values, which would be outdated.

    Raises:
        WireError: A text in it has a lone surrogate, which cannot be stored.
    """
    ids: dict[SourceKey, dict[str, str]] = {}
    for (gateway, key, part), part_id in entry.part_ids().items():
        if part_id != part:
            ids.setdefault((gateway, key), {})[part] = part_id
    saved = tuple(
        _SavedSource(
            sighting=_as_last_seen(source),
            first_seen=source.first_seen,
            part_ids=ids.get(source.key, {}),
        )
        for source in entry.sources.values()
    )
    try:
        entry.id.encode()
        return _EntryRecord(
            first_seen=entry.first_seen,
            gaps=entry.report_interval.gaps,
            claims=saved,
            trusted=tuple(sorted(entry.trusted)),
        ).model_dump_json()
    except ValueError as exc:
        raise WireError(f"{entry.id[:100]!r} cannot be stored: {exc}", b"") from exc


def read_entry(device_id: str, text: str) -> Entry:
    """Return the device of a record, not confirmed.

    Raises:
        WireError: It is invalid.
    """
    record = _read(_EntryRecord, text)
    gaps = [gap for gap in record.gaps if math.isfinite(gap) and gap > 0]
    sources: dict[SourceKey, SourceRecord] = {}
    ids: dict[PartPlace, str] = {}
    for number, claim in enumerate(record.claims):
        sighting = claim.sighting
        try:
            validate_node_name(sighting.gateway)
        except InvalidNameError as exc:
            raise WireError(f"a device of no gateway: {exc}", text[:100].encode(errors="replace")) from exc
        sources[sighting.gateway, sighting.key] = SourceRecord(
            sighting=sighting,
            number=number,
            first_seen=claim.first_seen,
            seen_at=sighting.seen_at,
            confirmed=False,
        )
        ids |= {
            (sighting.gateway, sighting.key, part.id): claim.part_ids.get(part.id, part.id) for part in sighting.parts
        }
    if not device_id or not sources:
        raise WireError("a device without an id or an announcement", text[:100].encode(errors="replace"))
    return Entry(
        device_id,
        record.first_seen,
        "unconfirmed",
        sources,
        report_interval=ReportInterval.of(gaps),
        known_ids=ids,
        trusted=frozenset(record.trusted[:MAX_TRUSTED]),
    )


def tombstone_record(tombstone: Tombstone) -> str:
    """Return the record of a removed device."""
    return json.dumps(
        {
            "keys": tombstone.keys,
            "hardware": tombstone.hardware,
            "is_ghost": tombstone.retained_only,
            "at": tombstone.at,
            "trusted": tombstone.trusted,
            "first_seen": tombstone.first_seen,
        }
    )


def read_tombstone(device_id: str, text: str) -> Tombstone:
    """Return the removed device of a record.

    Raises:
        WireError: It is invalid.
    """
    record = _read(_TombstoneRecord, text)
    if not (math.isfinite(record.at) and math.isfinite(record.first_seen)):
        raise WireError("a device that went at no time", text[:100].encode(errors="replace"))
    trusted = record.trusted[:MAX_TRUSTED]
    return Tombstone(
        device_id, record.keys, record.hardware, record.is_ghost, record.at, trusted, record.first_seen or record.at
    )


def _as_last_seen(source: SourceRecord) -> Sighting:
    """Return the sighting with its stored allowance of silence, as the clock may have been set since."""
    expires_at = Time.from_seconds(source.seen_at.to_seconds() + source.lasts)
    return source.sighting.model_copy(update={"seen_at": source.seen_at, "expires_at": expires_at, "confirmed": False})


def _read(kind: type[_RecordT], text: str) -> _RecordT:
    if len(text) > MAX_RECORD:
        raise WireError(f"a record of {len(text):,} characters", b"")
    try:
        return kind.model_validate_json(text)
    except ValidationError as exc:
        raise WireError(f"no record: {exc.errors()[0]['msg']}", text[:100].encode(errors="replace")) from exc
