"""Lines of a recording, each a JSON object ``{"at": …, "kind": …, "message": {…}}``. Pure.

*at* is in seconds since the start of the recording, negative for earlier reports. *kind* is the kind of the message,
which is JSON as in rosbridge. Lines are in the order of recording; readers sort them by time, keeping the order of
lines of one moment.

==============  ================================  ==============================================================
kind            message                           meaning
==============  ================================  ==============================================================
``recording``   :class:`RecordingHeader`          the first line, and only that
``index``       :class:`IndexRow`                 a row of the directory's index at the start
``device``      :class:`homebot.devices.Device`   a device in the directory at the start, or when it appeared
``gateway``     :class:`GatewayNews`              a gateway went online or offline
``sighting``    :class:`Sighting`                 a gateway sighted a device
``report``      :class:`Report`                   a device reported values, or an event such as a press
``again``       :class:`Repetition`               a repetition of the last sighting or report of its source
``raw``         :class:`RawMessage`               a raw message of a device
``command``     :class:`RecordedCommand`          a command was given
``outcome``     :class:`CommandResult`            the outcome of a command
``owner``       :class:`OwnerRequest`             the owner, or a tag, placed, named, tagged, approved … a device
``lease``       :class:`LeaseNews`                a lease began or ended
``lost``        :class:`LostLines`                lines are missing here
``end``         :class:`RecordingEnd`             the last line; missing if the recorder was killed
==============  ================================  ==============================================================
"""

import json
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

from homebot.devices import Device, RawMessage, Sighting
from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.gateway_messages import GatewayState, Report
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.places_messages import OwnerRequest
from homebot.devices.services import IndexRow
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.errors import TypeMismatchError, UsageError
from homebot.messages import Time
from homebot.messages.json import message_from_json, message_to_text
from homebot.messages.message import Message, UInt32
from homebot.recording.repetitions import Repetition
from homebot.recording.secrets import without_secrets
from homebot.support.bounded_map import BoundedMap
from homebot.support.strict_json import parse_strict

FORMAT: Final = 2
"""The version of the format; a reader refuses a newer one. Format 1 lacked the kinds index, owner and lease."""

_MAX_LENGTH_S: Final = 366 * 86_400.0
_EARLIEST: Final = -100 * 366 * 86_400.0
"""Reports of a computer with an unset clock, such as a starting Raspberry Pi, are from 1970."""

_SHOWN: Final = 60

_MAX_COMMANDS: Final = 1_000
"""The limit of known commands: the entries about one text are close together."""


class RecordedApp(Message):
    """An app that ran.

    Attributes:
        kind: Its class, as ``module:Class``.
        settings: Its table, as the text of a JSON object, without secrets.
    """

    name: str
    kind: str
    settings: str = "{}"


class RecordingHeader(Message):
    """The run of a recording.

    Attributes:
        trusts_apps: Whether apps may command always-ask devices without a grant, as in a simulated house.
        control: The table ``[control]``, as the text of a JSON object.
        places: The table ``[places]``, as the text of a places file; empty for none.
        detected: The motion sensors that had detected motion before, if there is a presence guard.
        home_table: The table ``[home]`` without the name, as the text of a JSON object.
    """

    format: UInt32
    version: str
    home: str
    started_at: Time
    trusts_apps: bool = False
    control: str = "{}"
    places: str = ""
    detected: tuple[str, ...] = ()
    apps: tuple[RecordedApp, ...] = ()
    home_table: str = "{}"


class GatewayNews(Message):
    """The state of a gateway."""

    gateway: str
    state: GatewayState


class RecordedCommand(Message):
    """A given command.

    Attributes:
        issuer: The issuer: the name of a node, or ``client:NAME`` for a client of the door.
        settings: The wanted values; empty for a raw text that another program published.
        text: A raw text, which is neither checked nor verified; empty for any other command.
    """

    id: str
    issuer: str
    device: str
    part: str = ""
    settings: tuple[Setting, ...] = ()
    text: str = ""
    trigger: Trigger = NO_TRIGGER


RecordedLeaseStep: TypeAlias = Literal["held", "released", "ended", "expired"]


class LeaseNews(Message):
    """A step of a lease.

    Attributes:
        step: ``held``: *by* began to hold the part, or held it when the recording began; ``released``: *by* released
        it; ``ended``: *issuer* ended the leases of the device; ``expired``: the lease of *by* expired.
        issuer: The holder: the name of a node, or ``client:NAME`` for a client of the door.
        by: The holder, as a word.
    """

    step: RecordedLeaseStep
    device: str
    part: str = ""
    setting: Setting
    issuer: str
    by: str = ""


