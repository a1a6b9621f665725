"""The vocabulary shared by gateways, discovery and applications.

In messages, ``device`` and ``part`` are ids; ``gateway``, ``robot`` and ``capability`` are names; ``reason``, ``why``
and ``message`` are texts for people, unless the field says otherwise.
"""

from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.devices.capabilities import implied_settings
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
    from homebot.devices.gateway_messages import Command, GatewayState, RawCommand, RawMessage, Sighting
    from homebot.devices.identity import identifiers
    from homebot.devices.names import (
        DEVICE_CHANGES,
        DEVICE_STATES,
        FIND_DEVICES,
        GET_CHANGES,
        GET_INDEX_DATA,
        QUERY_DEVICES,
        GatewayNames,
        gateway_of,
        read_text_address,
    )
    from homebot.devices.services import FindDevices, Found, GetChanges, GetIndexData, QueryDevices, SubscribeToTopic
    from homebot.devices.text.states import decode_text
    from homebot.devices.value import PlainValue

__all__ = [
    "DEVICE_CHANGES",
    "DEVICE_STATES",
    "FIND_DEVICES",
    "GET_CHANGES",
    "GET_INDEX_DATA",
    "QUERY_DEVICES",
    "Command",
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
    "PlainValue",
    "QueryDevices",
    "RawCommand",
    "RawMessage",
    "Reachability",
    "Route",
    "Sighting",
    "State",
    "StateChange",
    "SubscribeToTopic",
    "decode_text",
    "gateway_of",
    "identifiers",
    "implied_settings",
    "read_text_address",
]

if not TYPE_CHECKING:  # else a type checker would accept any name
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.devices.capabilities": "implied_settings",
            "homebot.devices.device": """
                Device DeviceChange DevicePart Endpoint Fact Freshness KeyValue Reachability Route State StateChange
                """,
            "homebot.devices.devices": "Devices",
            "homebot.devices.follow": "Follow",
            "homebot.devices.gateway_messages": "Command GatewayState RawCommand RawMessage Sighting",
            "homebot.devices.identity": "identifiers",
            "homebot.devices.names": """
                DEVICE_CHANGES DEVICE_STATES FIND_DEVICES GET_CHANGES GET_INDEX_DATA QUERY_DEVICES GatewayNames
                gateway_of read_text_address
                """,
            "homebot.devices.services": "FindDevices Found GetChanges GetIndexData QueryDevices SubscribeToTopic",
            "homebot.devices.text.states": "decode_text",
            "homebot.devices.value": "PlainValue",
        },
    )
