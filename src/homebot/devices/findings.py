"""Findings of ``homebot doctor``, each of a kind with a stable code and a next step."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from enum import Enum
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeAlias

from homebot.messages.message import Message, UInt32

if TYPE_CHECKING:
    from homebot.devices.device import Device
    from homebot.devices.query.terms import Query

MAX_SHOWN: Final = 20
"""The limit of rows of a finding."""

ShownUrgency: TypeAlias = Literal["", "danger", "attention", "later"]

Row: TypeAlias = tuple[str, str]
"""The fields of a :class:`FindingRow`."""


class FindingRow(Message):
    """One item of a finding.

    Attributes:
        what: Its name, such as that of a device; empty if the finding has only a reason.
    """

    what: str
    why: str


class Finding(Message):
    """Items of one kind.

    Attributes:
        where: The part of homebot, such as ``gateway/mqtt``.
        total: How many there are, if more than *rows*.
        next: The next step; empty if the reason names it.
        hint: How to see the others.
        urgency: Of an alert: ``danger`` to people or the house; ``attention`` today; ``later``; otherwise empty.
    """

    code: str
    is_problem: bool
    title: str
    where: str
    total: UInt32
    rows: tuple[FindingRow, ...]
    next: str
    hint: str = ""
    urgency: ShownUrgency = ""


class Findings(Message):
    """The present alerts of the house, the worst first.

    Attributes:
        repeats: Whether people are told of one again and again, until a call of ``/alerts/seen``.
    """

    findings: tuple[Finding, ...]
    repeats: bool = False


class FindingKind(Enum):
    """The table of all kinds, the worst first; a code is never reused.

    Attributes:
        title: With ``{}`` for the part of homebot; empty if the reason says everything.
        next_step: The next step; empty if the reason names it.
        is_problem: Whether it is a problem rather than a note.
    """

    SMOKE = "HB421", "smoke or heat", "is there a fire? get out, and call the fire brigade"
    CO = "HB422", "carbon monoxide", "open windows, get out, and call for help"
    GAS = "HB423", "gas", "no flame and no switch; open windows, get out, and call for help"
    LEAK = "HB424", "leak", "turn the water off"
    ALARM = "HB425", "alarm", "homebot why DEVICE shows the reports"
    CONFIGURATION = "HB101", "wrong configuration", "correct it, then: homebot config check"
    EXTRA = "HB102", "missing library", ""
    FOLDER = "HB103", "folder for data", "make it yours, or name another one in HOMEBOT_DATA"
    FILE = "HB104", "kept file", "install the newer homebot again, or: homebot restore BACKUP"
    PORT = "HB105", "port", "if homebot is already running, ask it: homebot doctor"
    NETWORK = "HB107", "not reachable", ""
    GATEWAY = "HB302", "", ""
    SILENT_GATEWAY = "HB301", "", "wait a minute, then see homebot's log"
    TROUBLE = "HB201", "problem of {}", ""
    GIVEN_UP = "HB202", "given up by {}", "fix it as the log says: homebot app reload APP, homebot gateway restart NAME"
    TAMPER = "HB426", "tampering", "is its case open, or is it off the wall?"
    PROBLEM = "HB427", "problem", "homebot show DEVICE"
    DOOR = "HB428", "open for long", "close it"
    UNREACHABLE = "HB402", "unreachable", "battery, power, range?"
    STALE = "HB401", "stale", "battery, power, range? if it is gone for good: homebot forget DEVICE"
    DISPUTED = "HB403", "disputed", "homebot show DEVICE shows both sides; homebot forget DEVICE ends it"
    BATTERY = "HB404", "weak battery", "change or charge it"
    FAILURE = "HB203", "failures in {} since it started", "the log has each with its traceback: report or fix it"
    LOSS = "HB204", "counted by {} in the last ten minutes", "the log and homebot journal tell more"
    QUARANTINE = "HB205", "quarantined by {}, which reads only some of their messages", "fix or remove the sender"
    UNREADABLE = "HB407", "sends what its announcement does not explain", "correct the device or its announcement"
    SECRET = "HB106", "secret", "", False
    NOTE = "HB206", "note on {}", "", False
    COUNT = "HB207", "counted by {} since it started", "", False
    NAMES = (
        "HB408",
        "several names for one identifier: perhaps several devices",
        "give each device an identifier of its own in its announcements; meanwhile its parts have these names",
        False,
    )
    NO_ROOM = "HB405", "without room", "homebot place DEVICE ROOM", False
    VACUUM = "HB409", "vacuums that are no robots yet", "add the table, and restart homebot: docs/robots.md", False
    NO_GATEWAY = "HB406", "found, and not used yet", "restart homebot after a new table: docs/protocols.md", False

    def __init__(self, code: str, title: str, next_step: str, is_problem: bool = True) -> None:  # noqa: FBT001, FBT002 - a row
        self.code = code
        self.title = title
        self.next_step = next_step
        self.is_problem = is_problem

    def finding(self, rows: Sequence[Row], where: str = "", total: int = 0) -> Finding:
        """Return the finding with *rows*, and with a larger *total* if there are more."""
        return Finding(
            code=self.code,
            is_problem=self.is_problem,
            title=self.title.format(where),
            where=where,
            total=max(total, len(rows)),
            rows=tuple(FindingRow(what=what, why=why) for what, why in rows),
            next=self.next_step,
        )


class DeviceCheck(NamedTuple):
    """A question of the doctor about all devices.

    Attributes:
        query: The query for them, as text.
        reasons: Returns the reasons why a device is shown, at a time in seconds since the Unix epoch.
        most: How many are shown: a whole house takes long to carry.
        asked: The query that is asked, if it leaves out more than *query*.
    """

    kind: FindingKind
    query: str
    reasons: Callable[[Device, float], Iterable[str]]
    most: int = MAX_SHOWN
    asked: Query | None = None
