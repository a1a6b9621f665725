"""A bridge as a device of its own on the wire: it says what the bridge says, hears nothing and does nothing."""

from __future__ import annotations

from collections.abc import Sequence

from homebot.house.device_state import DeviceState
from homebot.house.dialect import Bridge, OutgoingMessage, SimulatedDeviceInfo

__all__ = ["BridgeDialect"]


class BridgeDialect:
    """Fills the port for one bridge.

    Args:
        bridge: What it says.
    """

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge

    @property
    def kinds(self) -> frozenset[str]:
        """A bridge is no device that a house describes."""
        return frozenset()

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return none."""
        del device
        return ()

    def birth(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return what the bridge says on each new link."""
        del device
        return self._bridge.birth

    def will(self, device: SimulatedDeviceInfo) -> OutgoingMessage | None:
        """Return what the broker says when the bridge vanishes."""
        del device
        return self._bridge.will

    def state_messages(self, device: SimulatedDeviceInfo, condition: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return nothing."""
        del device, condition
        return ()

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return nothing."""
        del device, topic, payload
        return ()

    def replies(
        self, device: SimulatedDeviceInfo, condition: DeviceState, topic: str, payload: bytes
    ) -> tuple[OutgoingMessage, ...]:
        """Return nothing."""
        del device, condition, topic, payload
        return ()

    def bridge(self, devices: Sequence[SimulatedDeviceInfo]) -> Bridge | None:
        """Return None: it is one."""
        del devices
        return None
