"""The content of a recording: the run, the house at its start, and its events."""

import gzip
import zlib
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import IO, Final, cast

from homebot.devices import Device, RawMessage, Sighting
from homebot.devices.command_messages import CommandResult
from homebot.devices.gateway_messages import Report
from homebot.devices.places_messages import OwnerRequest
from homebot.devices.services import IndexRow
from homebot.errors import UsageError
from homebot.messages.message import Message
from homebot.recording.lines import (
    GatewayNews,
    LeaseNews,
    LostLines,
    RecordedCommand,
    RecordingEnd,
    RecordingHeader,
    RecordingLine,
    read_line,
)
from homebot.recording.repetitions import Repetitions

_MAX_LINE: Final = 16 * 1024 * 1024
_MAX_BYTES: Final = 4 * 1024**3
_MAX_RATIO: Final = 200
"""The limit of the compression ratio: for a recording it is up to 45, for zeros 1,000."""

_UNCHECKED: Final = 64 * 1024
"""Bytes of text before the ratio is checked."""

_PIECE: Final = 256 * 1024
_RANKS: Final[dict[type[Message], int]] = {GatewayNews: 0, Sighting: 1, Report: 2, RawMessage: 3}
"""The records of one gateway message, in the order of publication."""


@dataclass(frozen=True, slots=True)
class TimedCommand:
    """A command, and the time when it was given.

    Attributes:
        at: Seconds since the start of the recording.
        result: Its outcome; None for a raw text, and if the recording ended first.
        line: The number of its line; 0 without a recording.
    """

    at: float
    command: RecordedCommand
    result: CommandResult | None = None
    line: int = 0


@dataclass(frozen=True, slots=True)
class RecordedEvent:
    """A message of a gateway, or a request of the owner to the directory.

    Attributes:
        at: Seconds since the start of the recording.
    """

    at: float
    message: Message
    line: int


@dataclass(slots=True)
class Recording:
    """The content of a recording.

    Attributes:
        index: The rows of the directory's index at the start.
        devices: The devices by id, each in its state at the start or when it first appeared, in this order.
        before: Messages of gateways before the start: their states, then sightings, reports and raw messages.
        events: Their messages during the recording, and the owner's requests, in order of time.
        commands: The commands, in order of time.
        leases: Steps of leases with their times; those at the start have time 0.
        ends_at: When it ends, in seconds since the start.
        end: The reason of its end, as text; empty for a normal end.
        is_whole: Whether it has an end; without one, the recorder was killed.
    """

    header: RecordingHeader
    index: list[IndexRow] = field(default_factory=list)
    devices: dict[str, Device] = field(default_factory=dict)
    before: list[Message] = field(default_factory=list)
    events: list[RecordedEvent] = field(default_factory=list)
    commands: list[TimedCommand] = field(default_factory=list)
    leases: list[tuple[float, LeaseNews]] = field(default_factory=list)
    lost: int = 0
    ends_at: float = 0.0
    end: str = ""
    is_whole: bool = False

    @property
    def gateways(self) -> tuple[str, ...]:
        """The names of all gateways, sorted."""
        messages = chain(self.before, (event.message for event in self.events))
        names = {str(getattr(message, "gateway", "")) for message in messages} - {""}
        names |= {endpoint.gateway for device in self.devices.values() for endpoint in device.endpoints}
        return tuple(sorted(names))


def load_recording(path: Path) -> Recording:
    """Read the file *path*; a name with ``.gz`` means compressed.

    Raises:
        UsageError: It cannot be read, or a line is wrong; the message names the line and the field.
    """
    try:
        if path.suffix == ".gz":
            _check_ratio(path)
        with _open(path) as file:
            return read_recording(_lines(file, str(path)), str(path))
    except gzip.BadGzipFile as exc:
        raise UsageError(f"{path} is damaged, or not compressed, and its name ends in .gz") from exc
    except zlib.error as exc:
        raise UsageError(f"{path} is damaged: {exc}") from exc
    except OSError as exc:
        raise UsageError(f"{path} cannot be read: {exc.strerror or exc}") from exc


