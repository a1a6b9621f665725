"""The reader of device states: reports for the graph, texts, and reachability.

A message is the bytes on an *address* where devices publish their state; a *retained* one is of an earlier state.
"""

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from functools import partial
from typing import Any, Final, NamedTuple, final

from homebot.clock import Clock, TimeSlice
from homebot.conventions.description import AutoExpiry, begin_message
from homebot.conventions.payload import MAX_STATE_BYTES
from homebot.conventions.unreadable import FOUND
from homebot.devices import KeyValue, RawMessage
from homebot.devices.capabilities import EVENTS
from homebot.devices.text.states import encode_state
from homebot.devices.value import PlainValue, Reading, SetBy, Value
from homebot.gateways.announced.announcement import (
    AnnouncedPart,
    AvailabilityReader,
    SharedReachability,
    StoredAnnouncement,
    UnreadableCount,
)
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.announced.quarantine import PeerQuarantine
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.announced.scheduler import Scheduler
from homebot.gateways.raw_delivery import RawDelivery
from homebot.log import LogLimit
from homebot.messages import Time

_new = tuple.__new__
"""Makes a named tuple in half the time of its constructor."""

_reading_of, _value_of = Reading.of_checked, Value.of  # looked up once, as `of_checked` says


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
        is_coded = any(capability.name in _CODED for capability in described.capabilities)
        why = "; ".join(dict.fromkeys([unreadable.why(without_digits=is_coded) for unreadable in state.found]))
        name = described.name or described.id
        text = f"payloads{name and f' of {name}'} on {state.address[:100]}: {state.count}, the last {why}"
        stream, said = part.stored.report_stream("unreadable", described.id), (KeyValue(key=described.id, value=text),)
        self._reporter.publish_report(
            part.stored, (), state.address, retained=state.is_retained, stream=stream, unreadable=said
        )
        if self._hourly.allows(f"{key} {described.id}") is not None:
            words = f"{key} sends what its announcement does not explain: {text}"
            self._log(UNREADABLE, words, f"{key} {described.id}")


