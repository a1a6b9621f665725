"""The gateway to Bluetooth Low Energy: broadcasts of sensors and beacons, and devices that are connected to."""

from homebot.gateways.ble.gateway import BleGateway
from homebot.gateways.ble.settings import BleGatewaySettings
from homebot.support.ble_backend import BleBackend

__all__ = ["BleBackend", "BleGateway", "BleGatewaySettings"]
