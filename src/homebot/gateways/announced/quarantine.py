"""Quarantine for peers that break the rules of a gateway: they are reported, counted and read slowly."""

from collections import OrderedDict
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Generic, TypeVar

import anyio
import anyio.lowlevel

from homebot.devices.health import Quarantine
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.announced.scheduler import Scheduler
from homebot.gateways.announced.work_budget import CALM, MESSAGE_WORK, WorkBudget, WorkBudgets
from homebot.gateways.base import Gateway
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.log import LogLimit, more_like_this
from homebot.messages import Time
from homebot.support.byte_account import ByteAccount
from homebot.support.isolation import crash_of

MessageT = TypeVar("MessageT")

QUARANTINED = "gateway.quarantined"
CONVENTION_FAILED = "gateway.convention_failed"

MAX_WARNINGS = 20
"""Most log lines of one kind in ten seconds, each about another culprit."""

REFILL_EVERY = 0.1
"""Seconds between checks of the waiting messages."""

_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_MAX_CHARACTERS = 300
"""Characters kept of a source or a reason."""

MAX_BYTES = 16 * 1024 * 1024
"""Bytes of all waiting messages, including the overhead of each."""

MAX_WORK_EACH = 512 * 1024
"""Work that may wait per source: half a second of its budget."""

_OVERHEAD = 1024


@dataclass(slots=True)
class _Source(Generic[MessageT]):
    payer: str
    messages: list[tuple[MessageT, int, bool]] = field(default_factory=list)
    work: int = 0


@dataclass(slots=True)
class _Payer(Generic[MessageT]):
    sources: OrderedDict[str, _Source[MessageT]] = field(default_factory=OrderedDict)
    bytes: int = 0


class DeferredMessages(Generic[MessageT]):
    """The messages that wait for a budget: the newest of each source, in order.

    A source with too many loses first those that do not resemble its accepted messages, oldest first, so that an honest
    sender is heard among strangers that flood its topic. If there are too many in total, the budget with the most
    loses those of its least recently active source.

    Attributes:
        sources: The sources with waiting messages.
        account: Bytes of all waiting messages.
    """

    def __init__(self, max_bytes: int = MAX_BYTES) -> None:
        self.dropped = 0
        self.sources: dict[str, _Source[MessageT]] = {}
        self._payers: dict[str, _Payer[MessageT]] = {}
        self.account = ByteAccount[str](max_bytes, lambda: tuple(self._payers), self._bytes_of, self._drop_oldest)

    def add(self, message: MessageT, source: str, length: int, payer: str, *, is_like: bool) -> None:
        """Queue *message* of *length* bytes until the budget of *payer* has room.

        Args:
            is_like: Whether it resembles the accepted messages of its source.
        """
        known = self.sources.get(source)
        if known is None:
            known = self.sources[source] = _Source(payer)
        budget = self._payers.setdefault(known.payer, _Payer())
        budget.sources[source] = known
        budget.sources.move_to_end(source)
        known.messages.append((message, length, is_like))
        self._count(source, known, length, 1)
        while known.work > MAX_WORK_EACH and len(known.messages) > 1:
            unlike = next((index for index, message in enumerate(known.messages) if not message[2]), 0)
            self._pop(source, unlike)
            self.dropped += 1

    def drop(self, source: str) -> None:
        """Drop all messages of *source*."""
        while source in self.sources:
            self._pop(source)

    def release(self, admits: Callable[[str], bool]) -> Iterator[MessageT]:
        """Yield the messages that need not wait any longer, one per budget in turn, while *admits* allows.

        Messages of one source keep their order; among sources that share a budget the newest goes first, so that
        a new source is not stuck behind a flood.
        """
        is_done = False
        while not is_done:
            is_done = True
            for payer in tuple(self._payers):
                budget = self._payers.get(payer)
                if budget is not None and admits(payer):
                    is_done = False
                    yield self._pop(next(reversed(budget.sources)))

    def _pop(self, name: str, index: int = 0) -> MessageT:
        source = self.sources[name]
        message, length, _ = source.messages.pop(index)
        self._count(name, source, length, -1)
        if not source.messages:
            del self.sources[name]
            sources = self._payers[source.payer].sources
            del sources[name]
            if not sources:
                del self._payers[source.payer]
        return message

    def _count(self, name: str, source: _Source[MessageT], length: int, sign: int) -> None:
        size = sign * (_OVERHEAD + len(name) + length)
        source.work += sign * (MESSAGE_WORK + length)
        self._payers[source.payer].bytes += size
        self.account.add(size)

    def _bytes_of(self, payer: str) -> int:
        account = self._payers.get(payer)
        return 0 if account is None else account.bytes

    def _drop_oldest(self, payer: str) -> None:
        self._pop(next(iter(self._payers[payer].sources)))
        self.dropped += 1


