"""The devices of a gateway of another machine, published as those of a gateway here."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeVar

from homebot.bridges.machines.waiting_news import MOST_OF_EACH
from homebot.devices import Sighting
from homebot.devices.capabilities import EVENTS
from homebot.devices.gateway_messages import REACHABLE, CommandAnswer, Report
from homebot.devices.health import Quarantine
from homebot.devices.value import UNKNOWN
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message
from homebot.support.bounded_map import BoundedMap

if TYPE_CHECKING:
    from homebot.bridges.machines.messages import FollowGatewayResponse
    from homebot.gateways import Gateway

HeardT = TypeVar("HeardT", Sighting, Report)

_MAX_LENGTH = 1000
"""Characters of a text, and elements of a list, of an announcement: nobody there need be believed."""

_STAMPS = {Sighting: ("seen_at", "expires_at"), Report: ("received_at",)}
_SAME_TIME = 5.0
"""Seconds by which the time of day there may differ; beyond, the computer has no clock, or a wrong one."""

_NEWEST_OF_EACH = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Mirror:
    """Publisher of the devices of another gateway in the name of *gateway*.

    Attributes:
        refused: Announcements that are longer than any of a device.
    """

    def __init__(self, gateway: Gateway) -> None:
        self._gateway, self._name = gateway, gateway.node.name
        node, names = gateway.node, gateway.names
        self._clock = node.graph.clock
        self._answers = node.create_publisher(CommandAnswer, names.answers, 1000)
        self._quarantines = node.create_publisher(Quarantine, names.quarantine, _NEWEST_OF_EACH)
        self._devices: BoundedMap[str, Sighting] = BoundedMap(MOST_OF_EACH)
        self._reports: BoundedMap[str, Report] = BoundedMap(MOST_OF_EACH)
        self.refused = 0

    def publish(self, news: FollowGatewayResponse, later: float) -> None:
        """Publish *news* of a machine whose monotonic clock is *later* seconds behind the one here."""
        if news.is_whole:
            for key in self._devices.keys() - set(news.keys):
                gone = self._devices[key].model_copy(
                    update={"kind": "removed", "why": "it left while there was no link"}
                )
                self._publish_sighting(gone)
            self._dispose(self._reports.keys() - set(news.streams))
        for sighting in news.sightings:
            if _is_usual(sighting):
                self._publish_sighting(self._own(sighting, later))
            else:
                self.refused += 1
        for report in news.reports:
            self._publish_report(self._own(report, later))
        for answer in news.answers:
            self._answers.publish(answer.model_copy(update={"gateway": self._name}))
        for quarantined in news.quarantines:
            self._quarantines.publish(quarantined.model_copy(update={"gateway": self._name}))
            if quarantined.is_over:
                self._quarantines.dispose(quarantined.offender)

    def on_link_loss(self) -> None:
        """Publish of all devices that said that they can be reached that nobody knows it now."""
        for report in tuple(self._reports.values()):
            if report.address and any(reading.capability == REACHABLE for reading in report.readings):
                readings = tuple(reading.model_copy(update={"value": UNKNOWN}) for reading in report.readings)
                # without an address: nobody reports it any more
                self._publish_report(report.model_copy(update={"readings": readings, "address": ""}))

    def _own(self, message: HeardT, later: float) -> HeardT:
        """Return *message* as of this gateway, in the time of the clocks here."""
        own: dict[str, object] = {"gateway": self._name}
        if message.heard_at:
            now, stamps = self._clock.monotonic(), {name: getattr(message, name) for name in _STAMPS[type(message)]}
            heard_at = own["heard_at"] = max(0.0, min(now, message.heard_at + later))
            behind = self._clock.now() - (now - heard_at) - next(iter(stamps.values())).to_seconds()
            if abs(behind) > _SAME_TIME:
                own |= {name: Time.from_seconds(stamp.to_seconds() + behind) for name, stamp in stamps.items()}
        return message.model_copy(update=own)

    def _publish_sighting(self, sighting: Sighting) -> None:
        if sighting.kind == "removed":
            self._devices.pop(sighting.key, None)
            self._dispose(report.stream for report in tuple(self._reports.values()) if report.key == sighting.key)
        else:
            self._devices[sighting.key] = sighting
        self._gateway.publish_sighting(sighting)

    def _publish_report(self, report: Report) -> None:
        self._gateway.reports.publish(report)
        is_over = report.key not in self._devices or all(reading.capability in EVENTS for reading in report.readings)
        if is_over:  # nothing is kept of events, and of a device that has just left
            self._gateway.reports.dispose(report.stream)
        else:
            self._reports[report.stream] = report

    def _dispose(self, streams: Iterable[str]) -> None:
        for stream in streams:
            self._reports.pop(stream, None)
            self._gateway.reports.dispose(stream)


def _is_usual(value: object) -> bool:
    if isinstance(value, Message):
        return all(map(_is_usual, value.__dict__.values()))
    if isinstance(value, tuple):
        return len(value) <= _MAX_LENGTH and all(map(_is_usual, value))
    return not isinstance(value, str) or len(value) <= _MAX_LENGTH
