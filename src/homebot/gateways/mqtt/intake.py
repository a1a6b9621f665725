"""The handler of announcements and withdrawals."""

from collections.abc import Iterator, Mapping
from functools import cache, partial

import anyio.lowlevel

from homebot.clock import Clock, TimeSlice
from homebot.conventions.convention import Convention, SlicedConvention
from homebot.conventions.description import (
    AnnouncementEvent,
    DeviceAnnounced,
    DeviceRequest,
    DeviceWithdrawn,
    GroupsListed,
    as_group,
)
from homebot.conventions.payload import DuplicateKeys
from homebot.errors import WireError
from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.announced.engine import GatewayEngine
from homebot.gateways.announced.registry import LISTED, Readers, RegistryChange
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.mqtt.reserved import ReservedTopics
from homebot.gateways.mqtt.subscriber import Subscriber
from homebot.mqtt.message import MqttMessage

REJECTED = "gateway.announcement_rejected"
TEXT_REJECTED = "gateway.message_rejected"
RETAINED_ONLY = "gateway.retained_only"
NOT_READ = "gateway.state_topic_refused"
RESERVED = "gateway.command_topic_refused"
AMBIGUOUS = "gateway.announcement_ambiguous"

GRACE = 10.0
"""Seconds for which a withdrawn device may be announced again before it counts as gone.

Zigbee2MQTT renames a device by withdrawing it and announcing it two seconds later.
"""

MAX_STEPS = 100_000
"""Most steps per message, so that a convention that never ends cannot hold the gateway."""


