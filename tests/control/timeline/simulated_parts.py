"""Simulated parts that obey in the ways of real devices, persons at them, and the true cause of each report.

Everything is a function of a seed; a timeline sees the reports alone.
"""

import heapq
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from operator import methodcaller
from random import Random
from typing import Literal, TypeAlias

from homebot.control.timeline.evidence import SendingPlan, next_step, outcome_of
from homebot.control.timeline.facts import Cause, CommandFact, Decided, Order, Reported, ReportRole, SendingEnded, Sent
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.outcomes import AlreadySo, Outcome
from homebot.devices.value import PlainValue

Truth: TypeAlias = Literal["command", "echo", "device", "person"]
Report: TypeAlias = tuple[float, str, PlainValue, Truth]
"""Seconds after a command, capability, value and true cause."""

_COMMANDS = 14
_TIMEOUT = 10.0
_ASKED_AFTER = 1.1


@dataclass
class Kind:
    """A kind of device.

    Attributes:
        name: Its name.
        capability: What is commanded.
        values: The values that commands and persons choose from.
        answer: Returns the reports that follow a sending, by the value before and the wanted one.
        lost: The share of the messages that get lost.
        follows: How often a person changes it within 20 s of a command.
        has_declared_echo: Whether its bridge declares its echoes.
    """

    name: str
    capability: str
    values: tuple[PlainValue, ...]
    answer: Callable[[Random, PlainValue, PlainValue], list[Report]]
    lost: float = 0.0
    follows: float = 0.25
    has_declared_echo: bool = False


@dataclass
class Result:
    """Counts over many simulated parts.

    Attributes:
        causes: How often a report with a true cause was told to have another one.
        outcomes: How often a command ended so, by whether the device obeyed.
        overridden: Repetitions over a person, by whether a message was lost.
        agreeing: Persons who did what a command wanted, which looks like its effect.
    """

    causes: Counter[tuple[Truth, Cause]] = field(default_factory=Counter)
    outcomes: Counter[tuple[str, bool]] = field(default_factory=Counter)
    overridden: Counter[bool] = field(default_factory=Counter)
    agreeing: int = 0

    def share(self, truth: Truth, causes: Iterable[Cause]) -> float:
        """Return the share of the reports with a true cause that were told to have one of *causes*."""
        total = sum(number for (one, _), number in self.causes.items() if one == truth)
        return sum(self.causes[truth, cause] for cause in causes) / max(total, 1)

    def _row(self, truth: Truth) -> str:
        return f"{truth:10}" + "".join(f"{self.causes[truth, cause]:12,}" for cause in Cause)

    def text(self) -> str:
        """Return both tables as text."""
        lines = ["truth     " + "".join(f"{cause.value:>12}" for cause in Cause)]
        lines += [self._row(truth) for truth in ("command", "echo", "device", "person")]
        for (name, is_obeyed), number in sorted(self.outcomes.items()):
            lines.append(f"{name}, {'obeyed' if is_obeyed else 'not obeyed'}: {number:,}")
        lines.append(
            f"repeated over a person: {self.overridden[False]}, {self.overridden[True]} more with lost messages"
        )
        return "\n".join(lines)


