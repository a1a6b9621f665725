"""The vocabulary that gateways, discovery and applications share."""

from homebot.devices.device import Device, DeviceChange, Endpoint, Freshness, KeyValue
from homebot.devices.devices import Devices
from homebot.devices.follow import Follow
from homebot.devices.gateway_state import GatewayState
from homebot.devices.names import DEVICE_CHANGES, FIND_DEVICES, GET_INDEX_DATA, GatewayNames
from homebot.devices.raw import RawCommand, RawMessage
from homebot.devices.services import FindDevices, GetIndexData, SubscribeToTopic
from homebot.devices.sighting import Sighting

__all__ = [
    "DEVICE_CHANGES",
    "FIND_DEVICES",
    "GET_INDEX_DATA",
    "Device",
    "DeviceChange",
    "Devices",
    "Endpoint",
    "FindDevices",
    "Follow",
    "Freshness",
    "GatewayNames",
    "GatewayState",
    "GetIndexData",
    "KeyValue",
    "RawCommand",
    "RawMessage",
    "Sighting",
    "SubscribeToTopic",
]
