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
from homebot.gateways.announced.reporter import DeviceReporter
from homebot.gateways.announced.scheduler import Scheduler
from homebot.gateways.mqtt.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.mqtt.counters import GatewayCounters
from homebot.gateways.mqtt.quarantine import PeerQuarantine
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.raw_delivery import RawDelivery
from homebot.mqtt.message import MqttMessage

__all__ = ["StateReader"]

_TURN = 100
"""Readers of one message after which others get their turn."""


class StateReader:
    """The way from messages of state to the graph.

    Args:
        claims: What stands.
        board: Where it is told.
        listeners: Who wants plain words.
        timekeeper: Ends values that end by themselves.
        tribunal: Judges conventions that fail.
        counters: Of the gateway.
    """

    def __init__(
        self,
        claims: AnnouncementRegistry,
        board: DeviceReporter,
        listeners: RawDelivery,
        timekeeper: Scheduler,
        tribunal: PeerQuarantine,
        counters: GatewayCounters,
    ) -> None:
        self._claims = claims
        self._board = board
        self._listeners = listeners
        self._timekeeper = timekeeper
        self._tribunal = tribunal
        self._counters = counters

    async def read_availability_message(self, message: MqttMessage, witnesses: tuple[AvailabilityReader, ...]) -> None:
        """Take *message* as one that tells whether devices can be reached; equal sources read it once."""
        read: dict[int, bool | None] = {}
        for number, witness in enumerate(witnesses, 1):
            if number % _TURN == 0:
                await anyio.lowlevel.checkpoint()
            reachability = witness.claim.reachability.get(witness.part)
            if reachability is None or self._claims.get(witness.claim.key) is not witness.claim:
                continue
            source = reachability.availability.sources[witness.index]
            if id(source) not in read:
                read[id(source)] = self._read_availability(source, witness.claim, message)
            said = read[id(source)]
            if said is not None:
                reachability.hear(witness.index, said, retained=message.retain)
                self._tell_reachable(witness.claim, witness.part, message.topic, retained=message.retain)

    async def read(
        self, message: MqttMessage, voices: tuple[AnnouncedPart, ...], longest: int = MAX_STATE_BYTES
    ) -> None:
        """Take *message* as one in which parts tell their state; one that is too long is only counted."""
        if len(message.payload) > longest:
            self._counters.oversize += 1
            return
        readings: list[Reading] = []
        claim: StoredAnnouncement | None = None
        for number, voice in enumerate(voices, 1):
            if number % _TURN == 0:
                await anyio.lowlevel.checkpoint()
            told = self._decode(voice, message)
            if not told:
                continue
            if voice.claim is not claim:
                if claim is not None:
                    self._report(claim, readings, message)
                claim, readings = voice.claim, []
            readings += told[1]
            for fade in voice.described.expiries:
                self._plan(voice, fade, told[0])
            await self._deliver_text(voice, told[0], message)
        if claim is not None:
            self._report(claim, readings, message)

    async def read_text(self, message: MqttMessage, part: AnnouncedPart) -> None:
        """Take *message* as the text that *part* says by itself, and hand it on as it is."""
        claim, now = part.claim, self._board.now
        if not message.retain and (now >= claim.refresh_at or not claim.is_confirmed):
            self._board.publish_sighting(claim, "updated", f"message on {message.topic}", confirmed=True)
        told = self._decode(part, message)
        if told is not None:
            self._counters.reports += 1
            self._board.publish_readings(claim, told[1], message.topic, message.topic, retained=message.retain)
        raw = RawMessage.of_checked(
            gateway=claim.gateway,
            key=claim.key,
            address=message.topic,
            payload=message.payload,
            retained=message.retain,
            received_at=self._board.stamp,
        )
        part.keep(raw, now, is_event=False)
        for listener in self._listeners.now(message.topic):
            await self._listeners.deliver(listener, raw, wait_if_full=message.qos > 0)

    def _read_availability(
        self, source: AvailabilitySource, claim: StoredAnnouncement, message: MqttMessage
    ) -> bool | None:
        try:
            return source.read(message.payload)
        except BaseException as exc:  # noqa: BLE001 - told by the tribunal; a plug-in's fault must not be everybody's
            self._tribunal.record_plugin_failure(message.topic, claim.described.convention, exc)
            return None

    def _decode(
        self, voice: AnnouncedPart, message: MqttMessage
    ) -> tuple[Mapping[str, PlainValue], list[Reading]] | None:
        try:
            told = voice.described.codec.read(message.topic, message.payload, retained=message.retain)
            if not told:
                return None
            part = voice.described.part.id
            return told, [Reading(part=part, capability=name, value=Value.of(value)) for name, value in told.items()]
        except BaseException as exc:  # noqa: BLE001 - told by the tribunal; a plug-in's fault must not be everybody's
            self._tribunal.record_plugin_failure(message.topic, voice.claim.described.convention, exc)
            return None

    def _report(self, claim: StoredAnnouncement, readings: list[Reading], message: MqttMessage) -> None:
        if self._claims.get(claim.key) is not claim:
            return  # it went while others had their turn
        self._counters.reports += 1
        if not message.retain and (not claim.is_confirmed or self._board.now >= claim.refresh_at):
            # First: to a directory that has forgotten the device, a report alone is of nobody.
            self._board.publish_sighting(claim, "updated", f"message on {message.topic}", confirmed=True)
        self._board.publish_readings(claim, readings, message.topic, message.topic, retained=message.retain)
        if not message.retain and False in claim.reachable.values():
            self._doubt(claim, {"", *(one.part for one in readings)}, message.topic)

    def _doubt(self, claim: StoredAnnouncement, parts: set[str], topic: str) -> None:
        """The *parts* spoke: an "offline" of theirs that the broker had kept was of before."""
        for part in parts:
            if claim.reachable.get(part) is False:
                claim.reachability[part].doubt()
                self._tell_reachable(claim, part, topic, retained=False)

    def _tell_reachable(self, claim: StoredAnnouncement, part: str, topic: str, *, retained: bool) -> None:
        reachable = claim.reachability[part].value
        if part in claim.reachable and reachable is claim.reachable[part]:
            return
        if part not in claim.reachable and reachable is None:
            return
        claim.reachable[part] = reachable
        self._board.report_reachable(claim, part, topic, reachable=reachable, retained=retained)

    async def _deliver_text(self, voice: AnnouncedPart, told: Mapping[str, PlainValue], message: MqttMessage) -> None:
        raw = self._as_text(voice, told, retained=message.retain)
        if raw is not None:
            for listener in self._listeners.now(voice.address):
                await self._listeners.deliver(listener, raw, wait_if_full=message.qos > 0)

    def _as_text(self, voice: AnnouncedPart, told: Mapping[str, PlainValue], *, retained: bool) -> RawMessage | None:
        if retained:
            told = {name: value for name, value in told.items() if name not in EVENTS}
        said = encode_state(told)
        if said is None:
            return None
        raw = RawMessage.of_checked(
            gateway=voice.claim.gateway,
            key=voice.claim.key,
            address=voice.address,
            payload=said.encode(),
            retained=retained,
            received_at=self._board.stamp,
        )
        voice.keep(raw, self._board.now, is_event=not EVENTS.isdisjoint(told))
        return raw

    def _plan(self, voice: AnnouncedPart, fade: AutoExpiry, told: Mapping[str, PlainValue]) -> None:
        if fade.capability not in told:
            return
        value = told[fade.capability]
        name = ("fade", voice.claim.key, voice.described.part.id, fade.capability)
        if value == fade.value or (fade.only is not None and value != fade.only):
            self._timekeeper.drop(name)
        elif not self._timekeeper.plan(name, fade.after, partial(self._fade, *name[1:], fade)):
            self._counters.fades_dropped += 1

    def _fade(self, key: str, part: str, capability: str, fade: AutoExpiry) -> None:
        voice = self._claims.voice(key, part)
        if voice is None or fade not in voice.described.expiries:
            return
        self._board.refresh_time()
        reading = Reading(part=part, capability=capability, value=Value.of(fade.value))
        stream = voice.claim.report_stream(f"fade {part} {capability}")
        self._board.publish_report(voice.claim.key, (reading,), "", stream, retained=False)
        raw = self._as_text(voice, {capability: fade.value}, retained=False)
        if raw is not None:
            for listener in self._listeners.now(voice.address):
                listener.publish(raw)
