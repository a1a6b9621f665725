"""Offering something of homebot's to other systems of the house, and hearing what they want of it."""

from __future__ import annotations

from collections.abc import AsyncIterator
from types import TracebackType
from typing import Self

from homebot.devices.command import Command
from homebot.devices.exposed import ExposedDevice, ExposedState
from homebot.devices.names import GatewayNames
from homebot.devices.report import Reading
from homebot.devices.value import PlainValue, Value
from homebot.graph import DurabilityPolicy, Node, QoSProfile

__all__ = ["Exposure"]

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_COMMANDS_DEPTH = 100


class Exposure:
    """An offer that others see within a ``with`` block, and that is withdrawn after it; one task reads its commands.

    Args:
        node: Who offers.
        offer: What.
        gateway: Name of the gateway that publishes it, where that is switched on.

    Attributes:
        offer: The same.
    """

    def __init__(self, node: Node, offer: ExposedDevice, gateway: str = "mqtt") -> None:
        names = GatewayNames(gateway)
        self.offer = offer
        self._node = node
        self._offers = node.create_publisher(ExposedDevice, names.offers, _LATCHED)
        self._reports = node.create_publisher(ExposedState, names.offer_reports, _LATCHED)
        self._commands = node.create_subscription(Command, names.offer_commands, qos_profile=_COMMANDS_DEPTH)

    def __enter__(self) -> Self:
        self._offers.publish(self.offer)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self._node.is_closed:
            self._offers.publish(self.offer.model_copy(update={"is_withdrawn": True}))
        self._commands.close()

    def set_state(self, capability: str, value: PlainValue, part: str = "") -> None:
        """Tell what it is now: *capability* of the part *part* has *value*."""
        reading = Reading(part=part, capability=capability, value=Value.of(value))
        self._reports.publish(ExposedState(id=self.offer.id, readings=(reading,)))

    async def commands(self) -> AsyncIterator[Command]:
        """Yield what others tell it to become, until the block or the node ends.

        At most 100 wait; the oldest goes.
        """
        async for command in self._commands:
            if command.key == self.offer.id:
                yield command
