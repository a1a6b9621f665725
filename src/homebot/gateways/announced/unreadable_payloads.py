"""The record of payloads that a part cannot read: counted, reported, and logged once an hour."""

import re
from collections.abc import Callable
from typing import Final, final

from homebot.clock import Clock
from homebot.conventions.unreadable import FOUND, Unreadable
from homebot.devices import KeyValue
from homebot.gateways.announced.announcement import AnnouncedPart
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.log import LogLimit

__all__ = ["UnreadablePayloads"]

UNREADABLE: Final = "gateway.payload_unreadable"
_HOUR: Final = 3600.0
_DIGITS: Final = re.compile("[0-9]")
_CODED: Final = frozenset({"alarm", "lock"})  # may be sent the digits of a person's code


@final
class UnreadablePayloads:
    """Counts the unreadable payloads of each part, and reports the last one with the reason.

    Args:
        log: Logs an event, words, and their source at a limited rate.
    """

    def __init__(
        self, reporter: DeviceReporter, counters: GatewayCounters, log: Callable[[str, str, str], None], clock: Clock
    ) -> None:
        self._reporter = reporter
        self._counters = counters
        self._log = log
        self._hourly = LogLimit(clock, _HOUR)

    def record(self, address: str, part: AnnouncedPart, *, retained: bool, is_shared: bool = False) -> None:
        """Record what *part* could not read in a message on *address*, unless it is for others too; empty ``FOUND``."""
        if is_shared:
            FOUND.clear()
            return
        described, key = part.described.part, part.stored.key
        is_coded = any(one.name in _CODED for one in described.capabilities)
        why = "; ".join(dict.fromkeys(map(_why_without_digits, FOUND) if is_coded else (one.why for one in FOUND)))
        FOUND.clear()
        count, before = part.unreadable
        if retained and before == why:
            return  # the same message, read again
        part.unreadable = count + 1, why
        self._counters.payloads_unreadable += 1
        name = described.name or described.id
        text = f"payloads{name and f' of {name}'} on {address[:100]}: {count + 1}, the last {why}"
        stream, said = part.stored.report_stream("unreadable", described.id), (KeyValue(key=described.id, value=text),)
        self._reporter.publish_report(part.stored, (), address, retained=retained, stream=stream, unreadable=said)
        if self._hourly.allows(f"{key} {described.id}") is not None:
            words = f"{key} sends what its announcement does not explain: {text}"
            self._log(UNREADABLE, words, f"{key} {described.id}")


def _why_without_digits(found: Unreadable) -> str:
    return found._replace(value=_DIGITS.sub("#", found.value)).why
