"""Entries of the journal, and the service that reads it."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.device import KeyValue
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import Value
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt32

EntryKind: TypeAlias = Literal[
    "requested",
    "judged",
    "sent",
    "acknowledged",
    "reported",
    "outcome",
    "reverted",
    "changed",
    "published",
    "denied",
    "held",
    "released",
    "ended",
    "expired",
    "outranked",
    "handed_back",
    "would",
    "goal",
]

Finding: TypeAlias = Literal["command", "change", "event", "heard", "retained", "first", "none"]

MAX_ENTRIES = 1000
"""The largest number of entries in one answer."""

_EPOCH = Time(sec=0, nanosec=0)


class JournalFact(Message):
    """One fact behind a verdict.

    Attributes:
        name: The name, for example ``occupancy of motion/hall``.
        since: When it took that value; 0 if unknown.
    """

    name: str
    value: Value
    since: Time = _EPOCH


class JournalVerdict(Message):
    """The verdict of one policy on one command."""

    policy: str
    allowed: bool
    reason: str = ""
    facts: tuple[JournalFact, ...] = ()


class JournalEntry(Message):
    """One step of a command or of a lease, a change that no command explains, or a request that was denied.

    Attributes:
        kind: ``requested``: a command was given; ``judged``: a policy gave its verdict; ``sent``: it was handed to
            the gateway, each try is an entry; ``acknowledged``: the network accepted it; ``reported``: the device
            reported a related value; ``outcome``: its outcome became known; ``reverted``: the device went back later;
            ``changed``: the device changed, and no command explains it; ``published``: a raw text was published, by
            `Devices.tell` or by another program, unverified; ``denied``: a client of the door, or a node that wanted to
            hold a part, was refused before any command; ``held``: a holder began to hold a part;
            ``released``: the holder released it; ``ended``: the issuer, another party, ended its lease; ``expired``:
            the lease expired; ``outranked``: a hand, a stop command or, by its issuer, a person's command outranks the
            lease; ``handed_back``: it counts again;
            ``would``: in place of ``sent``, in a dry run or a replay, which send nothing; ``goal``: a robot
            drove for a goal, or homebot ended before a goal with the device, which is known at the next start.
        device: The id of the device; empty for ``denied`` if none is known.
        command: The id of the command, raw or not; empty for ``changed``, ``denied``, ``goal`` and leases.
        issuer: The issuer of the command, or the holder: the name of a node, or ``client:NAME`` for a door client.
        trigger: ``requested`` and ``published``: its cause.
        settings: ``requested``: the desired values; ``reported``, ``changed``, ``reverted``: the reported values; for a
            lease the held value.
        text: ``published``: the payload; ``sent``: empty for the first try, ``again`` for the others;
            ``acknowledged``: the gateway, for a part with several; ``denied``: the command, if known; ``held``,
            ``released``, ``ended`` and ``expired``: the holder, as a word; ``outranked``: the observation;
            ``goal``: what happened, as a clause.
        verdicts: ``judged``: the verdict; ``denied``: that of ``rights``, with the facts ``operation``, ``target``, the
            missing ``right``, the client's ``address`` and the number of requests (``count``), or that of ``lease``.
        results: ``outcome`` and ``reverted``: the outcome.
        cause: ``reported``, ``changed`` and ``reverted``: the cause of a change: ``command``, ``transition``, ``echo``,
            ``device``, ``program``, ``person``, or ``unknown``, which is the device or a person; empty if the value did
            not change.
        folded: The number of commands like the one that begins here (same issuer, part and outcome) that came in the
            minute before and are not kept.
    """

    kind: EntryKind
    at: Time
    device: str
    part: str = ""
    command: str = ""
    issuer: str = ""
    trigger: Trigger = NO_TRIGGER
    settings: tuple[Setting, ...] = ()
    text: str = ""
    verdicts: Annotated[tuple[JournalVerdict, ...], Field(max_length=1)] = ()
    results: Annotated[tuple[CommandResult, ...], Field(max_length=1)] = ()
    cause: str = ""
    folded: UInt32 = 0


class ReadJournalRequest(Message):
    """Request for the newest matching entries of the journal.

    Attributes:
        device: Only entries of the device with this id; empty for all.
        devices: Likewise of any of these, such as those of a room.
        command: Only entries of the command with this id; empty for all.
        since: Only entries at this time or later.
        until: Only entries at this time or earlier; 0 for no bound.
        limit: The largest number of entries, 1 to 1,000; 0 for 1,000.
    """

    device: str = ""
    devices: Annotated[tuple[str, ...], Field(max_length=500)] = ()
    command: str = ""
    since: Time = _EPOCH
    until: Time = _EPOCH
    limit: UInt32 = 0


class ReadJournalResponse(Message):
    """The entries, oldest first.

    Attributes:
        success: Whether the journal could be read.
        entries: The newest matching entries.
        complete: Whether these are all matching entries; otherwise older ones were left out.
        begins: The time of the oldest entry in the journal; 0 if it is empty.
        names: The names, by id, of those devices in the entries that are in the directory now; if several parts of a
            device take commands, also those of the parts, by ``ID#PART``.
    """

    success: bool = True
    message: str = ""
    entries: tuple[JournalEntry, ...] = ()
    complete: bool = True
    begins: Time = _EPOCH
    names: tuple[KeyValue, ...] = ()


class ExplainDeviceRequest(Message):
    """Request for the reason for the state of a device."""

    device: str


class DeviceFight(Message):
    """Two apps that alternately command the same part, each undoing the other's command."""

    device: str
    part: str = ""
    issuers: tuple[str, ...]
    text: str
    began: Time
    newest: Time
    commands: UInt32


