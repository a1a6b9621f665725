"""The vocabulary that gateways, discovery and applications share."""

from homebot.devices.device import Device, DeviceChange, Endpoint, Freshness, KeyValue
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
    "Endpoint",
    "FindDevices",
    "Freshness",
    "GatewayNames",
    "GetIndexData",
    "KeyValue",
    "RawCommand",
    "RawMessage",
    "Sighting",
    "SubscribeToTopic",
]
