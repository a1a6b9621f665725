"""The publisher of a gateway's messages about devices."""

from collections.abc import Sequence
from functools import cached_property, lru_cache
from operator import attrgetter

from homebot.devices import KeyValue
from homebot.devices.capabilities import EVENTS
from homebot.devices.gateway_messages import REACHABLE, CommandAnswer, Report
from homebot.devices.services import NEVER
from homebot.devices.value import Reading, SetBy, Value
from homebot.gateways.announced.announcement import AnnouncedPart, SightingKind, StoredAnnouncement
from homebot.gateways.base import Gateway
from homebot.graph import Publisher
from homebot.messages import Time

REFRESH = 1.0
"""Seconds between two sightings of a talkative device; the precision of `last_seen`."""

_EVENTS = 1000
"""Unread events of one gateway that a reader may have; it loses older ones, and counts them."""

_LAST = NEVER.to_seconds()

_value_name = attrgetter("part", "capability")
_report_of, _stamp_of = Report.of_checked, Time.from_seconds  # looked up once, as `of_checked` says


class DeviceReporter:
    """Publishes sightings and reports of one gateway, all with the time of the last :meth:`refresh_time`.

    Attributes:
        now: Reading of the monotonic clock.
    """

    def __init__(self, gateway: Gateway, stale_after: float) -> None:
        self._gateway = gateway
        self._gateway_name = gateway.node.name
        self._clock = gateway.node.graph.clock
        self._stale_after = stale_after
        self._events = 0
        self._reports = gateway.reports
        self.refresh_time()

    def refresh_time(self) -> None:
        """Read the clocks."""
        self._seconds = max(0.0, min(self._clock.now(), _LAST - self._stale_after))
        self.now = self._clock.monotonic()
        self.stamp = _stamp_of(self._seconds)
        self._until = 0.0, self.stamp

    def publish_sighting(self, device: StoredAnnouncement, kind: SightingKind, why: str, *, confirmed: bool) -> None:
        """Publish that a device has appeared, is still there, or is gone."""
        device.refresh_at = self.now + REFRESH
        device.is_confirmed = confirmed
        stale_after = device.described.stale_after or self._stale_after
        if stale_after != self._until[0]:  # the same for nearly all devices
            self._until = stale_after, Time.from_seconds(min(self._seconds + stale_after, _LAST))
        device.template = device.template.model_copy(
            update={
                "kind": kind,
                "why": why,
                "confirmed": confirmed,
                "seen_at": self.stamp,
                "expires_at": self._until[1],
                "heard_at": self.now,
            }
        )
        self._gateway.publish_sighting(device.template)

    def publish_report(
        self,
        device: StoredAnnouncement,
        readings: Sequence[Reading],
        address: str,
        *,
        retained: bool,
        stream: str = "",
        unreadable: tuple[KeyValue, ...] = (),
        set_by: SetBy = "",
    ) -> None:
        """Publish a report of a device, by default in the stream for these values on *address*."""
        if not stream:
            source = address, *map(_value_name, readings)
            stream = device.report_streams.get(source) or device.report_stream(*source)
        self._reports.publish(
            _report_of(
                gateway=self._gateway_name,
                key=device.key,
                readings=tuple(readings),
                address=address,
                stream=stream,
                retained=retained,
                received_at=self.stamp,
                heard_at=self.now,
                unreadable=unreadable,
                set_by=set_by,
            )
        )

    @cached_property
    def _answers(self) -> Publisher[CommandAnswer]:
        return self._gateway.node.create_publisher(CommandAnswer, self._gateway.names.answers, _EVENTS)

    def publish_refusal(self, part: AnnouncedPart) -> None:
        """Publish that the device refuses the last command of *part*, if its last report says so."""
        if part.sent is None or part.described.refusal is None:
            return
        command, messages = part.sent
        if why := part.described.refusal(messages):
            part.sent = None
            self._answers.publish(CommandAnswer.to(command, self._gateway_name, why))

    def publish_readings(
        self,
        device: StoredAnnouncement,
        readings: Sequence[Reading],
        address: str,
        *,
        retained: bool,
        set_by: SetBy = "",
    ) -> None:
        """Publish states and events that a device reported; a *retained* event is over, and dropped.

        Args:
            address: The address of the message; empty if the protocol has none.
            retained: Whether the message is of an earlier time.
        """
        states = tuple([reading for reading in readings if reading.capability not in EVENTS])
        if states:
            self.publish_report(device, states, address, retained=retained, set_by=set_by)
        if len(states) < len(readings) and not retained:
            events = tuple([reading for reading in readings if reading.capability in EVENTS])
            self._events = (self._events + 1) % _EVENTS
            stream = f"event {self._events}"  # nothing replaces it, and no late joiner gets it
            self.publish_report(device, events, address, retained=False, stream=stream)
            self._reports.dispose(stream)

    def report_reachable(
        self, device: StoredAnnouncement, part: str, address: str, *, reachable: bool | None, retained: bool
    ) -> None:
        """Publish whether a device or a part is reachable, by *address*; empty if it no longer reports that."""
        stream = device.report_stream(REACHABLE, part)
        self.publish_report(device, (_reachable(part, reachable),), address, retained=retained, stream=stream)

    def dispose_all(self, device: StoredAnnouncement) -> None:
        """Stop keeping reports of a device for late joiners."""
        for stream in device.report_streams.values():
            self._reports.dispose(stream)
        device.report_streams.clear()

    def dispose_left(self, device: StoredAnnouncement, before: StoredAnnouncement) -> None:
        """Stop keeping reports on addresses that *before* read and *device* does not: they have no source any more."""
        reads = {address for part in device.parts.values() for address in part.described.part.reads}
        left = {address for part in before.parts.values() for address in part.described.part.reads} - reads
        for source in [stream for stream in device.report_streams if stream[0] in left]:
            self._reports.dispose(device.report_streams.pop(source))


@lru_cache(maxsize=256)  # a bridge that comes or goes makes the same report for each device
def _reachable(part: str, reachable: bool | None) -> Reading:  # noqa: FBT001 - the value itself
    return Reading(part=part, capability=REACHABLE, value=Value.of(reachable))