class AnnouncementHandler:
    """Turns announcements into registered devices and sightings."""

    def __init__(
        self,
        clock: Clock,
        engine: GatewayEngine[MqttMessage],
        registry: AnnouncementRegistry,
        reserved: ReservedTopics,
        subscriber: Subscriber,
    ) -> None:
        self._clock = clock
        self._registry = registry
        self._reserved = reserved
        self._subscriber = subscriber
        self._reporter, self._scheduler, self._states = engine.reporter, engine.scheduler, engine.states
        self._quarantine, self._counters = engine.quarantine, engine.counters
        self._accepted = self._offended = False
        self._missed: list[tuple[str, AnnouncedPart | AvailabilityReader]] = []
        self._groups: dict[str, Mapping[str, tuple[str, ...]]] = {}

    async def handle(self, message: MqttMessage, conventions: tuple[Convention, ...]) -> Readers:
        """Handle *message* as an announcement of each of *conventions*, in slices of a few milliseconds.

        Returns:
            The readers, by topic, that may have missed a message.
        """
        self._accepted = self._offended = False
        self._missed = []
        self._counters.announcements += 1
        with DuplicateKeys() as repeated:
            for convention in conventions:
                await self._read(convention, message)
        if self._accepted:
            budgets, is_valid = self._quarantine.budgets, not self._offended
            budgets.accept(message.topic, message.payload, self._reporter.now, is_valid=is_valid)
        if repeated:
            self._counters.announcements_ambiguous += 1
            keys = ", ".join(repr(key[:40]) for key in dict.fromkeys(repeated))
            self._quarantine.log_limited(
                AMBIGUOUS, f"{message.topic} contains {keys} twice; the last value is used", source=message.topic
            )
        return tuple(self._missed)

    def handle_text(self, message: MqttMessage, conventions: tuple[Convention, ...]) -> None:
        """Handle *message* as the first text of a device, with the first of *conventions* that knows its topic.

        Any client may publish text, so an invalid topic is logged and counted, but not charged to a source.
        """
        for convention in conventions:
            try:
                events = convention.read_message(message.topic, message.payload, retained=message.retain)
                for event in events:
                    self._handle(event, convention, message, 0)
            except WireError as exc:
                self._counters.rejected += 1
                self._quarantine.log_limited(TEXT_REJECTED, f"not a device's message: {exc}", source=message.topic)
                return
            except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
                self._quarantine.record_plugin_failure(message.topic, convention.name, exc)
                return
            if events:
                return

    async def _read(self, convention: Convention, message: MqttMessage) -> None:
        """Handle the events that *convention* finds in a message."""
        length = len(message.payload)
        try:
            if _takes_slices(type(convention)) and isinstance(convention, SlicedConvention):
                length = 0  # unknown for the single devices of a list
                steps = iter(convention.read_message_in_slices(message.topic, message.payload, retained=message.retain))
            else:
                events = convention.read_message(message.topic, message.payload, retained=message.retain)
                if type(events) is tuple and len(events) == 1:  # as nearly always; a plug-in may return an iterator
                    self._handle(events[0], convention, message, length)
                    return
                steps = iter(events)
        except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
            self._record_failure(convention, message, exc)
            return
        numbered = enumerate(steps)
        while self._handle_slice(numbered, convention, message, length):
            # Outside the error handling for conventions: a cancellation here is meant for the gateway.
            await anyio.lowlevel.checkpoint()

    def _handle_slice(
        self,
        steps: Iterator[tuple[int, AnnouncementEvent | None]],
        convention: Convention,
        message: MqttMessage,
        length: int,
    ) -> bool:
        """Handle events of a message for a few milliseconds; return whether there may be more."""
        work = TimeSlice(self._clock)
        try:
            for number, event in steps:
                if number > MAX_STEPS:
                    self._counters.announcements_rejected += 1
                    self._record_offence(
                        message, f"{convention.name} found more than {MAX_STEPS:,} announcements in one message"
                    )
                    return False
                self._handle(event, convention, message, length)
                if work.is_over:
                    return True
        except BaseException as exc:  # noqa: BLE001 - recorded as its failure; a plug-in's fault must not be everybody's
            self._record_failure(convention, message, exc)
        return False

    def _handle(self, event: object, convention: Convention, message: MqttMessage, length: int) -> None:
        match event:
            case DeviceAnnounced():
                self._describe(event, message, length)
            case DeviceWithdrawn():
                self._withdraw(convention, event)
            case DeviceRequest():
                self._subscriber.question(event)
            case GroupsListed():
                before, self._groups[event.source] = self._groups.get(event.source, {}), event.members
                changed = {member for member, _ in before.items() ^ event.members.items()}
                for stored in tuple(self._registry.by_key.values()) if changed else ():
                    if not changed.isdisjoint(stored.described.identifiers):
                        self._describe(stored.described, message, 0)
            case WireError():
                self._counters.announcements_rejected += 1
                words = f"{message.topic}: left out of an announcement for {convention.name}: {event}"
                self._quarantine.log_limited(REJECTED, words, source=message.topic, about=str(event))

    def _record_failure(self, convention: Convention, message: MqttMessage, error: BaseException) -> None:
        if isinstance(error, WireError):
            self._counters.announcements_rejected += 1
            self._record_offence(message, f"invalid announcement for {convention.name}: {error}")
            return
        self._quarantine.record_plugin_failure(message.topic, convention.name, error)
        self._record_offence(message, f"the convention {convention.name} failed")

    def _record_offence(self, message: MqttMessage, why: str) -> None:
        self._offended = True
        self._quarantine.record_offence(message.topic, len(message.payload), REJECTED, why)

    def _describe(self, described: DeviceAnnounced, message: MqttMessage, length: int) -> None:
        names_program = "origin" in described.facts
        if names_program and self._registry.derived.is_derived(described):
            self._accepted = True
            self._counters.announcements_derived += 1
            self.remove(described.full_key, LISTED)
            return
        if self._groups:
            described = self._with_members(described)
        described, reserved = self._reserved.without(described)
        for topic in reserved:
            self._counters.topics_reserved += 1
            self._quarantine.log_limited(
                RESERVED, f"{described.key} receives no commands on {topic}", source=message.topic
            )
        try:
            change = self._registry.put(described, length, is_retained=message.retain)
        except WireError:
            self._counters.devices_refused += 1
            raise
        self._accepted = True
        for problem in change.refused:
            self._counters.topics_refused += 1
            words = f"{change.stored.key} is only partly read: {problem}"
            self._quarantine.log_limited(NOT_READ, words, source=message.topic)
        self._publish(change, message)
        for key in self._registry.derived.of(described) if names_program and described.native else ():
            self.remove(key, LISTED)

    def _with_members(self, described: DeviceAnnounced) -> DeviceAnnounced:
        """Return *described* with the members that a list gives it, if it is a group."""
        listed = [groups.get(identifier) for groups in self._groups.values() for identifier in described.identifiers]
        members = next((members for members in listed if members is not None), None)
        if members is None:
            return described
        return described._replace(parts=tuple([as_group(part, members) for part in described.parts]))

    def _publish(self, change: RegistryChange, message: MqttMessage) -> None:
        """Publish the change made by *message*, and have the device's topics subscribed to and its state requested."""
        stored, before = change.stored, change.before
        described = stored.described
        stored.heard_at = stored.heard_at if message.retain else self._reporter.now
        why = self._why(stored, before, message)
        if why:
            is_live = (described.implies_alive or described.text is not None) and not message.retain
            self._reporter.publish_sighting(stored, "appeared" if before is None else "updated", why, confirmed=is_live)
        self._missed += change.readers
        if before is None or not stored.publishes_the_same(before):
            self._subscriber.ask(stored)
        else:
            self._subscriber.wake()
        if before is not None:
            self._scheduler.drop(("gone", stored.key))
            for part in before.reachable.keys() - stored.reachability.keys():
                self._reporter.report_reachable(stored, part, "", reachable=None, retained=False)
            self._reporter.dispose_left(stored, before)
            before.detach()
        if stored.reachability:
            self._states.report_reachability(stored)

    def _why(self, stored: StoredAnnouncement, before: StoredAnnouncement | None, message: MqttMessage) -> str:
        """Return the reason for a sighting; empty if none is due."""
        if before is not None:
            if not stored.publishes_the_same(before):
                return "its description changed"
            is_due = not message.retain and self._reporter.now >= stored.refresh_at
            return "it was announced again" if is_due else ""
        if stored.described.text is None:
            return f"retained announcement on {message.topic}" if message.retain else "it was announced"
        if not message.retain:
            return f"message on {message.topic}"
        words = f"{stored.key} is known only from a retained message; it may be gone"
        self._quarantine.log_limited(RETAINED_ONLY, words, source=message.topic)
        return f"retained message on {message.topic}"

    def _withdraw(self, convention: Convention, withdrawn: DeviceWithdrawn) -> None:
        device = withdrawn.device
        stored = self._registry.by_key.get(f"{convention.name}:{withdrawn.key}" if device is None else device.full_key)
        if stored is None:
            if device is not None:
                unknown = StoredAnnouncement(self._registry.gateway, device.full_key, device)
                self._reporter.publish_sighting(unknown, "removed", withdrawn.why, confirmed=True)
            return
        if withdrawn.is_final or not self._scheduler.plan(
            ("gone", stored.key), GRACE, partial(self._remove_in_time, stored.key, withdrawn.why)
        ):
            self.remove(stored.key, withdrawn.why)

    def _remove_in_time(self, key: str, why: str) -> None:
        self._reporter.refresh_time()
        self.remove(key, why)

    def remove(self, key: str, why: str) -> None:
        """Remove a registered announcement at once."""
        self._scheduler.drop(("gone", key))
        if (stored := self._registry.remove(key)) is None:
            return
        self._quarantine.budgets.forget(stored.described.topic)
        self._reporter.publish_sighting(stored, "removed", why, confirmed=True)
        self._reporter.dispose_all(stored)
        stored.detach()
        self._subscriber.wake()


@cache
def _takes_slices(kind: type[Convention]) -> bool:
    """Return whether *kind* reads in slices; cached, as checking a protocol takes longer than a short announcement."""
    return issubclass(kind, SlicedConvention)
