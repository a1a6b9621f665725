"""Quarantine for peers that break the rules of a gateway: reported, counted, and read a little at a time."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from homebot.devices.health import Quarantine
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.announced.scheduler import Scheduler
from homebot.gateways.base import Gateway
from homebot.gateways.mqtt.counters import GatewayCounters
from homebot.gateways.mqtt.work_budget import CALM, WorkBudget, WorkBudgets
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.isolation import crash_of
from homebot.log import LogLimit
from homebot.messages import Time
from homebot.mqtt.message import MqttMessage

__all__ = ["PeerQuarantine"]

QUARANTINED = "gateway.quarantined"
CONVENTION_FAILED = "gateway.convention_failed"

MAX_WARNINGS = 20
"""Lines of one kind in ten seconds, each about another culprit."""

_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_LONGEST = 300
"""Characters of a topic, or of a reason, that are remembered."""


class PeerQuarantine:
    """Judges offenders, who are called by the topic that they speak on.

    Args:
        gateway: In whose name.
        reporter: Has the time.
        scheduler: Ends each quarantine.
        counters: Of the gateway.
        filters: Where devices are announced.

    Attributes:
        offenders: Their budgets.
    """

    def __init__(
        self,
        gateway: Gateway,
        reporter: DeviceReporter,
        scheduler: Scheduler,
        counters: GatewayCounters,
        filters: Iterable[str],
    ) -> None:
        self._node = gateway.node
        self._reporter = reporter
        self._scheduler = scheduler
        self._counters = counters
        self.offenders = WorkBudgets(filters)
        self._events = gateway.node.create_publisher(Quarantine, gateway.names.quarantine, _QOS)
        self._limit = LogLimit(gateway.node.graph.clock)
        self._flood_limit = LogLimit(gateway.node.graph.clock, burst=MAX_WARNINGS)

    def record_offence(self, message: MqttMessage, event: str, why: str) -> None:
        """Tell of an announcement that broke a rule, and charge it to who pays for its topic."""
        topic, why = message.topic[:_LONGEST], why[:_LONGEST]
        self.log_limited(event, f"{topic}: {why}", topic=topic)
        self.offenders.charge(message.topic, len(message.payload), f"{topic}: {why}"[:_LONGEST], self._reporter.now)

    def defer(self, payer: str) -> None:
        """Tell that what is charged to *payer* has to wait."""
        budget = self.offenders.defer(payer, self._reporter.now)
        if budget is None:
            return
        if not self._scheduler.plan(("quarantine", payer), CALM, partial(self._release, payer)):
            self.offenders.release(payer)  # it could not be told when that is over
            return
        self._counters.quarantines += 1
        self._events.publish(self._message(budget))
        self.log_limited(
            QUARANTINED,
            f"too much on {payer[:_LONGEST]} breaks the rules; it is quarantined, and read slowly, until that "
            f"stops; the last offence: {budget.why}",
            topic=payer,
        )

    def record_plugin_failure(self, topic: str, convention: str, error: BaseException) -> None:
        """Tell of an *error* that a convention let through.

        One that a stranger's message causes must not end the gateway, which would meet the same message again. As a
        convention waits for nothing, no cancellation that it lets through can be meant for the gateway.

        Raises:
            KeyboardInterrupt: *error* is one.
        """
        error = crash_of(f"the convention {convention}", error)
        self._counters.failures += 1
        self.log_limited(CONVENTION_FAILED, f"{topic[:_LONGEST]}: the convention {convention} failed", topic=topic)
        if self._limit.allows(f"{CONVENTION_FAILED} {convention}") is not None:
            self._node.log.error(
                CONVENTION_FAILED, message=f"the convention {convention} failed", topic=topic[:_LONGEST], exc_info=error
            )

    def log_limited(self, event: str, words: str, *, topic: str) -> None:
        """Tell of a culprit once in a while, and of so many culprits at most."""
        topic = topic[:_LONGEST]
        repeated = self._limit.allows(f"{event} {topic}")
        if repeated is None or (unheard := self._flood_limit.allows(event)) is None:
            return
        held_back = repeated + unheard
        more = f" (and {held_back} more like this)" if held_back else ""
        self._node.log.warning(event, message=f"{words}{more}", topic=topic, held_back=held_back)

    def quarantined(self) -> tuple[Quarantine, ...]:
        """Return who is quarantined now."""
        return tuple(self._message(budget) for budget in self.offenders.quarantined())

    def _release(self, payer: str) -> None:
        self._reporter.refresh_time()
        left = self.offenders.quiet_in(payer, self._reporter.now)
        if left > 0:
            self._scheduler.plan(("quarantine", payer), left, partial(self._release, payer))
            return
        budget = self.offenders.release(payer)
        if budget is not None:
            self._events.publish(self._message(budget).model_copy(update={"is_over": True}))
            self._events.dispose(payer[:_LONGEST])

    def _message(self, budget: WorkBudget) -> Quarantine:
        passed = self._node.graph.clock.monotonic() - budget.since
        since = self._node.graph.clock.now() - passed
        return Quarantine(
            gateway=self._node.name,
            offender=budget.name[:_LONGEST],
            why=budget.why,
            offences=budget.offences,
            since=Time.from_seconds(since),
            until=Time.from_seconds(since + budget.quiet_at - budget.since),
        )
