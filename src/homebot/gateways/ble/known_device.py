"""A device that the gateway lists, and what is known of it. Pure."""

from __future__ import annotations

from collections.abc import Mapping

from homebot.conventions.bluetooth.advertisement import Advertisement
from homebot.conventions.bluetooth.broadcast import Broadcast
from homebot.conventions.bluetooth.distance import DISTANCE_FACTOR, SignalFilter, distance_of
from homebot.conventions.bluetooth.gatt_profile import GattProfile
from homebot.conventions.bluetooth.presence import Presence
from homebot.conventions.units import sensor_type
from homebot.devices.identity import identifiers
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.ble.settings import BleDeviceSettings

__all__ = ["BATTERY", "KnownDevice"]

BATTERY = "battery"
SIGNAL = "signal"
DISTANCE = "distance"
_LONGEST_NAME = 100
_FREE_SPACE_1M = 41.0
"""dB that are lost on the first metre at 2.4 GHz."""

_SIGNAL_PARTS = (
    Part(
        id=SIGNAL,
        service_type=sensor_type("signal_strength"),
        category="diagnostic",
        capabilities=(Capability(name="signal_strength"),),
    ),
    Part(
        id=DISTANCE,
        service_type=sensor_type("measurement"),
        category="diagnostic",
        capabilities=(Capability(name="measurement", unit="m"),),
    ),
)
_UNCERTAINTY = {"distance_uncertainty": f"times or divided by {DISTANCE_FACTOR:.1f}"}


class KnownDevice:
    """A device that the gateway lists.

    Args:
        key: What the gateway calls it.
        declared: What the configuration says of it.
        profile: How it is connected to; None for a device that only broadcasts.
        now: Seconds of the gateway's clock.

    Attributes:
        key: The same.
        profile: The same.
        address: The address at which it was heard last.
        presence: When it was heard.
        signal: How strongly.
        problem: What keeps it from being read; empty where all is well.
        connected_facts: What it said of itself over a connection.
        has_battery: Whether it reported a battery over a connection.
        reported_at: When its signal was reported last.
    """

    def __init__(self, key: str, declared: BleDeviceSettings, profile: GattProfile | None, now: float) -> None:
        self.key = key
        self.profile = profile
        self.address = key
        self.presence = Presence(now)
        self.signal = SignalFilter()
        self.problem = ""
        self.connected_facts: dict[str, str] = {}
        self.has_battery = False
        self.reported_at = float("-inf")
        self._declared = declared
        self._name = ""
        self._broadcast = Broadcast()
        self._rssi_at_1m: float | None = None

    def hear(self, advertisement: Advertisement, broadcast: Broadcast | None, now: float) -> None:
        """Take note of an advertisement, and of what it said."""
        self.address = advertisement.address
        self.presence.hear(now)
        self.signal.add(advertisement.rssi, now)
        said = advertisement.name or ("" if broadcast is None else broadcast.name)
        self._name = said[:_LONGEST_NAME] or self._name
        if broadcast is not None:
            self._broadcast = broadcast
            self.problem = broadcast.problem
        if broadcast is not None and broadcast.rssi_at_1m is not None:
            self._rssi_at_1m = broadcast.rssi_at_1m
        elif advertisement.tx_power is not None:
            self._rssi_at_1m = advertisement.tx_power - _FREE_SPACE_1M

    def describe(self, *, signal: bool) -> GatewayDevice:
        """Return it as it is published.

        Args:
            signal: Whether the strength of the signal is reported.
        """
        said = self._broadcast
        own = () if self.profile is None else (self.profile.part(),)
        facts = {**said.metadata, **self.connected_facts, **({"problem": self.problem} if self.problem else {})}
        addresses = () if self.key.startswith(("ibeacon:", "eddystone:")) else (self.address,)
        return GatewayDevice(
            self.key,
            self._declared.name or self._name or self.key,
            (*own, *said.parts, *self._battery_part(), *(_SIGNAL_PARTS if signal else ())),
            metadata={"address": self.address, **facts, **(_UNCERTAINTY if signal else {})},
            identifiers=identifiers((*addresses, *said.identifiers, *self._serial_number())),
            raw_address=f"ble/{self.key}",
            stale_after=self.presence.stale_after(said.silence),
        )

    def signal_values(self, default_rssi_at_1m: float, now: float) -> Mapping[str, Mapping[str, PlainValue]]:
        """Return the strength of the signal, and the distance by it, by part; nothing where none was received lately.

        Args:
            default_rssi_at_1m: What is received at one metre of a device that does not say it.
            now: Seconds of the gateway's clock.
        """
        rssi = self.signal.value(now)
        if rssi is None:
            return {}
        declared = self._declared.rssi_at_1m
        near = declared if declared is not None else self._rssi_at_1m
        distance = distance_of(rssi, default_rssi_at_1m if near is None else near)
        return {SIGNAL: {"signal_strength": rssi}, DISTANCE: {"measurement": distance}}

    def _battery_part(self) -> tuple[Part, ...]:
        if not self.has_battery or any(one.id == BATTERY for one in self._broadcast.parts):
            return ()
        battery = (Capability(name="battery"),)
        return (Part(id=BATTERY, service_type=sensor_type("battery"), category="diagnostic", capabilities=battery),)

    def _serial_number(self) -> tuple[str, ...]:
        """Return a declared identifier where maker and serial number are known: a number alone may be that of many."""
        facts = self.connected_facts
        if "manufacturer" not in facts or "serial_number" not in facts:
            return ()
        return (f"{facts['manufacturer']} {facts.get('model', '')} {facts['serial_number']}",)
