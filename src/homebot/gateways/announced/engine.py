"""The mechanisms that gateways of all protocols share."""

from collections.abc import Mapping
from typing import Generic, TypeVar

from homebot.devices.health import Count, HealthResponse
from homebot.errors import RefusedError, UnableError
from homebot.gateways.announced.announcement import AnnouncedPart, StoredAnnouncement
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.announced.quarantine import PeerQuarantine
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.announced.scheduler import Scheduler
from homebot.gateways.announced.state_reader import StateReader
from homebot.gateways.announced.work_budget import WorkBudgets
from homebot.gateways.base import Gateway
from homebot.gateways.raw_delivery import RawDelivery
from homebot.support.counters import Severity

MessageT = TypeVar("MessageT")

_NOT_ANNOUNCED = (
    "no announcement of it was accepted since this gateway started; "
    "restart the device or its bridge, which then announces it, or wait until it does"
)
"""For a device that the directory remembers and the network does not, as after a restart of the embedded broker."""

_OTHER_TOPICS = "it has just announced other command topics, which may be those of another device; try again"

_NOT_DESCRIBED = "it has not said what it can do since this gateway started; it may be asleep: wake it, and try again"
"""For a listed device that has not been connected yet, such as a sleepy one."""


class GatewayEngine(Generic[MessageT]):
    """The mechanisms of one gateway, for the *devices* that it keeps; their tasks are those of its node.

    Args:
        inboxes: Whether nodes get raw messages and texts in their inboxes, rather than on a topic for each device.
        budgets: The budgets of peers that break rules; by default all unknown peers share one.
    """

    def __init__(
        self,
        gateway: Gateway,
        devices: Mapping[str, StoredAnnouncement],
        *,
        stale_after: float,
        inboxes: bool,
        budgets: WorkBudgets | None = None,
        log_key: str = "source",
    ) -> None:
        node = gateway.node
        self.gateway = gateway
        self.devices = devices
        self.counters = GatewayCounters()
        self.reporter = DeviceReporter(gateway, stale_after)
        self.scheduler = Scheduler(node.graph.clock)
        self.quarantine: PeerQuarantine[MessageT] = PeerQuarantine(
            gateway, self.reporter, self.scheduler, self.counters, budgets or WorkBudgets(), log_key
        )
        self.listeners = RawDelivery(node, gateway.names, inboxes=inboxes)
        self.states = StateReader(
            devices,
            self.reporter,
            self.listeners,
            self.scheduler,
            self.counters,
            self.quarantine,
            node.graph.clock,
        )
        node.create_task(self.listeners.watch_nodes)
        node.create_task(self.scheduler.run)

    def find_part(self, key: str, part_id: str, topics: tuple[str, ...] = ()) -> AnnouncedPart:
        """Return a described part, for commands on *topics* if these are known.

        Raises:
            UnableError: No device has that key and part, or it has other topics by now.
        """
        stored = self.devices.get(key)
        if stored is None:
            why = _NOT_ANNOUNCED
        elif (part := stored.parts.get(part_id)) is not None:
            if not topics or topics == part.described.part.writes:
                return part
            why = _OTHER_TOPICS
        elif not stored.parts:
            why = _NOT_DESCRIBED
        else:
            known = ", ".join(repr(name) for name in sorted(stored.parts)[:10])
            why = f"it has no part {part_id[:100]!r}; it has {known}"
        refused = RefusedError(f"a command to {key[:100]}", why)
        raise UnableError(str(refused)) from refused

    def health(self, own: HealthResponse) -> HealthResponse:
        """Return the health report *own*, completed with the counters and quarantined sources of the engine."""
        ignored, forgotten = self.quarantine.waiting.dropped, self.quarantine.budgets.forgotten
        counts = (
            *Count.of(self.counters),
            Count(name="announcements_ignored", count=ignored, severity=Severity.FAULT),
            Count(name="offenders_dropped", count=forgotten, severity=Severity.LOSS),
        )
        quarantined = self.quarantine.quarantined()
        return own.model_copy(update={"counts": (*counts, *own.counts), "quarantined": quarantined})