class StateReader:
    """The way of state messages to the graph."""

    def __init__(
        self,
        devices: Mapping[str, StoredAnnouncement],
        reporter: DeviceReporter,
        listeners: RawDelivery,
        scheduler: Scheduler,
        counters: GatewayCounters,
        quarantine: PeerQuarantine[Any],
        clock: Clock,
    ) -> None:
        self._devices = devices
        self._clock = clock
        self._reporter = reporter
        self._listeners = listeners
        self._scheduler = scheduler
        self._counters = counters
        self._record_failure = quarantine.record_plugin_failure
        self._unreadable = UnreadablePayloads(devices, reporter, scheduler, counters, quarantine.log_limited, clock)

    async def read(
        self,
        address: str,
        payload: bytes,
        announced_parts: tuple[AnnouncedPart, ...],
        availability_readers: tuple[AvailabilityReader, ...] = (),
        *,
        retained: bool,
        wait_if_full: bool = True,
        longest: int = MAX_STATE_BYTES,
    ) -> None:
        """Read a message as the state of parts and the availability of devices.

        A part that the message itself makes unavailable has no state in it: the template of EMS-ESP invents a 0.

        Args:
            payload: Its bytes; a payload longer than *longest* is only counted.
        """
        begin_message()
        work = TimeSlice(self._clock)
        if availability_readers:
            silent = await self._read_availability(address, payload, availability_readers, work, retained=retained)
            if silent:
                announced_parts = tuple(part for part in announced_parts if not _is_among(silent, part))
        if not announced_parts:
            return
        if len(payload) > longest:
            self._counters.oversize += 1
            return
        is_shared = bool(availability_readers)  # its words mean nothing to the parts
        for text in self.read_parts(address, payload, announced_parts, work, retained=retained, is_shared=is_shared):
            if text is None:
                await work.pause()
            else:
                await self._listeners.deliver(text, wait_if_full=wait_if_full)

    def read_parts(
        self,
        address: str,
        payload: bytes,
        announced_parts: Iterable[AnnouncedPart],
        work: TimeSlice | None = None,
        *,
        retained: bool,
        is_shared: bool = False,
    ) -> Iterator[RawMessage | None]:
        """Read a message as :meth:`read` does; yield None to pause when *work* is over, then the texts for listeners.

        All that one message says about a device is one report.
        """
        readings: list[Reading] = []
        texts: list[RawMessage] = []
        stored: StoredAnnouncement | None = None
        has_events = False
        listened = self._listeners.by_address
        FOUND.clear()
        for part in announced_parts:
            if work is not None and work.is_over:
                yield None
                FOUND.clear()
            described = part.described
            try:
                values = described.codec.read(address, payload, retained=retained)
                if FOUND:
                    self._unreadable.record(address, part, retained=retained, is_shared=is_shared)
                if part.sent is not None and not retained:
                    self._reporter.publish_refusal(part)
                if not values:
                    continue
                of_part = part.readings(values)
            except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
                self._record_failure(address, part.stored.described.convention, exc)
                continue
            if part.stored is not stored:
                if stored is not None:
                    self._report(stored, readings, address, retained=retained, has_events=has_events)
                stored, readings, has_events = part.stored, [], False
            readings += of_part
            for expiry in described.expiries:
                self._schedule_expiry(part, expiry, values)
            is_listened = bool(listened.get(part.address))
            if not is_listened and (part.is_plain or _is_brief(values)):
                self._record_lazy(part, values, retained)
                continue
            has_events |= not EVENTS.isdisjoint(values)
            made = self._texts_of(part, values, retained=retained)
            if is_listened:
                texts += made
        if stored is not None:
            self._report(stored, readings, address, retained=retained, has_events=has_events)
        yield from texts

    async def read_text(
        self, address: str, payload: bytes, part: AnnouncedPart, *, retained: bool, wait_if_full: bool = True
    ) -> None:
        """Read a message as the plain text that *part* publishes itself, and deliver it unchanged."""
        begin_message()
        self._counters.received += 1
        stored, now = part.stored, self._reporter.now
        if not retained:
            stored.heard_at = now
            if now >= stored.refresh_at or not stored.is_confirmed:
                self._reporter.publish_sighting(stored, "updated", f"message on {address}", confirmed=True)
        FOUND.clear()
        try:
            values = part.described.codec.read(address, payload, retained=retained)
            if FOUND:
                self._unreadable.record(address, part, retained=retained)
            readings = part.readings(values) if values else []
        except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
            self._record_failure(address, stored.described.convention, exc)
            readings = []
        if readings:
            self._counters.reports += 1
            self._reporter.publish_readings(stored, readings, address, retained=retained)
        raw = RawMessage.of_checked(
            gateway=stored.gateway,
            key=stored.key,
            address=address,
            payload=payload,
            retained=retained,
            received_at=self._reporter.stamp,
        )
        part.record(raw, now, is_event=False)
        await self._listeners.deliver(raw, wait_if_full=wait_if_full)

    async def publish(
        self, part: AnnouncedPart, values: Mapping[str, PlainValue], *, retained: bool, set_by: SetBy = ""
    ) -> None:
        """Publish *values* of a part, which its gateway has read itself and will not modify."""
        name = part.described.part.id
        readings = [
            _reading_of(part=name, capability=capability, value=_value_of(value))
            for capability, value in values.items()
        ]
        for expiry in part.described.expiries:
            self._schedule_expiry(part, expiry, values)
        is_brief = _is_brief(values)
        self._report(part.stored, readings, "", retained=retained, has_events=not is_brief, set_by=set_by)
        if is_brief and not self._listeners.by_address.get(part.address):
            self._record_lazy(part, values, retained)
            return
        for text in self._texts_of(part, values, retained=retained):
            await self._listeners.deliver(text, wait_if_full=True)

    async def _read_availability(
        self,
        address: str,
        payload: bytes,
        availability_readers: tuple[AvailabilityReader, ...],
        work: TimeSlice,
        *,
        retained: bool,
    ) -> frozenset[tuple[str, str]]:
        """Read a message as the availability of devices; return keys and parts that it makes unavailable."""
        refused: list[SharedReachability] = []
        for availability_reader in availability_readers:
            shared, index = availability_reader.reachability, availability_reader.index
            if work.is_over:
                await work.pause()
                if not shared.members:
                    continue  # removed during the pause
            said = self._read_source(shared, index, address, payload)
            if said is None:
                continue
            before = shared.value
            shared.update(index, said, retained=retained)
            shared.address = address
            if not said:
                refused.append(shared)
            if retained and shared.value is before:
                continue  # all its members have reported it already
            await self._report_members(shared, work, said=said, retained=retained)
        return frozenset(
            (stored.key, part) for shared in refused if shared.value is False for stored, part in shared.members
        )

    async def _report_members(self, shared: SharedReachability, work: TimeSlice, *, said: bool, retained: bool) -> None:
        for stored, part in tuple(shared.members):
            if work.is_over:
                await work.pause()
                if self._devices.get(stored.key) is not stored:
                    continue
            if said and not retained:
                stored.heard_at = self._reporter.now
            self._report_reachable(stored, part, shared, retained=retained)

    def report_reachability(self, stored: StoredAnnouncement) -> None:
        """Report the reachability already known from other announcements of the device of *stored*."""
        for part, shared in stored.reachability.items():
            self._report_reachable(stored, part, shared, retained=True)

    def _read_source(self, shared: SharedReachability, index: int, address: str, payload: bytes) -> bool | None:
        try:
            return shared.availability.sources[index].read(payload)
        except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
            stored, _ = shared.members[0]
            self._record_failure(address, stored.described.convention, exc)
            return None

    def _report(
        self,
        stored: StoredAnnouncement,
        readings: list[Reading],
        address: str,
        *,
        retained: bool,
        has_events: bool,
        set_by: SetBy = "",
    ) -> None:
        if self._devices.get(stored.key) is not stored:
            return  # removed during a pause
        self._counters.reports += 1
        reporter = self._reporter
        if not retained:
            stored.heard_at = reporter.now
            if reporter.now >= stored.refresh_at or not stored.is_confirmed:
                # First: a directory that has forgotten the device cannot assign a report alone.
                why = f"message on {address}" if address else "it reported"
                reporter.publish_sighting(stored, "updated", why, confirmed=True)
        if has_events:
            reporter.publish_readings(stored, readings, address, retained=retained, set_by=set_by)
        else:
            reporter.publish_report(stored, readings, address, retained=retained, set_by=set_by)
        if not retained and False in stored.reachable.values():
            # each retained "offline" that the message disproves is forgotten
            for part in {"", *(reading.part for reading in readings)}:
                if stored.reachable.get(part) is False and (shared := stored.reachability.get(part)) is not None:
                    shared.discard_retained_offline()
                    shared.address = address
                    for member, its_part in tuple(shared.members):
                        self._report_reachable(member, its_part, shared, retained=False)

    def _report_reachable(
        self, stored: StoredAnnouncement, part: str, shared: SharedReachability, *, retained: bool
    ) -> None:
        reachable = shared.value
        if reachable is stored.reachable.get(part):
            return
        stored.record_reachable(part, reachable)
        self._reporter.report_reachable(stored, part, shared.address, reachable=reachable, retained=retained)

    def _record_lazy(self, part: AnnouncedPart, values: Mapping[str, PlainValue], retained: bool) -> None:  # noqa: FBT001 - it runs for each message
        """Store *values*, and make their text on demand."""
        stored, reporter, names = part.stored, self._reporter, tuple(values)
        if names == part.names:
            names = part.names
        else:
            part.names = names
        late = stored.gateway, stored.key, part.address, names, tuple(values.values()), reporter.stamp, retained
        part.record_lazy(_new(_LateText, late), reporter.now)

    def _texts_of(
        self, announced_part: AnnouncedPart, values: Mapping[str, PlainValue], *, retained: bool
    ) -> tuple[RawMessage, ...]:
        """Record *values* as the text of a part, and return it; none if they have no text."""
        if retained:
            values = {name: value for name, value in values.items() if name not in EVENTS}
        text = encode_state(values)
        if text is None:
            return ()
        raw = RawMessage.of_checked(
            gateway=announced_part.stored.gateway,
            key=announced_part.stored.key,
            address=announced_part.address,
            payload=text.encode(),
            retained=retained,
            received_at=self._reporter.stamp,
        )
        announced_part.record(raw, self._reporter.now, is_event=not EVENTS.isdisjoint(values))
        return (raw,)

    def _schedule_expiry(
        self, announced_part: AnnouncedPart, expiry: AutoExpiry, values: Mapping[str, PlainValue]
    ) -> None:
        if expiry.capability not in values:
            return
        value = values[expiry.capability]
        name = ("expiry", announced_part.stored.key, announced_part.described.part.id, expiry.capability)
        if value == expiry.value or (expiry.only is not None and value != expiry.only):
            self._scheduler.drop(name)
        elif not self._scheduler.plan(name, expiry.after, partial(self._expire, *name[1:], expiry)):
            self._counters.expiries_dropped += 1

    def _expire(self, key: str, part: str, capability: str, expiry: AutoExpiry) -> None:
        stored = self._devices.get(key)
        announced_part = None if stored is None else stored.parts.get(part)
        if announced_part is None or expiry not in announced_part.described.expiries:
            return
        self._reporter.refresh_time()
        reading = Reading(part=part, capability=capability, value=Value.of(expiry.value))
        self._reporter.publish_report(announced_part.stored, (reading,), "", retained=False)
        for raw in self._texts_of(announced_part, {capability: expiry.value}, retained=False):
            for listener in tuple(self._listeners.by_address.get(announced_part.address, ())):
                listener.publish(raw)


