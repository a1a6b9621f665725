"""Facts of a part: orders, what became of them, their sendings, and reports, each with its monotonic time. Pure."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Final, NamedTuple, TypeAlias, final

from homebot.control import durations
from homebot.devices.capabilities import acts_each_time
from homebot.devices.outcomes import Outcome
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue, SetBy


class Nothing(Enum):
    """The absence of a value, since None is a value."""

    NOTHING = "nothing"


NOTHING: Final = Nothing.NOTHING

PartRef: TypeAlias = tuple[str, str]
"""The ids of a device and of one of its parts."""


class ReportRole(Enum):
    """Meaning of a report for one command.

    ``EFFECT``: the wanted value. ``ECHO``: the wanted value, repeated by a bridge. ``STEP``: a value on the way.
    ``DEVIATES``: a position farther away than the one before, or beyond the wanted one. ``UNDONE``: another value after
    the wanted one. ``REPEAT``: the same other value again. ``UNRELATED``: another value. ``MATCHES``: a value of
    another capability that is consistent with the command. ``SIDE_EFFECT``: any other value.
    """

    EFFECT = "effect"
    ECHO = "echo"
    STEP = "step"
    DEVIATES = "astray"
    UNDONE = "undone"
    REPEAT = "repeat"
    UNRELATED = "otherwise"
    MATCHES = "agrees"
    SIDE_EFFECT = "aside"


class Cause(Enum):
    """Cause of a report.

    ``COMMAND``: the effect of a command. ``TRANSITION``: a step on the way. ``ECHO``: a bridge repeated a command.
    ``DEVICE``: the device by itself. ``PROGRAM``: another program, by its regular changes: it outranks apps as a person
    does, but nobody is there. ``PERSON``: a person, or an unknown program. ``UNKNOWN``: a person or the device.
    """

    COMMAND = "command"
    TRANSITION = "transition"
    ECHO = "echo"
    DEVICE = "device"
    PROGRAM = "program"
    PERSON = "person"
    UNKNOWN = "unknown"


class Attribution(NamedTuple):
    """Cause of a report.

    Attributes:
        command: The id of the command that caused the report, or whose effect it ended; empty for none.
        role: The role of the report for that command; None without one, and for a command to another part.
        is_foreign: Whether a command that was given past homebot caused it: it counts as a person's action.
        was_absent: Whether the device was unreachable before: it is no hand for leases.
    """

    cause: Cause
    command: str = ""
    role: ReportRole | None = None
    is_foreign: bool = False
    was_absent: bool = False

    @property
    def may_be_person(self) -> bool:
        """True if it has to be treated as a person's action, to be safe."""
        return self.is_foreign or self.cause is Cause.PERSON or self.cause is Cause.UNKNOWN

    @property
    def is_hand(self) -> bool:
        """True if it outranks apps and leases: a person, or another program."""
        return (self.may_be_person or self.cause is Cause.PROGRAM) and not self.was_absent


NOT_JUDGED: Final = Attribution(Cause.UNKNOWN)


@dataclass(slots=True, eq=False)
class Order:
    """Wanted state of a part according to one command.

    Attributes:
        wanted: The values that the part should report; empty if it reports none of them.
        transition: Seconds that the change takes.
        is_told_once: Whether it is sent once: a second sending might undo it.
        opens_further: Whether it opens a part that is already open, but not fully.
        turns_on: Whether it turns on a part that reports "off", without a setting that says so.
        has_ramp: Whether the part has a level that can be set.
        is_foreign: Whether another program gave it past homebot: it counts as a person's action.
        trigger: What led to it.
    """

    id: str
    settings: Mapping[str, PlainValue]
    wanted: Mapping[str, PlainValue]
    transition: float = 0.0
    moves: bool = False
    is_told_once: bool = False
    opens_further: bool = False
    turns_on: bool = False
    has_ramp: bool = False
    is_foreign: bool = False
    echoed: frozenset[str] = frozenset()
    place: PartRef = ("", "")
    issuer: str = ""
    label: str = ""
    trigger: Trigger = NO_TRIGGER

    @property
    def is_always_sent(self) -> bool:
        """True for a stop, a press, or the latch of an unlocked door: no report can show that it is unnecessary."""
        return acts_each_time(self.settings)


class Sent(NamedTuple):
    """One sending of a command begins; *at* is in seconds."""

    command: str
    settings: Mapping[str, PlainValue]
    at: float


class SendingEnded(NamedTuple):
    """The gateway took the settings, refused them, or got no acknowledgement in time.

    Attributes:
        routes: The routes that accepted settings, in order, if the part has several.
        is_shared: Whether a message to a group, or a scene, took its place.
    """

    command: str
    at: float
    routes: tuple[str, ...] = ()
    is_unacknowledged: bool = False
    is_shared: bool = False


class Withheld(NamedTuple):
    """A policy kept back a repetition."""

    command: str
    at: float


class Asked(NamedTuple):
    """The part, or the members of a group, were asked for their values before a repetition.

    Attributes:
        can_answer: Whether one of them takes such a request.
    """

    command: str
    at: float
    can_answer: bool


class LinkLost(NamedTuple):
    """The gateway lost its connection at that time, while the command waited for an answer."""

    command: str
    at: float


class Answered(NamedTuple):
    """The device or its network accepted a setting, or refused it with a *problem*."""

    command: str
    at: float
    capability: str
    problem: str = ""


