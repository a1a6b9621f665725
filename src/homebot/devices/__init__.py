"""The vocabulary shared by gateways, discovery and applications.

In messages, ``device`` and ``part`` are ids; ``gateway``, ``robot`` and ``capability`` are names; ``reason``, ``why``
and ``message`` are texts for people, unless the field says otherwise.
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

if not TYPE_CHECKING:  # else a type checker would accept any name
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
