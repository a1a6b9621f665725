"""Reads what described devices say: reports for the graph, plain words, and whether a device can be reached."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import anyio.lowlevel

from homebot.conventions.description import AutoExpiry, AvailabilitySource
from homebot.conventions.payload import MAX_STATE_BYTES
from homebot.devices import RawMessage
from homebot.devices.capabilities import EVENTS
from homebot.devices.report import Reading
from homebot.devices.text.encode import encode_state
from homebot.devices.value import PlainValue, Value
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.announced.quarantine import PeerQuarantine
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.announced.scheduler import Scheduler
from homebot.gateways.mqtt.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.raw_delivery import RawDelivery
from homebot.mqtt.message import MqttMessage

__all__ = ["StateReader"]

_TURN = 100
"""Readers of one message after which others get their turn."""


class StateReader:
    """The way from messages of state to the graph.

    Args:
        registry: What stands.
        reporter: Where it is told.
        listeners: Who wants plain words.
        scheduler: Ends values that end by themselves.
        quarantine: Judges conventions that fail.
        counters: Of the gateway.
    """

    def __init__(
        self,
        registry: AnnouncementRegistry,
        reporter: DeviceReporter,
        listeners: RawDelivery,
        scheduler: Scheduler,
        quarantine: PeerQuarantine[MqttMessage],
        counters: GatewayCounters,
    ) -> None:
        self._registry = registry
        self._reporter = reporter
        self._listeners = listeners
        self._scheduler = scheduler
        self._quarantine = quarantine
        self._counters = counters

    async def read_availability_message(
        self, message: MqttMessage, availability_readers: tuple[AvailabilityReader, ...]
    ) -> None:
        """Take *message* as one that tells whether devices can be reached; equal sources read it once."""
        read: dict[int, bool | None] = {}
        for number, availability_reader in enumerate(availability_readers, 1):
            if number % _TURN == 0:
                await anyio.lowlevel.checkpoint()
            reachability = availability_reader.stored.reachability.get(availability_reader.part)
            if (
                reachability is None
                or self._registry.get(availability_reader.stored.key) is not availability_reader.stored
            ):
                continue
            source = reachability.availability.sources[availability_reader.index]
            if id(source) not in read:
                read[id(source)] = self._read_availability(source, availability_reader.stored, message)
            said = read[id(source)]
            if said is not None:
                reachability.hear(availability_reader.index, said, retained=message.retain)
                self._tell_reachable(
                    availability_reader.stored, availability_reader.part, message.topic, retained=message.retain
                )

    async def read(
        self, message: MqttMessage, announced_parts: tuple[AnnouncedPart, ...], longest: int = MAX_STATE_BYTES
    ) -> None:
        """Take *message* as one in which parts tell their state; one that is too long is only counted."""
        if len(message.payload) > longest:
            self._counters.oversize += 1
            return
        readings: list[Reading] = []
        stored: StoredAnnouncement | None = None
        for number, announced_part in enumerate(announced_parts, 1):
            if number % _TURN == 0:
                await anyio.lowlevel.checkpoint()
            told = self._decode(announced_part, message)
            if not told:
                continue
            if announced_part.stored is not stored:
                if stored is not None:
                    self._report(stored, readings, message)
                stored, readings = announced_part.stored, []
            readings += told[1]
            for fade in announced_part.described.expiries:
                self._plan(announced_part, fade, told[0])
            await self._deliver_text(announced_part, told[0], message)
        if stored is not None:
            self._report(stored, readings, message)

    async def read_text(self, message: MqttMessage, part: AnnouncedPart) -> None:
        """Take *message* as the text that *part* says by itself, and hand it on as it is."""
        self._counters.received += 1
        stored, now = part.stored, self._reporter.now
        if not message.retain and (now >= stored.refresh_at or not stored.is_confirmed):
            self._reporter.publish_sighting(stored, "updated", f"message on {message.topic}", confirmed=True)
        told = self._decode(part, message)
        if told is not None:
            self._counters.reports += 1
            self._reporter.publish_readings(stored, told[1], message.topic, message.topic, retained=message.retain)
        raw = RawMessage.of_checked(
            gateway=stored.gateway,
            key=stored.key,
            address=message.topic,
            payload=message.payload,
            retained=message.retain,
            received_at=self._reporter.stamp,
        )
        part.keep(raw, now, is_event=False)
        await self._listeners.deliver(raw, wait_if_full=message.qos > 0)

    def _read_availability(
        self, source: AvailabilitySource, stored: StoredAnnouncement, message: MqttMessage
    ) -> bool | None:
        try:
            return source.read(message.payload)
        except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
            self._quarantine.record_plugin_failure(message.topic, stored.described.convention, exc)
            return None

    def _decode(
        self, announced_part: AnnouncedPart, message: MqttMessage
    ) -> tuple[Mapping[str, PlainValue], list[Reading]] | None:
        try:
            told = announced_part.described.codec.read(message.topic, message.payload, retained=message.retain)
            if not told:
                return None
            part = announced_part.described.part.id
            return told, [Reading(part=part, capability=name, value=Value.of(value)) for name, value in told.items()]
        except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
            self._quarantine.record_plugin_failure(message.topic, announced_part.stored.described.convention, exc)
            return None

    def _report(self, stored: StoredAnnouncement, readings: list[Reading], message: MqttMessage) -> None:
        if self._registry.get(stored.key) is not stored:
            return  # it went while others had their turn
        self._counters.reports += 1
        if not message.retain and (not stored.is_confirmed or self._reporter.now >= stored.refresh_at):
            # First: to a directory that has forgotten the device, a report alone is of nobody.
            self._reporter.publish_sighting(stored, "updated", f"message on {message.topic}", confirmed=True)
        self._reporter.publish_readings(stored, readings, message.topic, message.topic, retained=message.retain)
        if not message.retain and False in stored.reachable.values():
            self._doubt(stored, {"", *(one.part for one in readings)}, message.topic)

    def _doubt(self, stored: StoredAnnouncement, parts: set[str], topic: str) -> None:
        """The *parts* spoke: an "offline" of theirs that the broker had kept was of before."""
        for part in parts:
            if stored.reachable.get(part) is False:
                stored.reachability[part].doubt()
                self._tell_reachable(stored, part, topic, retained=False)

    def _tell_reachable(self, stored: StoredAnnouncement, part: str, topic: str, *, retained: bool) -> None:
        reachable = stored.reachability[part].value
        if part in stored.reachable and reachable is stored.reachable[part]:
            return
        if part not in stored.reachable and reachable is None:
            return
        stored.reachable[part] = reachable
        self._reporter.report_reachable(stored, part, topic, reachable=reachable, retained=retained)

    async def _deliver_text(
        self, announced_part: AnnouncedPart, told: Mapping[str, PlainValue], message: MqttMessage
    ) -> None:
        raw = self._as_text(announced_part, told, retained=message.retain)
        if raw is not None:
            await self._listeners.deliver(raw, wait_if_full=message.qos > 0)

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
        elif not self._scheduler.plan(name, fade.after, partial(self._fade, *name[1:], fade)):
            self._counters.fades_dropped += 1

    def _fade(self, key: str, part: str, capability: str, fade: AutoExpiry) -> None:
        announced_part = self._registry.announced_part(key, part)
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
