"""Budget for the work on messages that break the rules. Pure.

The sender of a message is known by its *source*: the address it came from or arrived on. Neither proves much: MQTT does
not name the publisher, and radio addresses are easily changed, so shutting out a sender could shut out an honest
device. The work is bounded instead: a message that breaks the rules is charged to the budget of its source if that has
a registered device, and otherwise to one that all other sources of its *group* share. While a budget is used up,
messages charged to it wait; see :mod:`homebot.gateways.announced.quarantine`.
"""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

from homebot.support.bounded_map import BoundedMap
from homebot.support.limits import RateLimit

MESSAGE_WORK = 4096
"""Work of a message in addition to its length in bytes."""

RATE = 1024 * 1024
"""Work that a budget regains per second: 256 short messages."""

BURST = 1024 * 1024
"""Most work in the budget of one source."""

SHARED_BURST = 4 * BURST
"""Most work in the budget of a group: a house that is announced at once may have many broken devices."""

TOTAL_RATE = 4 * RATE
TOTAL_BURST = 8 * BURST
"""The rate and the most work of the budget that all sources with devices also draw on."""

MAX_WAIT = 1.0
"""Most seconds for which a budget is used up, however long the last message was."""

CALM = 10.0
"""Seconds without an offence after which a source counts as clean."""

CLEAR_EVERY = 1.0
"""Seconds before a valid announcement may clear the charge of a source again: it may be a copy of the last one."""

UNKNOWN_SENDER = "unknown sender"
"""The only group of a gateway that defines none."""

MAX_BUDGETS = 1000
MAX_ACCEPTED = 50_000
_HEAD = 32


@dataclass(slots=True)
class WorkBudget:
    """The budget of a source, or of all other sources of a group, after a rule was broken.

    Attributes:
        offences: Their number since the last quiet time.
        offended_at: When a rule was broken last.
        cleared_at: When a valid announcement cleared the charge last.
        is_quarantined: Whether its messages wait.
        since: When the quarantine began.
        deferred_at: When a message was last made to wait.
        spent_at: When the budget was last used up.
    """

    name: str
    limit: RateLimit
    why: str = ""
    offences: int = 0
    offended_at: float = 0.0
    cleared_at: float = float("-inf")
    is_quarantined: bool = False
    since: float = 0.0
    deferred_at: float = 0.0
    spent_at: float = 0.0

    @property
    def quiet_at(self) -> float:
        """The end of the quarantine if nothing more arrives."""
        return max(self.deferred_at, self.spent_at) + CALM

    def charge(self, work: float, now: float) -> None:
        """Subtract *work* from the budget."""
        self.limit.charge(now, work)
        if self.limit.room(now) <= 0:
            self.spent_at = now


def _limit(rate: float, burst: float) -> RateLimit:
    return RateLimit(rate, burst, most_ahead=rate * MAX_WAIT)


def _one_group(source: str) -> str:
    del source
    return UNKNOWN_SENDER


class WorkBudgets:
    """The budgets of one gateway: for up to 1,000 sources with devices, and one for each group of others.

    Args:
        group: Returns the group of a source without a registered device. There must be few groups, whatever names
            sources choose; by default there is one.

    Attributes:
        forgotten: Offences charged only to the common budget, because too many sources have their own.
        work: Total work charged.
        clean_at: When all sources count as clean again.
    """

    def __init__(self, group: Callable[[str], str] = _one_group, max_offenders: int = MAX_BUDGETS) -> None:
        self.forgotten = 0
        self.work = 0
        self._group = group
        self._max_offenders = max_offenders
        self._accepted: BoundedMap[str, tuple[bytes, bytes]] = BoundedMap(MAX_ACCEPTED)
        self._own: OrderedDict[str, WorkBudget] = OrderedDict()
        self._shared: dict[str, WorkBudget] = {}
        self._total = _limit(TOTAL_RATE, TOTAL_BURST)
        self.clean_at = 0.0

    def account_for(self, source: str) -> str:
        """Return the payer for *source*: the source itself if it has a registered device, else its group."""
        return source if source in self._accepted else self._group(source)

    def admits(self, payer: str, now: float) -> bool:
        """Return whether the budget of *payer* has room."""
        if now >= self.clean_at:
            return True
        if payer not in self._accepted:
            budget = self._shared.get(payer)
            return budget is None or budget.limit.room(now) > 0
        if (budget := self._own.get(payer)) is None:
            # A source without offences need not wait for others, as long as its own offences would be noticed.
            return len(self._own) < self._max_offenders or self._total.room(now) > 0
        return budget.limit.room(now) > 0 and self._total.room(now) > 0

    def charge(self, source: str, length: int, why: str, now: float) -> None:
        """Charge *source* for a message of *length* bytes that broke a rule."""
        work = MESSAGE_WORK + length
        self.work += work
        self.clean_at = now + CALM
        payer = self.account_for(source)
        is_own = payer == source and payer in self._accepted
        if is_own:
            self._total.charge(now, work)
            if payer not in self._own and not self._has_room(now):
                self.forgotten += 1
                return
        if not is_own:
            budget = self._shared.setdefault(payer, WorkBudget(payer, _limit(RATE, SHARED_BURST)))
        else:
            budget = self._own.setdefault(payer, WorkBudget(payer, _limit(RATE, BURST)))
            self._own.move_to_end(payer)
        if now - budget.offended_at > CALM and not budget.is_quarantined:
            budget.offences = 0
        budget.why, budget.offended_at = why, now
        budget.offences += 1
        budget.charge(work, now)

    def accept(self, source: str, payload: bytes, now: float, *, is_valid: bool) -> None:
        """Record that *payload* from *source* registered a device; clear its charge if all of it *is_valid*."""
        # JSON up to the first key, which rarely changes.
        head, colon, _ = payload[:_HEAD].partition(b":")
        self._accepted[source] = (
            head if colon else head[:4],
            payload[-1:],
        )
        budget = self._own.get(source)
        if is_valid and budget is not None and now - budget.cleared_at >= CLEAR_EVERY:
            budget.limit, budget.cleared_at = _limit(RATE, BURST), now

    def forget(self, source: str) -> None:
        """Record that *source* no longer has a registered device."""
        self._accepted.pop(source, None)

    def resembles(self, source: str, payload: bytes) -> bool:
        """Return whether *payload* begins and ends like the last accepted payload of *source*."""
        known = self._accepted.get(source)
        return known is not None and payload.startswith(known[0]) and payload.endswith(known[1])

    def budget_of(self, payer: str) -> WorkBudget | None:
        """Return the budget of *payer*; None if it never broke a rule."""
        return self._own.get(payer) or self._shared.get(payer)

    def quarantined(self) -> tuple[WorkBudget, ...]:
        """Return the budgets in quarantine."""
        return tuple(budget for budget in (*self._own.values(), *self._shared.values()) if budget.is_quarantined)

    def _has_room(self, now: float) -> bool:
        while self._own:
            oldest = next(iter(self._own.values()))
            if now - oldest.offended_at <= CALM or oldest.is_quarantined:
                break
            del self._own[oldest.name]
        return len(self._own) < self._max_offenders
