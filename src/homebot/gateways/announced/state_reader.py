"""Reads what described devices say: reports for the graph, texts, and whether a device can be reached.

A message is an *address*, on which devices say what they do, with its bytes; it is *retained* where it was kept from
before, and says what was, not what is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import anyio.lowlevel

from homebot.conventions.description import AutoExpiry, AvailabilitySource
from homebot.conventions.payload import MAX_STATE_BYTES
from homebot.devices import RawMessage
from homebot.devices.capabilities import EVENTS
from homebot.devices.gateway_messages import Reading
from homebot.devices.text.states import encode_state
from homebot.devices.value import PlainValue, Value
from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.announced.scheduler import Scheduler
from homebot.gateways.raw_delivery import RawDelivery

__all__ = ["StateReader"]

_TURN = 100
"""Readers of one message after which others get their turn."""


class StateReader:
    """The way from messages of state to the graph.

    Args:
        devices: What stands, by key.
        reporter: Where it is told.
        listeners: Who wants texts.
        scheduler: Ends values that end by themselves.
        counters: Of the gateway.
        record_failure: Told where a convention raised what it must not: the address, the convention, and the error.
    """

    def __init__(
        self,
        devices: Mapping[str, StoredAnnouncement],
        reporter: DeviceReporter,
        listeners: RawDelivery,
        scheduler: Scheduler,
        counters: GatewayCounters,
        record_failure: Callable[[str, str, BaseException], None],
    ) -> None:
        self._devices = devices
        self._reporter = reporter
        self._listeners = listeners
        self._scheduler = scheduler
        self._counters = counters
        self._record_failure = record_failure

    async def read_availability(
        self, address: str, payload: bytes, availability_readers: tuple[AvailabilityReader, ...], *, retained: bool
    ) -> None:
        """Take a message as one that tells whether devices can be reached; equal sources read it once."""
        read: dict[int, bool | None] = {}
        for number, availability_reader in enumerate(availability_readers, 1):
            if number % _TURN == 0:
                await anyio.lowlevel.checkpoint()
            stored, part = availability_reader.stored, availability_reader.part
            reachability = stored.reachability.get(part)
            if reachability is None or self._devices.get(stored.key) is not stored:
                continue
            source = reachability.availability.sources[availability_reader.index]
            if id(source) not in read:
                read[id(source)] = self._read_source(source, stored, address, payload)
            said = read[id(source)]
            if said is not None:
                reachability.hear(availability_reader.index, said, retained=retained)
                self._report_reachable(stored, part, address, retained=retained)

    async def read(
        self,
        address: str,
        payload: bytes,
        announced_parts: tuple[AnnouncedPart, ...],
        *,
        retained: bool,
        wait_if_full: bool = True,
        longest: int = MAX_STATE_BYTES,
    ) -> None:
        """Take a message as one in which parts tell their state; one that is too long is only counted.

        Args:
            address: Where it came.
            payload: Its bytes.
            announced_parts: Who speaks there, the parts of one device together.
            retained: Whether it was kept from before.
            wait_if_full: Whether to wait a moment for a full inbox.
            longest: Bytes that it may have.
        """
        if len(payload) > longest:
            self._counters.oversize += 1
            return
        readings: list[Reading] = []
        stored: StoredAnnouncement | None = None
        for number, announced_part in enumerate(announced_parts, 1):
            if number % _TURN == 0:
                await anyio.lowlevel.checkpoint()
            told = self._decode(announced_part, address, payload, retained=retained)
            if not told:
                continue
            if announced_part.stored is not stored:
                if stored is not None:
                    self._report(stored, readings, address, retained=retained)
                stored, readings = announced_part.stored, []
            readings += told[1]
            for fade in announced_part.described.expiries:
                self._plan(announced_part, fade, told[0])
            text = self._as_text(announced_part, told[0], retained=retained)
            if text is not None:
                await self._listeners.deliver(text, wait_if_full=wait_if_full)
        if stored is not None:
            self._report(stored, readings, address, retained=retained)

    async def read_text(
        self, address: str, payload: bytes, part: AnnouncedPart, *, retained: bool, wait_if_full: bool = True
    ) -> None:
        """Take a message as the text that *part* says by itself, and hand it on as it is."""
        self._counters.received += 1
        stored, now = part.stored, self._reporter.now
        if not retained and (now >= stored.refresh_at or not stored.is_confirmed):
            self._reporter.publish_sighting(stored, "updated", f"message on {address}", confirmed=True)
        told = self._decode(part, address, payload, retained=retained)
        if told is not None:
            self._counters.reports += 1
            self._reporter.publish_readings(stored, told[1], address, address, retained=retained)
        raw = RawMessage.of_checked(
            gateway=stored.gateway,
            key=stored.key,
            address=address,
            payload=payload,
            retained=retained,
            received_at=self._reporter.stamp,
        )
        part.keep(raw, now, is_event=False)
        await self._listeners.deliver(raw, wait_if_full=wait_if_full)

    async def publish(self, part: AnnouncedPart, values: Mapping[str, PlainValue], *, retained: bool) -> None:
        """Publish *values* of a part whose gateway has read them itself."""
        name = part.described.part.id
        readings = [Reading(part=name, capability=one, value=Value.of(value)) for one, value in values.items()]
        for fade in part.described.expiries:
            self._plan(part, fade, values)
        self._report(part.stored, readings, "", retained=retained, stream=name)
        text = self._as_text(part, values, retained=retained)
        if text is not None:
            await self._listeners.deliver(text, wait_if_full=True)

    def _read_source(
        self, source: AvailabilitySource, stored: StoredAnnouncement, address: str, payload: bytes
    ) -> bool | None:
        try:
            return source.read(payload)
        except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
            self._record_failure(address, stored.described.convention, exc)
            return None

    def _decode(
        self, announced_part: AnnouncedPart, address: str, payload: bytes, *, retained: bool
    ) -> tuple[Mapping[str, PlainValue], list[Reading]] | None:
        try:
            told = announced_part.described.codec.read(address, payload, retained=retained)
            if not told:
                return None
            part = announced_part.described.part.id
            return told, [
                Reading.of_checked(part=part, capability=name, value=Value.of(value))
                if str.isascii(name)
                else Reading(part=part, capability=name, value=Value.of(value))
                for name, value in told.items()
            ]
        except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
            self._record_failure(address, announced_part.stored.described.convention, exc)
            return None

    def _report(
        self, stored: StoredAnnouncement, readings: list[Reading], address: str, *, retained: bool, stream: str = ""
    ) -> None:
        if self._devices.get(stored.key) is not stored:
            return  # it went while others had their turn
        self._counters.reports += 1
        if not retained and (not stored.is_confirmed or self._reporter.now >= stored.refresh_at):
            # First: to a directory that has forgotten the device, a report alone is of nobody.
            why = f"message on {address}" if address else "it reported"
            self._reporter.publish_sighting(stored, "updated", why, confirmed=True)
        self._reporter.publish_readings(stored, readings, address or stream, address, retained=retained)
        if not retained and False in stored.reachable.values():
            self._doubt(stored, {"", *(one.part for one in readings)}, address)

    def _doubt(self, stored: StoredAnnouncement, parts: set[str], address: str) -> None:
        """Forget each "offline" that had been retained from before a message of *parts*."""
        for part in parts:
            if stored.reachable.get(part) is False and (reachability := stored.reachability.get(part)) is not None:
                reachability.doubt()
                self._report_reachable(stored, part, address, retained=False)

    def _report_reachable(self, stored: StoredAnnouncement, part: str, address: str, *, retained: bool) -> None:
        reachable = stored.reachability[part].value
        if part in stored.reachable and reachable is stored.reachable[part]:
            return
        if part not in stored.reachable and reachable is None:
            return
        stored.reachable[part] = reachable
        self._reporter.report_reachable(stored, part, address, reachable=reachable, retained=retained)

    def _as_text(
        self, announced_part: AnnouncedPart, told: Mapping[str, PlainValue], *, retained: bool
    ) -> RawMessage | None:
        if retained:
            told = {name: value for name, value in told.items() if name not in EVENTS}
        said = encode_state(told)
        if said is None:
            return None
        raw = RawMessage.of_checked(
            gateway=announced_part.stored.gateway,
            key=announced_part.stored.key,
            address=announced_part.address,
            payload=said.encode(),
            retained=retained,
            received_at=self._reporter.stamp,
        )
        announced_part.keep(raw, self._reporter.now, is_event=not EVENTS.isdisjoint(told))
        return raw

    def _plan(self, announced_part: AnnouncedPart, fade: AutoExpiry, told: Mapping[str, PlainValue]) -> None:
        if fade.capability not in told:
            return
        value = told[fade.capability]
        name = ("fade", announced_part.stored.key, announced_part.described.part.id, fade.capability)
        if value == fade.value or (fade.only is not None and value != fade.only):
            self._scheduler.drop(name)
        elif not self._scheduler.plan(name, fade.after, partial(self._expire, *name[1:], fade)):
            self._counters.fades_dropped += 1

    def _expire(self, key: str, part: str, capability: str, fade: AutoExpiry) -> None:
        stored = self._devices.get(key)
        announced_part = None if stored is None else stored.parts.get(part)
        if announced_part is None or fade not in announced_part.described.expiries:
            return
        self._reporter.refresh_time()
        reading = Reading(part=part, capability=capability, value=Value.of(fade.value))
        stream = announced_part.stored.report_stream(f"fade {part} {capability}")
        self._reporter.publish_report(announced_part.stored.key, (reading,), "", stream, retained=False)
        raw = self._as_text(announced_part, {capability: fade.value}, retained=False)
        if raw is not None:
            for listener in self._listeners.now(announced_part.address):
                listener.publish(raw)
