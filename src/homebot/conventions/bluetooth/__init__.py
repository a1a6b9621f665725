"""Broadcasts of Bluetooth Low Energy devices, and the frames of those that are connected to. Pure."""

from homebot.conventions.bluetooth.broadcast import Advertisement, Broadcast, BroadcastParser, BroadcastValue
from homebot.conventions.bluetooth.gatt_profile import GattProfile

__all__ = ["Advertisement", "Broadcast", "BroadcastParser", "BroadcastValue", "GattProfile"]
