"""The devices that homebot exposes to other systems through a gateway, such as a Home Assistant on the same broker."""

from collections.abc import Callable, Collection, Mapping
from typing import TypeAlias

from homebot.devices.capabilities import EVENTS
from homebot.devices.exposure import ExposedDevice, ExposedState
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.gateways.base import Gateway
from homebot.graph import DurabilityPolicy, QoSProfile

NOT_TAKEN = "gateway.offer_not_taken"

MAX_OFFERS = 1000

_QOS = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_COMMANDS = 100

KnownStates: TypeAlias = Mapping[tuple[str, str], PlainValue]
"""Values by part and capability."""

PublishStates: TypeAlias = Callable[[ExposedDevice, KnownStates, Collection[tuple[str, str]]], None]
"""Publishes the known states of a device, of which those in the collection changed."""


class ExposedDevices:
    """The devices that homebot exposes through one gateway, with their states; 1,000 devices at most.

    Args:
        show: Publishes a device that is exposed or withdrawn.
        log: Warns of a device that cannot be exposed; takes the event, the message and the device's id.
    """

    def __init__(
        self,
        gateway: Gateway,
        show: Callable[[ExposedDevice], None],
        tell: PublishStates,
        log: Callable[[str, str, str], None],
    ) -> None:
        self._show = show
        self._tell = tell
        self._log = log
        self._offers: dict[str, ExposedDevice] = {}
        self._known: dict[str, dict[tuple[str, str], PlainValue]] = {}
        node, names = gateway.node, gateway.names
        self._commands = node.create_publisher(Command, names.offer_commands, _COMMANDS)
        node.create_subscription(ExposedDevice, names.offers, self._offer, _QOS)
        node.create_subscription(ExposedState, names.offer_reports, self._report, _QOS)

    def command(self, command: Command) -> None:
        """Forward the command of another system to an exposed device; its id is the command's key."""
        self._commands.publish(command)

    def show_all(self) -> None:
        """Publish all devices and states again on a new link; events are not repeated."""
        for offer in self._offers.values():
            self._show(offer)
            self._publish_all(offer)

    def _offer(self, offer: ExposedDevice) -> None:
        if offer.id not in self._offers and len(self._offers) >= MAX_OFFERS:
            self._log(NOT_TAKEN, f"{offer.id} exceeds the limit of exposed devices", offer.id)
            return
        before = self._offers.get(offer.id)
        if before is not None and before.parts != offer.parts:
            self._show(before.model_copy(update={"is_withdrawn": True}))
        self._offers[offer.id] = offer
        self._show(offer)
        if offer.is_withdrawn:
            del self._offers[offer.id]
            self._known.pop(offer.id, None)
        elif before is not None and before.parts != offer.parts:
            offered = _offered(offer)
            known = self._known.get(offer.id, {})
            self._known[offer.id] = {key: value for key, value in known.items() if key in offered}
            self._publish_all(offer)

    def _report(self, report: ExposedState) -> None:
        offer = self._offers.get(report.id)
        if offer is None:
            self._log(NOT_TAKEN, f"{report.id} published a state but is not exposed", report.id)
            return
        offered = _offered(offer)
        changed = {
            key: reading.value.plain()
            for reading in report.readings
            if (key := (reading.part, reading.capability)) in offered
        }
        known = self._known.setdefault(offer.id, {})
        known.update(changed)
        self._tell(offer, known, changed)
        for key in [key for key in changed if key[1] in EVENTS]:
            del known[key]

    def _publish_all(self, offer: ExposedDevice) -> None:
        known = self._known.get(offer.id, {})
        self._tell(offer, known, known)


def _offered(offer: ExposedDevice) -> frozenset[tuple[str, str]]:
    return frozenset(
        (part.id, capability.name) for part in offer.parts for capability in part.capabilities if capability.readable
    )
