"""Availability of Zigbee devices: that of the bridge, and that of the device if the user switched it on. Pure.

Source: zigbee2mqtt.io, Configuration > Device availability, and Usage > MQTT topics and messages > bridge/info.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.description import Availability
from homebot.conventions.payload import parse_json, shown
from homebot.errors import WireError

__all__ = ["AvailabilityRule", "StateAvailability", "read_availability_rule"]


@dataclass(frozen=True, slots=True)
class StateAvailability:
    """One topic that says ``{"state":"online"}`` or ``{"state":"offline"}``; old bridges say the plain word.

    Attributes:
        topic: The topic.
    """

    topic: str

    def read(self, payload: bytes) -> bool | None:
        """Return whether it can be reached, or None when *payload* says neither."""
        if payload in _STATES:
            return _STATES[payload]
        try:
            message = parse_json(payload, _MAX_BYTES)
        except WireError:
            return None
        state = message.get("state") if isinstance(message, dict) else None
        return _STATES.get(state.encode()) if isinstance(state, str) else None


@dataclass(frozen=True, slots=True)
class AvailabilityRule:
    """A rule for which devices of a bridge report their availability. For the others the bridge's alone counts.

    Attributes:
        is_on: Whether devices do.
        exceptions: Devices that differ, by address.
    """

    is_on: bool = True
    exceptions: Mapping[str, bool] = field(default_factory=dict)

    def availability(self, base: str, ieee: str, topic: str) -> Availability:
        """Return how the device at *topic* tells it."""
        sources = (StateAvailability(f"{base}/bridge/state"), StateAvailability(f"{topic}/availability"))
        is_on = self.exceptions.get(ieee, self.is_on)
        return Availability(sources if is_on else sources[:1], mode="all")


def read_availability_rule(info: Mapping[str, object]) -> AvailabilityRule:
    """Return the rule that the ``config`` of ``bridge/info`` states.

    Raises:
        WireError: It has no config.
    """
    config = info.get("config")
    if not isinstance(config, dict):
        raise WireError(f"bridge/info: config is {shown(config)}, not an object")
    devices = config.get("devices")
    listed = devices.items() if isinstance(devices, dict) else ()
    return AvailabilityRule(
        _is_on(config.get("availability")),
        {
            ieee.lower(): _is_on(options["availability"])
            for ieee, options in listed
            if isinstance(options, dict) and options.get("availability") is not None
        },
    )


_STATES = {b"online": True, b"offline": False}
_MAX_BYTES = 1_024


def _is_on(option: object) -> bool:
    """An object without ``enabled`` is how it was switched on before 2.0."""
    return option.get("enabled", True) is True if isinstance(option, dict) else option is True