def _is_among(silent: Container[tuple[str, str]], part: AnnouncedPart) -> bool:
    """Return whether *part*, or its whole device, is silent; the sensor of a lost connection is not."""
    announced = part.described.part
    return announced.tag != "connectivity" and (
        (part.stored.key, "") in silent or (part.stored.key, announced.id) in silent
    )


def _is_brief(values: Mapping[str, PlainValue]) -> bool:
    """Return whether *values* certainly have a text, and a short one: no events, and no texts among them."""
    kinds = set(map(type, values.values()))
    return kinds <= _BRIEF and (float in kinds or bool in kinds) and EVENTS.isdisjoint(values)


_BRIEF = frozenset({bool, float, tuple, type(None)})


class _LateText(NamedTuple):
    """A state with its text made on demand. Ten are kept of each part, so it is small: without a dict."""

    gateway: str
    key: str
    address: str
    names: tuple[str, ...]
    values: tuple[PlainValue, ...]
    received_at: Time
    retained: bool

    def __call__(self) -> RawMessage:
        """Return the text as a message."""
        return RawMessage.of_checked(
            gateway=self.gateway,
            key=self.key,
            address=self.address,
            payload=(encode_state(dict(zip(self.names, self.values, strict=True))) or "").encode(),
            retained=self.retained,
            received_at=self.received_at,
        )