def read_recording(lines: Iterable[bytes], source: str) -> Recording:
    """Parse *lines* as a recording.

    Args:
        lines: Its lines, with or without line breaks.

    Raises:
        UsageError: A line is wrong; the message names *source*, the line and the field.
    """
    recording: Recording | None = None
    results: dict[str, CommandResult] = {}
    repetitions = Repetitions()
    is_over = False
    for number, text in enumerate(lines, 1):
        where = f"{source}, line {number}"
        if number == 1 and b'"recording"' not in text:
            raise UsageError(f"{source} is not a recording: its first line is no header; `homebot record` makes one")
        line = _whole_line(text, repetitions, where)
        if recording is None:
            if not isinstance(line.message, RecordingHeader):
                raise UsageError(f"{where}: field 'kind': the first line of a recording is its header, 'recording'")
            recording = Recording(line.message)
            continue
        if is_over:
            raise UsageError(f"{where}: comes after the end of the recording")
        if isinstance(line.message, RecordingHeader):
            raise UsageError(f"{where}: field 'kind': a recording has one header, in its first line")
        is_over = isinstance(line.message, RecordingEnd)
        if isinstance(line.message, CommandResult):
            results[line.message.command_id] = line.message
        else:
            _add_line(recording, line, number)
    if recording is None:
        raise UsageError(f"{source} is empty, and not a recording")
    recording.commands = [replace(command, result=results.get(command.command.id)) for command in recording.commands]
    # the order of one moment stays, because effects follow their causes
    recording.before.sort(key=lambda one: _RANKS.get(type(one), len(_RANKS)))
    recording.events.sort(key=lambda event: event.at)
    recording.commands.sort(key=lambda one: one.at)
    recording.leases.sort(key=lambda lease: lease[0])
    return recording


def _whole_line(text: bytes, repetitions: Repetitions, where: str) -> RecordingLine:
    try:
        line = read_line(text)
        return replace(line, message=repetitions.whole(line.message))
    except UsageError as exc:
        raise UsageError(f"{where}: {exc}") from exc


def _add_line(recording: Recording, line: RecordingLine, number: int) -> None:
    recording.ends_at = max(recording.ends_at, line.at)
    match line.message:
        case Device() as device:
            recording.devices.setdefault(device.id, device)
        case IndexRow() as row:
            recording.index.append(row)
        case LeaseNews() as news:
            recording.leases.append((max(0.0, line.at), news))
        case RecordedCommand() as command:
            recording.commands.append(TimedCommand(line.at, command, line=number))
        case LostLines(count=count):
            recording.lost += count
        case RecordingEnd(reason=reason):
            recording.end, recording.is_whole = reason, True
        case message if line.at <= 0 and not isinstance(message, OwnerRequest):
            recording.before.append(message)
        case _:
            recording.events.append(RecordedEvent(line.at, line.message, number))


def _open(path: Path) -> IO[bytes]:
    return cast("IO[bytes]", gzip.open(path)) if path.suffix == ".gz" else path.open("rb")


def _check_ratio(path: Path) -> None:
    """Refuse a compressed file that expands far more than a recording, before its lines are read."""
    size = 0
    with path.open("rb") as packed, gzip.GzipFile(fileobj=packed) as unpacked, suppress(EOFError):
        while piece := unpacked.read1(_PIECE):
            size += len(piece)
            if size > _UNCHECKED + _MAX_RATIO * packed.tell():
                raise UsageError(f"{path} is not a recording: it unpacks to more than {_MAX_RATIO} times its size")


def _lines(file: IO[bytes], source: str) -> Iterator[bytes]:
    """Yield lines of limited length, from a limited amount of text: a small file may unpack to a huge one."""
    size, count = 0, 0
    while line := _read_line(file, source, count):
        size += len(line)
        if len(line) > _MAX_LINE or size > _MAX_BYTES:
            raise UsageError(f"{source} is too large: a line has at most 16 MiB, and all lines have 4 GiB")
        if not line.endswith(b"\n") and count:
            raise _cut_off(source, count)
        count += 1
        yield line


def _read_line(file: IO[bytes], source: str, count: int) -> bytes:
    try:
        return file.readline(_MAX_LINE + 1)
    except EOFError as exc:
        raise _cut_off(source, count) from exc


def _cut_off(source: str, count: int) -> UsageError:
    reader = "zcat" if source.endswith(".gz") else "cat"
    return UsageError(
        f"{source} ends in the middle of a line: the copy is incomplete, or homebot was killed while it wrote; "
        f"`{reader} {source} | head -n {count} > whole.jsonl` keeps the complete lines"
    )
