"""The vocabulary that gateways, discovery and applications share."""

from homebot.devices.device import (
    Device,
    DeviceChange,
    DevicePart,
    Endpoint,
    Fact,
    Freshness,
    KeyValue,
    Reachability,
    Route,
    State,
    StateChange,
)
from homebot.devices.devices import Devices
from homebot.devices.follow import Follow
from homebot.devices.gateway_state import GatewayState
from homebot.devices.names import (
    DEVICE_CHANGES,
    DEVICE_STATES,
    FIND_DEVICES,
    GET_CHANGES,
    GET_INDEX_DATA,
    QUERY_DEVICES,
    GatewayNames,
    gateway_of,
)
from homebot.devices.raw import RawCommand, RawMessage
from homebot.devices.services import FindDevices, Found, GetChanges, GetIndexData, QueryDevices, SubscribeToTopic
from homebot.devices.sighting import Sighting

__all__ = [
    "DEVICE_CHANGES",
    "DEVICE_STATES",
    "FIND_DEVICES",
    "GET_CHANGES",
    "GET_INDEX_DATA",
    "QUERY_DEVICES",
    "Device",
    "DeviceChange",
    "DevicePart",
    "Devices",
    "Endpoint",
    "Fact",
    "FindDevices",
    "Follow",
    "Found",
    "Freshness",
    "GatewayNames",
    "GatewayState",
    "GetChanges",
    "GetIndexData",
    "KeyValue",
    "QueryDevices",
    "RawCommand",
    "RawMessage",
    "Reachability",
    "Route",
    "Sighting",
    "State",
    "StateChange",
    "SubscribeToTopic",
    "gateway_of",
]
