"""The vocabulary that gateways, discovery and applications share.

In messages ``device`` and ``part`` are ids, ``gateway``, ``robot`` and ``capability`` names, and ``reason``, ``why``
and ``message`` texts for people; a field that is something else says so.
"""

from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
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
    from homebot.devices.gateway_messages import GatewayState, RawCommand, RawMessage, Sighting
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
    from homebot.devices.services import FindDevices, Found, GetChanges, GetIndexData, QueryDevices, SubscribeToTopic

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

if not TYPE_CHECKING:  # else a name that does not exist would pass for one
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.devices.device": """
                Device DeviceChange DevicePart Endpoint Fact Freshness KeyValue Reachability Route State StateChange
                """,
            "homebot.devices.devices": "Devices",
            "homebot.devices.follow": "Follow",
            "homebot.devices.gateway_messages": "GatewayState RawCommand RawMessage Sighting",
            "homebot.devices.names": """
                DEVICE_CHANGES DEVICE_STATES FIND_DEVICES GET_CHANGES GET_INDEX_DATA QUERY_DEVICES GatewayNames
                gateway_of
                """,
            "homebot.devices.services": "FindDevices Found GetChanges GetIndexData QueryDevices SubscribeToTopic",
        },
    )
