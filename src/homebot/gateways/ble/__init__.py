"""The gateway to Bluetooth Low Energy: broadcasts of sensors and beacons, and devices that are connected to."""

from homebot.ble_backend import BleBackend
from homebot.gateways.ble.gateway import BleGateway
from homebot.gateways.ble.settings import BleGatewaySettings

__all__ = ["BleBackend", "BleGateway", "BleGatewaySettings"]
