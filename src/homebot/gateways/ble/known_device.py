"""A listed device with all its facts. Pure."""

from collections.abc import Mapping

from homebot.conventions.bluetooth.broadcast import Advertisement, Broadcast, sensor_part
from homebot.conventions.bluetooth.gatt_profile import GattProfile
from homebot.conventions.bluetooth.hearing import Hearing, RoomGuess
from homebot.conventions.bluetooth.signal import DISTANCE_FACTOR, Presence, distance_of
from homebot.devices.identity import identifiers, may_be_unique
from homebot.devices.part import Part
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.ble.settings import BleDeviceSettings

BATTERY = "battery"
SIGNAL = "signal"
DISTANCE = "distance"
_MAX_NAME = 100
_FREE_SPACE_1M = 41.0
"""dB that are lost on the first metre at 2.4 GHz."""

_SIGNAL_PARTS = (
    sensor_part(SIGNAL, "signal_strength", category="diagnostic"),
    sensor_part(DISTANCE, "measurement", unit="m", category="diagnostic"),
)
_UNCERTAINTY = {"distance_uncertainty": f"a factor of {DISTANCE_FACTOR:.1f}, up or down"}


class KnownDevice:
    """A device that the gateway lists.

    Attributes:
        address: The address of its last advertisement.
        problem: Why it cannot be read; empty if it can.
        connected_facts: Device information that was read over a connection.
        hearing: How strongly each receiver hears it.
        guess: The room that this suggests; None for none.
        heard_by: The name of the proxy that hears it best; empty for the adapter of this computer.
    """

    def __init__(self, key: str, declared: BleDeviceSettings, profile: GattProfile | None, now: float) -> None:
        self.key = key
        self.profile = profile
        self.address = key
        self.presence = Presence(now)
        self.hearing = Hearing()
        self.guess: RoomGuess | None = None
        self.heard_by = ""
        self.problem = ""
        self.connected_facts: dict[str, str] = {}
        self.has_battery = False
        self.reported_at = self.put_at = float("-inf")
        self._declared = declared
        self._name = ""
        self._broadcast = Broadcast()
        self._rssi_at_1m: float | None = None

    def update(self, advertisement: Advertisement, broadcast: Broadcast | None, now: float) -> None:
        """Update the device from an advertisement and its meaning."""
        self.address = advertisement.address
        self.presence.record(now)
        self._name = advertisement.name or self._name
        if broadcast is not None:
            self._broadcast = broadcast
            self.problem = broadcast.problem
        if broadcast is not None and broadcast.rssi_at_1m is not None:
            self._rssi_at_1m = broadcast.rssi_at_1m
        elif advertisement.tx_power is not None:
            self._rssi_at_1m = advertisement.tx_power - _FREE_SPACE_1M

    def describe(self, *, signal: bool) -> GatewayDevice:
        """Return the description to publish."""
        said = self._broadcast
        own = () if self.profile is None else (self.profile.part(),)
        facts = {
            **said.metadata,
            **self.connected_facts,
            **self._place(),
            **({"problem": self.problem} if self.problem else {}),
        }
        addresses = () if self.key.startswith(("ibeacon:", "eddystone:")) else (self.address,)
        return GatewayDevice(
            self.key,
            self._declared.name or (said.name or self._name)[:_MAX_NAME] or self.key,
            (*own, *said.parts, *self._battery_part(), *(_SIGNAL_PARTS if signal else ())),
            metadata={"address": self.address, **facts, **(_UNCERTAINTY if signal else {})},
            identifiers=identifiers((*addresses, *said.identifiers, *self._serial_number())),
            raw_address=f"ble/{self.key}",
            stale_after=self.presence.stale_after(said.silence),
            expiries=said.expiries,
        )

    def signal_values(self, default_rssi_at_1m: float, now: float) -> Mapping[str, Mapping[str, PlainValue]]:
        """Return signal strength in dBm and distance by part; empty if nothing was received lately."""
        heard = self.hearing.strongest(now)
        if heard is None:
            return {}
        _, rssi = heard
        declared = self._declared.rssi_at_1m
        near = declared if declared is not None else self._rssi_at_1m
        distance = distance_of(rssi, default_rssi_at_1m if near is None else near)
        return {SIGNAL: {"signal_strength": rssi}, DISTANCE: {"measurement": distance}}

    def _place(self) -> dict[str, str]:
        place = {"heard_by": self.heard_by} if self.heard_by else {}
        if self.guess is None:
            return place
        return {**place, "heard_in": self.guess.room, "heard_in_certainty": f"{self.guess.certainty:.0%}"}

    def _battery_part(self) -> tuple[Part, ...]:
        if not self.has_battery or any(part.id == BATTERY for part in self._broadcast.parts):
            return ()
        return (sensor_part(BATTERY, "battery", category="diagnostic"),)

    def _serial_number(self) -> tuple[str, ...]:
        """Return an identifier if maker and serial number are known: a number alone may not be unique."""
        facts = self.connected_facts
        serial, model = facts.get("serial_number", ""), facts.get("model", "")
        if "manufacturer" not in facts or not may_be_unique(serial, model):
            return ()
        return (f"{facts['manufacturer']} {model} {serial}",)