class PeerQuarantine(Generic[MessageT]):
    """Makes the messages of peers that break the rules wait.

    A gateway asks :meth:`must_wait` before it reads a message of an unproven sender, and then reports the result to
    :meth:`WorkBudgets.accept` or :meth:`record_offence`. :meth:`serve` reads the waiting messages.
    """

    def __init__(
        self,
        gateway: Gateway,
        reporter: DeviceReporter,
        scheduler: Scheduler,
        counters: GatewayCounters,
        budgets: WorkBudgets,
        log_key: str = "source",
    ) -> None:
        self.budgets = budgets
        self.waiting: DeferredMessages[MessageT] = DeferredMessages()
        self._node = gateway.node
        self._log_key = log_key
        self._reporter = reporter
        self._scheduler = scheduler
        self._counters = counters
        self._work_available = anyio.Event()
        self._events = gateway.node.create_publisher(Quarantine, gateway.names.quarantine, _QOS)
        self._limit = LogLimit(gateway.node.graph.clock)
        self._flood_limit = LogLimit(gateway.node.graph.clock, burst=MAX_WARNINGS)

    def must_wait(self, message: MessageT, source: str, payload: bytes) -> bool:
        """Queue *message* if its source is over budget or has messages waiting; return whether it was queued."""
        now = self._reporter.now
        if now >= self.budgets.clean_at and not self.waiting.sources:
            return False
        payer = self.budgets.account_for(source)
        if source not in self.waiting.sources and self.budgets.admits(payer, now):
            return False
        self._counters.announcements_deferred += 1
        self.waiting.add(message, source, len(payload), payer, is_like=self.budgets.resembles(source, payload))
        self._work_available.set()
        self._defer(payer)
        return True

    def admits(self, source: str) -> bool:
        """Return whether to read a message of *source* that will be repeated; otherwise count it as dropped."""
        payer = self.budgets.account_for(source)
        if self.budgets.admits(payer, self._reporter.now):
            return True
        self.waiting.dropped += 1
        self._defer(payer)
        return False

    def record_offence(self, source: str, length: int, event: str, why: str) -> None:
        """Log a message of *length* bytes that broke a rule, and charge it to the payer of its source."""
        name, why = source[:_MAX_CHARACTERS], why[:_MAX_CHARACTERS]
        self.log_limited(event, f"{name}: {why}", source=name)
        self.budgets.charge(source, length, f"{name}: {why}"[:_MAX_CHARACTERS], self._reporter.now)

    async def serve(self, read_next: Callable[[Iterator[MessageT]], Awaitable[bool]]) -> None:
        """Read waiting messages whenever the budgets allow, until cancelled.

        Args:
            read_next: Reads the next message and returns True; False if none is due.
        """
        while True:
            await self._work_available.wait()
            self._work_available = anyio.Event()
            while self.waiting.sources:
                self._reporter.refresh_time()
                messages = self.waiting.release(lambda payer: self.budgets.admits(payer, self._reporter.now))
                while await read_next(messages):
                    await anyio.lowlevel.checkpoint()
                    self._reporter.refresh_time()
                await anyio.sleep(REFILL_EVERY)

    def record_plugin_failure(self, source: str, convention: str, error: BaseException) -> None:
        """Log an unexpected *error* of a convention.

        A stranger's message must not end the gateway, which would receive it again after a restart. Conventions never
        await, so a cancellation raised by one is not meant for the gateway.

        Raises:
            KeyboardInterrupt: *error* is one.
        """
        error = crash_of(f"the convention {convention}", error)
        self._counters.failures += 1
        self.log_limited(
            CONVENTION_FAILED, f"{source[:_MAX_CHARACTERS]}: the convention {convention} failed", source=source
        )
        if self._limit.allows(f"{CONVENTION_FAILED} {convention}") is not None:
            self._node.log.error(
                CONVENTION_FAILED,
                message=f"the convention {convention} failed",
                exc_info=error,
                **{self._log_key: source[:_MAX_CHARACTERS]},
            )

    def log_limited(self, event: str, words: str, source: str, about: str = "") -> None:
        """Log a warning at a limited rate: per source and what it is *about*, and in total."""
        source = source[:_MAX_CHARACTERS]
        repeated = self._limit.allows(f"{event} {source} {about[:_MAX_CHARACTERS]}")
        if repeated is None or (suppressed := self._flood_limit.allows(event)) is None:
            return
        held_back = repeated + suppressed
        facts = {self._log_key: source, "held_back": held_back}
        self._node.log.warning(event, message=f"{words}{more_like_this(held_back)}", **facts)

    def quarantined(self) -> tuple[Quarantine, ...]:
        """Return the sources in quarantine."""
        return tuple(self._message(budget) for budget in self.budgets.quarantined())

    def _defer(self, payer: str) -> None:
        """Record that a message waits for the budget of *payer*; begin its quarantine with the first."""
        budget, now = self.budgets.budget_of(payer), self._reporter.now
        if budget is None:
            return
        budget.deferred_at = now
        if budget.is_quarantined or not self._scheduler.plan(
            ("quarantine", payer), CALM, partial(self._release, payer)
        ):
            return  # without a timer its end would not be published
        budget.is_quarantined, budget.since = True, now
        self._counters.quarantines += 1
        self._events.publish(self._message(budget))
        self.log_limited(
            QUARANTINED,
            f"{payer[:_MAX_CHARACTERS]} breaks the rules too often; it is quarantined, and read slowly, until "
            f"that stops; the last offence: {budget.why}",
            source=payer,
        )

    def _release(self, payer: str) -> None:
        """End the quarantine of *payer* once it has been quiet long enough."""
        self._reporter.refresh_time()
        budget = self.budgets.budget_of(payer)
        if budget is None:
            return
        left = budget.quiet_at - self._reporter.now
        if left > 0:
            self._scheduler.plan(("quarantine", payer), left, partial(self._release, payer))
            return
        budget.is_quarantined = False
        self._events.publish(self._message(budget).model_copy(update={"is_over": True}))
        self._events.dispose(payer[:_MAX_CHARACTERS])

    def _message(self, budget: WorkBudget) -> Quarantine:
        passed = self._node.graph.clock.monotonic() - budget.since
        since = self._node.graph.clock.now() - passed
        return Quarantine(
            gateway=self._node.name,
            offender=budget.name[:_MAX_CHARACTERS],
            why=budget.why,
            offences=budget.offences,
            since=Time.from_seconds(since),
            until=Time.from_seconds(since + budget.quiet_at - budget.since),
        )