class LostLines(Message):
    """Lines that came too fast, or were too many, to be written."""

    count: UInt32


class RecordingEnd(Message):
    """The end of a recording."""

    reason: str = ""


@dataclass(frozen=True, slots=True)
class RecordingLine:
    """One line.

    Attributes:
        at: Seconds since the start of the recording.
    """

    at: float
    message: Message


_KINDS: Final[dict[str, type[Message]]] = {
    "recording": RecordingHeader,
    "index": IndexRow,
    "device": Device,
    "gateway": GatewayNews,
    "sighting": Sighting,
    "report": Report,
    "again": Repetition,
    "raw": RawMessage,
    "command": RecordedCommand,
    "outcome": CommandResult,
    "owner": OwnerRequest,
    "lease": LeaseNews,
    "lost": LostLines,
    "end": RecordingEnd,
}
_NAMES: Final = {message_type: kind for kind, message_type in _KINDS.items()}


def line_text(line: RecordingLine) -> str:
    """Return *line* as ASCII text, without a line break."""
    return f'{{"at":{line.at:.6f},"kind":"{_NAMES[type(line.message)]}","message":{message_to_text(line.message)}}}'


def read_line(text: str | bytes) -> RecordingLine:
    """Parse *text* as a line.

    Raises:
        UsageError: It is not a valid line; the message names the field.
    """
    record = _parse(text)
    if not isinstance(record, dict) or not record.keys() >= {"at", "kind", "message"}:
        raise UsageError("must be a JSON object with the fields 'at', 'kind' and 'message'")
    at, kind, message = record["at"], record["kind"], record["message"]
    if isinstance(at, bool) or not isinstance(at, int | float) or not _EARLIEST <= at <= _MAX_LENGTH_S:
        raise UsageError(f"field 'at': must be a number of seconds within 366 days, got {str(at)[:_SHOWN]!r}")
    message_type = _KINDS.get(kind) if isinstance(kind, str) else None
    if message_type is None:
        raise UsageError(f"field 'kind': must be one of {', '.join(_KINDS)}, got {str(kind)[:_SHOWN]!r}")
    if message_type is RecordingHeader:
        # a newer format is refused before the rest of its header is read, which may differ
        version = message.get("format") if isinstance(message, dict) else None
        if type(version) is int and version > FORMAT:
            problem = f"is {version}, but this homebot reads up to {FORMAT}: replay it with a newer homebot"
            raise UsageError(f"field 'message.format': {problem}")
    try:
        return RecordingLine(float(at), message_from_json(message_type, message, ignore_unknown=True))
    except TypeMismatchError as exc:
        raise UsageError(f"field 'message': {exc}") from exc


def _parse(text: str | bytes) -> object:
    try:
        return parse_strict(text)
    except UnicodeDecodeError as exc:
        raise UsageError("is not UTF-8 text") from exc
    except json.JSONDecodeError as exc:
        raise UsageError(f"is not JSON: {exc.msg} at character {exc.pos + 1}") from exc
    except (ValueError, RecursionError) as exc:
        raise UsageError(f"is not JSON: {str(exc)[:_SHOWN]}") from exc


@final
class CommandNews:
    """Reads commands, their outcomes and leases from the journal.

    A text of an app appears there first as the parsed command, and then as published.
    """

    def __init__(self) -> None:
        self._requested: BoundedMap[str, None] = BoundedMap(_MAX_COMMANDS)

    def of(self, entry: JournalEntry) -> RecordedCommand | CommandResult | LeaseNews | None:
        """Return the command, outcome or lease step in *entry*; None for other entries."""
        match entry.kind:
            case "requested":
                self._requested[entry.command] = None
                return _command(entry)
            case "published" if entry.command not in self._requested:
                return _command(entry)
            case "outcome":
                return entry.results[0]
            case "held" | "released" | "ended" | "expired" as step:
                return LeaseNews(
                    step=step,
                    device=entry.device,
                    part=entry.part,
                    setting=entry.settings[0],
                    issuer=entry.issuer,
                    by=entry.text,
                )
        return None


def _command(entry: JournalEntry) -> RecordedCommand:
    return RecordedCommand(
        id=entry.command,
        issuer=entry.issuer,
        device=entry.device,
        part=entry.part,
        settings=entry.settings,
        text=without_secrets(entry.text.encode()).decode(errors="replace"),
        trigger=entry.trigger,
    )