class ExplainDeviceResponse(Message):
    """The last change of a device, and its causes.

    Attributes:
        success: Whether the device is known and the journal could be read.
        finding: ``command``: a command explains the change; ``change``: none does; ``event``: an event is newer, such
            as a press, which is the only entry; ``heard``: the state is unchanged since the device was first heard;
            ``retained``: a retained value, of unknown age; ``first``: the state is that of the first report; ``none``:
            it reported no change.
        changed_at: The time of the change, or of the report; 0 if there is none.
        entries: The entries of the commands that led to the change, then those of the change itself, each oldest first;
            for ``none``, those of the newest command. Entries with the same ``command`` are adjacent.
        names: As for `ReadJournal`.
        fights: The fights of apps over the device in the last hour.
        ineffective: By part, :attr:`homebot.devices.Route.name` of each route that is tried last, because its last
            commands had no effect.
        goal: The newest entry of a goal, if there was no command to the device since.
    """

    success: bool = True
    message: str = ""
    finding: Finding = "none"
    changed_at: Time = _EPOCH
    entries: tuple[JournalEntry, ...] = ()
    names: tuple[KeyValue, ...] = ()
    fights: tuple[DeviceFight, ...] = ()
    ineffective: tuple[KeyValue, ...] = ()
    goal: Annotated[tuple[JournalEntry, ...], Field(max_length=1)] = ()


class ExplainMissingStateRequest(Message):
    """Request for the reason why a device is not in a state.

    Attributes:
        state: The state, such as ``on``, ``40 %`` or ``locked``.
    """

    device: str
    state: str


class ExplainMissingStateResponse(Message):
    """The commands that asked a device for a state.

    Attributes:
        success: Whether the device is known and the journal could be read.
        is_so: Whether the device is in that state.
        problem: Why it can never be in that state, as a sentence; empty if it can.
        word: The command for the state, such as ``lock``; empty if it needs more than one word.
        entries: The entries of these commands and of denied requests, oldest command first. Entries with the same
            ``command`` are adjacent.
        begins: The time of the oldest entry in the journal; 0 if it is empty.
        names: As for `ReadJournal`.
    """

    success: bool = True
    message: str = ""
    is_so: bool = False
    problem: str = ""
    word: str = ""
    entries: tuple[JournalEntry, ...] = ()
    begins: Time = _EPOCH
    names: tuple[KeyValue, ...] = ()


class GetCausesRequest(Message):
    """Request for the causes of the values of some devices.

    Attributes:
        from_journal: Whether to look in the journal for changes that came before this homebot started.
    """

    devices: tuple[str, ...]
    from_journal: bool = False


class KnownCause(Message):
    """The cause of the newest change of a value.

    Attributes:
        value: The value since that change.
        command: The id of the command behind it; empty for none.
        issuer: Who gave that command; empty if that is not known.
        may_be_person: Whether it has to be treated as a person's action.
        cause: See :attr:`JournalEntry.cause`.
    """

    device: str
    part: str
    capability: str
    value: Value
    command: str
    may_be_person: bool
    issuer: str = ""
    cause: str = ""


class KnownCauses(ServiceAnswer):
    """The known causes; a part that has neither changed nor been commanded has none."""

    success: bool = True
    causes: tuple[KnownCause, ...] = ()


ExplainDevice = ServiceType("homebot/srv/ExplainDevice", ExplainDeviceRequest, ExplainDeviceResponse)
ExplainMissingState = ServiceType(
    "homebot/srv/ExplainMissingState", ExplainMissingStateRequest, ExplainMissingStateResponse
)
ReadJournal = ServiceType("homebot/srv/ReadJournal", ReadJournalRequest, ReadJournalResponse)
GetCauses = ServiceType("homebot/srv/GetCauses", GetCausesRequest, KnownCauses)
