"""The record of payloads that a part cannot read: counted, reported, and logged once an hour."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final, final

from homebot.clock import Clock
from homebot.conventions.unreadable import FOUND
from homebot.devices import KeyValue
from homebot.gateways.announced.announcement import AnnouncedPart, StoredAnnouncement, UnreadableCount
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.announced.scheduler import Scheduler
from homebot.log import LogLimit

UNREADABLE: Final = "gateway.payload_unreadable"
MAX_AT_ONCE: Final = 10
"""Most payloads of a part that are reported when they come; of further ones the last is, once a second."""

_SECOND: Final = 1.0
_HOUR: Final = 3600.0
_CODED: Final = frozenset({"alarm", "lock"})  # may be sent the digits of a person's code


@final
class UnreadablePayloads:
    """Counts the unreadable payloads of each part, and reports the last one with the reason.

    Args:
        log: Logs an event, words, and their source at a limited rate.
    """

    def __init__(
        self,
        devices: Mapping[str, StoredAnnouncement],
        reporter: DeviceReporter,
        scheduler: Scheduler,
        counters: GatewayCounters,
        log: Callable[[str, str, str], None],
        clock: Clock,
    ) -> None:
        self._devices = devices
        self._reporter = reporter
        self._scheduler = scheduler
        self._counters = counters
        self._log = log
        self._hourly = LogLimit(clock, _HOUR)

    def record(self, address: str, part: AnnouncedPart, *, retained: bool, is_shared: bool = False) -> None:
        """Record what *part* could not read in a message on *address*, unless it is for others too; empty ``FOUND``."""
        values = tuple(FOUND)
        FOUND.clear()
        if is_shared:
            return
        state = part.unreadable
        if state is None:
            state = part.unreadable = UnreadableCount()
        elif retained and state.found == values:
            return  # the same message, read again
        state.count += 1
        state.found, state.address, state.is_retained = values, address, retained
        self._counters.payloads_unreadable += 1
        wait = state.report_at - self._reporter.now
        if state.count <= MAX_AT_ONCE or wait <= 0.0:
            self._report(part, state)
        elif state.reported == state.count - 1:  # the first since the last report
            key, part_id = part.stored.key, part.described.part.id
            self._scheduler.plan(("unreadable", key, part_id), wait, partial(self._report_late, key, part_id))

    def _report_late(self, key: str, part_id: str) -> None:
        stored = self._devices.get(key)
        part = None if stored is None else stored.parts.get(part_id)
        if part is not None and (state := part.unreadable) is not None and state.reported < state.count:
            self._reporter.refresh_time()
            self._report(part, state)

    def _report(self, part: AnnouncedPart, state: UnreadableCount) -> None:
        described, key = part.described.part, part.stored.key
        state.reported, state.report_at = state.count, self._reporter.now + _SECOND
        is_coded = any(one.name in _CODED for one in described.capabilities)
        why = "; ".join(dict.fromkeys([one.why(without_digits=is_coded) for one in state.found]))
        name = described.name or described.id
        text = f"payloads{name and f' of {name}'} on {state.address[:100]}: {state.count}, the last {why}"
        stream, said = part.stored.report_stream("unreadable", described.id), (KeyValue(key=described.id, value=text),)
        self._reporter.publish_report(
            part.stored, (), state.address, retained=state.is_retained, stream=stream, unreadable=said
        )
        if self._hourly.allows(f"{key} {described.id}") is not None:
            words = f"{key} sends what its announcement does not explain: {text}"
            self._log(UNREADABLE, words, f"{key} {described.id}")