class SimulatedPart:
    """One part with its timeline, over some commands and persons."""

    def __init__(self, kind: Kind, random: Random, result: Result) -> None:
        self.kind = kind
        self.random = random
        self.result = result
        self.timeline = PartTimeline(DeviceProfile(), _TIMEOUT, 10.0)
        self.inputs: list[tuple[float, Callable[[PartTimeline], object]]] = []
        self.now = 1000.0
        self.value: PlainValue = kind.values[0]
        self.newest: tuple[PlainValue, float] | None = None
        self.touched_at = -1e9
        self.has_lost = False
        self._numbers = count()
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._generation = 0
        self._obeyed: set[int] = set()

    def run(self, commands: int = _COMMANDS) -> None:
        """Give some commands, with persons between them."""
        self._report(self.kind.capability, self.value, "person")
        for number in range(commands):
            if self.random.random() < 0.5:
                self._at(self.random.uniform(12.0, 24.0), self.touch)
            self._pass(self.random.uniform(25.0, 90.0))
            wanted = self.random.choice([one for one in self.kind.values if one != self.value] or [self.value])
            self._command(number, wanted)
        self._pass(120.0)

    def touch(self) -> None:
        """Let a person set another value."""
        self._generation += 1  # what the device had begun is over
        self.value = self.random.choice([one for one in self.kind.values if one != self.value])
        self.touched_at = self.now
        self._at(self.random.uniform(0.02, 0.3), partial(self._report, self.kind.capability, self.value, "person"))

    def _command(self, number: int, wanted: PlainValue) -> None:
        kind, capability = self.kind, self.kind.capability
        settings = {capability: wanted}
        moves = capability == "position"
        echoed = frozenset({capability}) if kind.has_declared_echo else frozenset[str]()
        order = Order(f"c-{number}", settings, settings, moves=moves, has_ramp=capability == "level", echoed=echoed)
        known = {} if self.newest is None else {capability: self.newest[0]}
        began = self.now
        self.inputs.append((began, partial(_command, order, began, known)))
        progress = self.timeline.command(order, began, known, known)
        if self.random.random() < kind.follows:
            self._at(self.random.uniform(0.5, 20.0), self.touch)
        outcome = self._carry_out(progress, began)
        is_obeyed = number in self._obeyed
        self._append(Decided(order.id, self.now, outcome))
        self.result.outcomes[type(outcome).__name__, is_obeyed] += 1

    def _carry_out(self, progress: CommandProgress, began: float) -> Outcome:
        limit, longest = self.timeline.profile.answer_time(progress.order.settings, _TIMEOUT)
        tries = 1 if self.timeline.profile.is_told_once else 3
        interval = max(limit / tries, longest + 1.5)
        lasts = max(interval * tries, 60.0 if progress.order.moves else _TIMEOUT)
        patience = self.timeline.profile.echo_patience(self.kind.capability, limit) if progress.has_echo else math.inf
        plan = SendingPlan(tries, interval, lasts, echo_patience=patience)
        if progress.was_so and self.newest is not None and self.now - self.newest[1] < 60.0 and not progress.has_echo:
            return AlreadySo(command_id=progress.order.id)
        while (step := next_step(progress, plan, self.now)).kind != "done":
            if step.kind == "send":
                self._send(progress, began)
            else:
                self._step(step.until)
        return outcome_of(progress, self.now)

    def _send(self, progress: CommandProgress, began: float) -> None:
        is_repeated = progress.transmission.attempts > 0
        self._append(Sent(progress.order.id, progress.order.settings, self.now))
        self._append(SendingEnded(progress.order.id, self.now))
        if is_repeated and self.touched_at > began:
            self.result.overridden[self.has_lost] += 1
        if not is_repeated:
            self.has_lost = False
        if self.random.random() < self.kind.lost:
            self.has_lost = True
            return
        self._generation += 1
        wanted = progress.order.settings[self.kind.capability]
        reports = self.kind.answer(self.random, self.value, wanted)
        number = int(progress.order.id[2:])
        for report in reports:
            self._at(report[0], partial(self._obey, report, self._generation, number))

    def _append(self, fact: CommandFact) -> None:
        self.inputs.append((self.now, methodcaller("append", fact)))
        self.timeline.append(fact)

    def _obey(self, report: Report, generation: int, number: int) -> None:
        _, capability, value, truth = report
        if generation != self._generation:
            return  # a person, or a newer sending, ended it
        if truth != "echo":
            self.value = value if capability == self.kind.capability else self.value
            if truth == "command":
                self._obeyed.add(number)
        self._report(capability, value, truth)

    def _report(self, capability: str, value: PlainValue, truth: Truth) -> None:
        if self.random.random() < self.kind.lost:
            self.has_lost = True
            return
        if capability == self.kind.capability:
            self.newest = value, self.now
        self.inputs.append((self.now, partial(_report, self.now, capability, value)))
        fact = self.timeline.report(self.now, self.now, capability, value)
        if fact is not None and fact.is_change:
            self._at(_ASKED_AFTER, partial(self._ask, fact, truth))

    def _ask(self, fact: Reported, truth: Truth) -> None:
        finding = fact.attribution
        if truth == "person" and finding.role is ReportRole.EFFECT:
            self.result.agreeing += 1  # nobody can tell
        else:
            self.result.causes[truth, finding.cause] += 1

    def _at(self, seconds: float, act: Callable[[], None]) -> None:
        heapq.heappush(self._events, (self.now + seconds, next(self._numbers), act))

    def _pass(self, seconds: float) -> None:
        until = self.now + seconds
        while self.now < until:
            self._step(until)

    def _step(self, until: float) -> None:
        """Let the next event happen, or time pass until then."""
        due = self._events[0][0] if self._events else until
        timer = self.timeline.next_at
        self.now = max(self.now, min(until, due, timer))
        self.timeline.advance(self.now)
        if self._events and self._events[0][0] <= self.now:
            heapq.heappop(self._events)[2]()


def _command(order: Order, at: float, known: Mapping[str, PlainValue], timeline: PartTimeline) -> None:
    timeline.command(order, at, known, known)


def _report(at: float, capability: str, value: PlainValue, timeline: PartTimeline) -> None:
    timeline.report(at, at, capability, value)