class Decided(NamedTuple):
    """The outcome of a command is known."""

    command: str
    at: float
    outcome: Outcome


CommandFact: TypeAlias = Sent | SendingEnded | Withheld | Asked | LinkLost | Answered | Decided


@dataclass(slots=True, eq=False)
class Reported:
    """A live report of one value.

    Attributes:
        at: Seconds.
        stamp: The time of the message, in seconds since the Unix epoch.
        previous: The previous live value; None if there was none.
        since: When the previous value came, in seconds.
        seen_at: When it was last reported; inf for never.
        is_after_loss: Whether the connection was lost since the previous value.
        along: The id of the command to a part near this one that it may belong to; empty for none.
        is_usual: Whether the part usually changes along with such a command.
        timed: How often the previous value lasted as long the last times; three times come from a timer.
        was_kept: Whether the part usually keeps the previous value, which a command brought.
        was_absent: Whether the device was unreachable since the previous value.
        is_news: Whether it repeats the value of a device that reports only changes: it changed twice in between.
        set_by: Who set it past homebot, if the gateway knows that.
        by_program: *program* if it is a regular change of one, *unknown* if it may be; None for others.
        drifted_from: The command whose confirmed number it still fits; empty for none.
        attribution: Its cause and role, judged when it arrived; all else reads this column.
        is_change: Whether the value is known to have been different before: a lamp that is off has no colour.
    """

    at: float
    stamp: float
    number: int
    capability: str
    value: PlainValue
    previous: PlainValue = None
    since: float = -math.inf
    seen_at: float = math.inf
    is_first: bool = False
    is_after_loss: bool = False
    along: str = ""
    is_usual: bool = False
    timed: int = 0
    was_kept: bool = False
    was_absent: bool = False
    is_news: bool = False
    set_by: SetBy = ""
    by_program: Cause | None = None
    drifted_from: str = ""
    attribution: Attribution = NOT_JUDGED

    is_change: bool = field(init=False)

    def __post_init__(self) -> None:
        self.is_change = self.previous is not None and self.value is not None and self.value != self.previous


@final
class GroupMessage:
    """Message to a group, whose bridge then reports it at once for the group and all members, without hearing them.

    Args:
        echoed: The capabilities that it reports so.
    """

    __slots__ = ("_echoed_at", "echoed")

    def __init__(self, echoed: frozenset[str] = frozenset()) -> None:
        self.echoed = echoed
        self._echoed_at: dict[str, float] = {}

    def is_echo(self, capability: str, at: float, sent_at: float) -> bool:
        """Return whether a report of the wanted value, by the group or a member, may be the bridge's."""
        if capability not in self.echoed:
            return False
        if self._echoed_at.get(capability, -math.inf) < sent_at:
            self._echoed_at[capability] = at
        return at - self._echoed_at[capability] <= durations.FAST


NO_GROUP: Final = GroupMessage()


@final
class Transmission:
    """The sendings of one command so far.

    Attributes:
        attempts: The number of sendings that ended, including withheld ones.
        count: The number of sendings that began.
        first_sent_at: When the first sending began; when the command was given, before.
        sent_at: The same of the last sending.
        told_at: When the first sending to this part alone began; None if the first of all was one.
        began: When the first sending ended, since a gateway may have had to connect first; -inf before.
        asked_at: When the last attempt ended; -inf before.
        asked_after: The number of attempts after which the part was last asked for its values.
        can_be_asked: Whether it takes such a request, as far as is known.
        lost_at: When the connection was last lost, or did not answer; -inf for never.
        is_unacknowledged: Whether the network did not acknowledge the last sending in time.
        accepted: When the device or its network first accepted each setting.
        refusal: The reason why the device refuses the command; empty if it does not.
        routes: The routes that accepted settings, in order, if the part has several.
        group: The message to a group that took the place of the first sending, or of all.
    """

    attempts = count = asked_after = 0
    can_be_asked = True
    told_at: float | None = None
    began = asked_at = lost_at = -math.inf
    is_unacknowledged = _is_shared = False
    refusal = ""
    routes: tuple[str, ...] = ()
    group = NO_GROUP

    def __init__(self, given_at: float) -> None:
        self.first_sent_at = self.sent_at = given_at
        self.accepted: dict[str, float] = {}

    def apply(self, fact: CommandFact) -> None:
        """Add the next fact."""
        if isinstance(fact, Sent):
            self.sent_at = fact.at
            self.first_sent_at = fact.at if self.count == 0 else self.first_sent_at
            self.told_at = fact.at if self.count == 1 and self._is_shared else self.told_at
            self.count += 1
            self.is_unacknowledged = False
        elif isinstance(fact, SendingEnded | Withheld):
            self.attempts += 1
            self.asked_at = fact.at
            if isinstance(fact, SendingEnded):
                self.routes += fact.routes
                self._is_shared = fact.is_shared
                self.is_unacknowledged = fact.is_unacknowledged
                self.lost_at = fact.at if fact.is_unacknowledged else self.lost_at
            if self.attempts == 1:
                self.began = self.sent_at if self.is_unacknowledged else fact.at
        elif isinstance(fact, Asked):
            self.asked_after, self.can_be_asked = self.attempts, fact.can_answer
        elif isinstance(fact, LinkLost):
            self.lost_at = max(self.lost_at, fact.at)
        elif isinstance(fact, Answered):
            if fact.problem:
                self.refusal = self.refusal or fact.problem
            else:
                self.accepted.setdefault(fact.capability, fact.at)
