"""Reads what described devices say: reports for the graph, plain words, and whether a device can be reached."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import anyio.lowlevel

from homebot.devices import RawMessage
from homebot.devices.capabilities import EVENTS
from homebot.devices.report import Reading
from homebot.devices.value import PlainValue, Value
from homebot.devices.words import word
from homebot.gateways.listeners import Listeners
from homebot.gateways.mqtt.board import Board
from homebot.gateways.mqtt.claim import Claim, Voice, Witness
from homebot.gateways.mqtt.claims import Claims
from homebot.gateways.mqtt.counters import GatewayCounters
from homebot.gateways.mqtt.description import AvailabilitySource, Fade
from homebot.gateways.mqtt.payload import MAX_STATE_BYTES
from homebot.gateways.mqtt.timekeeper import Timekeeper
from homebot.gateways.mqtt.tribunal import Tribunal
from homebot.mqtt.message import MqttMessage

__all__ = ["States"]

_TURN = 100
"""Readers of one message after which others get their turn."""


class States:
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
        claims: Claims,
        board: Board,
        listeners: Listeners,
        timekeeper: Timekeeper,
        tribunal: Tribunal,
        counters: GatewayCounters,
    ) -> None:
        self._claims = claims
        self._board = board
        self._listeners = listeners
        self._timekeeper = timekeeper
        self._tribunal = tribunal
        self._counters = counters

    async def witness(self, message: MqttMessage, witnesses: tuple[Witness, ...]) -> None:
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
                read[id(source)] = self._whether(source, witness.claim, message)
            said = read[id(source)]
            if said is not None:
                reachability.hear(witness.index, said, retained=message.retain)
                self._tell_reachable(witness.claim, witness.part, message.topic, retained=message.retain)

    async def read(self, message: MqttMessage, voices: tuple[Voice, ...], longest: int = MAX_STATE_BYTES) -> None:
        """Take *message* as one in which parts tell their state; one that is too long is only counted."""
        if len(message.payload) > longest:
            self._counters.oversize += 1
            return
        readings: list[Reading] = []
        claim: Claim | None = None
        for number, voice in enumerate(voices, 1):
            if number % _TURN == 0:
                await anyio.lowlevel.checkpoint()
            told = self._told(voice, message)
            if not told:
                continue
            if voice.claim is not claim:
                self._report(claim, readings, message)
                claim, readings = voice.claim, []
            readings += told[1]
            for fade in voice.described.fades:
                self._plan(voice, fade, told[0])
            await self._speak(voice, told[0], message)
        self._report(claim, readings, message)

    def _whether(self, source: AvailabilitySource, claim: Claim, message: MqttMessage) -> bool | None:
        try:
            return source.read(message.payload)
        except BaseException as exc:  # noqa: BLE001 - told by the tribunal; a plug-in's fault must not be everybody's
            self._tribunal.failed(message.topic, claim.described.convention, exc)
            return None

    def _told(self, voice: Voice, message: MqttMessage) -> tuple[Mapping[str, PlainValue], list[Reading]] | None:
        try:
            told = voice.described.codec.read(message.topic, message.payload, retained=message.retain)
            if not told:
                return None
            part = voice.described.part.id
            return told, [Reading(part=part, capability=name, value=Value.of(value)) for name, value in told.items()]
        except BaseException as exc:  # noqa: BLE001 - told by the tribunal; a plug-in's fault must not be everybody's
            self._tribunal.failed(message.topic, voice.claim.described.convention, exc)
            return None

    def _report(self, claim: Claim | None, readings: list[Reading], message: MqttMessage) -> None:
        if claim is None or self._claims.get(claim.key) is not claim:
            return  # it went while others had their turn
        self._counters.reports += 1
        if not message.retain and (not claim.is_confirmed or self._board.now >= claim.refresh_at):
            # First: to a directory that has forgotten the device, a report alone is of nobody.
            self._board.sight(claim, "updated", f"it spoke on {message.topic}", confirmed=True)
        self._tell(claim, readings, message)
        if not message.retain and False in claim.reachable.values():
            self._doubt(claim, {"", *(one.part for one in readings)}, message.topic)

    def _tell(self, claim: Claim, readings: list[Reading], message: MqttMessage) -> None:
        """Tell what lasts, and what happened; that the broker had kept an event says that it happened before."""
        events = tuple(one for one in readings if one.capability in EVENTS)
        states = tuple(one for one in readings if one.capability not in EVENTS) if events else tuple(readings)
        if states:
            stream = claim.stream(message.topic)
            self._board.report(claim.key, states, message.topic, stream, retained=message.retain)
        if events and not message.retain:
            self._board.report_events(claim.key, events, message.topic)

    def _doubt(self, claim: Claim, parts: set[str], topic: str) -> None:
        """The *parts* spoke: an "offline" of theirs that the broker had kept was of before."""
        for part in parts:
            if claim.reachable.get(part) is False:
                claim.reachability[part].doubt()
                self._tell_reachable(claim, part, topic, retained=False)

    def _tell_reachable(self, claim: Claim, part: str, topic: str, *, retained: bool) -> None:
        reachable = claim.reachability[part].value
        if part in claim.reachable and reachable is claim.reachable[part]:
            return
        if part not in claim.reachable and reachable is None:
            return
        claim.reachable[part] = reachable
        self._board.report_reachable(claim, part, topic, reachable=reachable, retained=retained)

    async def _speak(self, voice: Voice, told: Mapping[str, PlainValue], message: MqttMessage) -> None:
        raw = self._word(voice, told, retained=message.retain)
        if raw is not None:
            for listener in self._listeners.now(voice.address):
                await self._listeners.deliver(listener, raw, patient=message.qos > 0)

    def _word(self, voice: Voice, told: Mapping[str, PlainValue], *, retained: bool) -> RawMessage | None:
        if retained:
            told = {name: value for name, value in told.items() if name not in EVENTS}
        said = word(told)
        if said is None:
            return None
        raw = RawMessage(
            gateway=voice.claim.gateway,
            key=voice.claim.key,
            address=voice.address,
            payload=said.encode(),
            retained=retained,
            received_at=self._board.stamp,
        )
        voice.keep(raw, self._board.now, is_event=not EVENTS.isdisjoint(told))
        return raw

    def _plan(self, voice: Voice, fade: Fade, told: Mapping[str, PlainValue]) -> None:
        if fade.capability not in told:
            return
        value = told[fade.capability]
        name = ("fade", voice.claim.key, voice.described.part.id, fade.capability)
        if value == fade.value or (fade.only is not None and value != fade.only):
            self._timekeeper.drop(name)
        elif not self._timekeeper.plan(name, fade.after, partial(self._fade, *name[1:], fade)):
            self._counters.fades_dropped += 1

    def _fade(self, key: str, part: str, capability: str, fade: Fade) -> None:
        voice = self._claims.voice(key, part)
        if voice is None or fade not in voice.described.fades:
            return
        self._board.tick()
        reading = Reading(part=part, capability=capability, value=Value.of(fade.value))
        stream = voice.claim.stream(f"fade {part} {capability}")
        self._board.report(voice.claim.key, (reading,), "", stream, retained=False)
        raw = self._word(voice, {capability: fade.value}, retained=False)
        if raw is not None:
            for listener in self._listeners.now(voice.address):
                listener.publish(raw)
