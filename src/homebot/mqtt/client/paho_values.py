"""Between the values of the client port and those of aiomqtt and paho, pure."""

import logging
import struct
from functools import lru_cache
from typing import Any, Final

import aiomqtt
from paho.mqtt import MQTTException
from paho.mqtt import client as paho
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties as PahoProperties
from paho.mqtt.subscribeoptions import SubscribeOptions

from homebot.errors import UsageError
from homebot.mqtt.client.login import MqttVersion, SessionGrant
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import MqttSubscription, Properties

MAX_QOS: Final = 1
"""The highest QoS to publish with."""

# The libraries log peers' mistakes without a limit; our errors and events contain the facts.
_NULL_LOGGER: Final = logging.getLogger("homebot.mqtt.silence")
_NULL_LOGGER.disabled = True


def settings_of(options: MqttOptions, version: MqttVersion) -> dict[str, Any]:
    """Return the arguments for aiomqtt's client."""
    clean, will, is_v5 = options.session_expiry == 0, options.will, version == "5"
    return {
        "hostname": options.host,
        "port": options.port,
        "username": options.user,
        "password": None if options.password is None else options.password.get_secret_value(),
        "logger": _NULL_LOGGER,
        "identifier": options.client_id,
        "protocol": aiomqtt.ProtocolVersion.V5 if is_v5 else aiomqtt.ProtocolVersion.V311,
        "will": None
        if will is None
        else aiomqtt.Will(
            will.topic,
            will.payload,
            will.qos,
            will.retain,
            publish_properties(will.properties, PacketTypes.WILLMESSAGE) if is_v5 else None,
        ),
        "clean_session": None if is_v5 else clean,
        "clean_start": clean if is_v5 else paho.MQTT_CLEAN_START_FIRST_ONLY,
        "timeout": options.timeout,
        "keepalive": options.keep_alive,
        "max_inflight_messages": 0,  # the window here is the bound
        # No TopicAliasMaximum: paho does not resolve aliases.
        "properties": properties_of(
            PacketTypes.CONNECT,
            ReceiveMaximum=options.receive_maximum,
            MaximumPacketSize=options.maximum_packet_size,
            SessionExpiryInterval=options.session_expiry,
        )
        if is_v5
        else None,
    }


def properties_of(packet_type: int, **values: object) -> PahoProperties:
    """Return properties of a packet; None leaves one out."""
    properties = PahoProperties(packet_type)  # type: ignore[no-untyped-call] # paho has no types there
    for name, value in values.items():
        if value is not None:
            setattr(properties, name, value)
    return properties


def publish_properties(wanted: Properties, packet_type: int = PacketTypes.PUBLISH) -> PahoProperties:
    """Return the properties of a PUBLISH or a will."""
    return properties_of(
        packet_type,
        PayloadFormatIndicator=wanted.payload_format_indicator,
        MessageExpiryInterval=wanted.message_expiry_interval,
        ContentType=wanted.content_type,
        ResponseTopic=wanted.response_topic,
        CorrelationData=wanted.correlation_data,
        UserProperty=list(wanted.user_properties) or None,
    )


def packed_size(properties: PahoProperties | None) -> int:
    """Return the size of the properties; check them too, which paho does only when half of a publish is booked."""
    try:
        return 0 if properties is None else len(properties.pack())  # type: ignore[no-untyped-call] # as above
    except (MQTTException, ValueError, struct.error) as error:
        raise UsageError(f"these message properties cannot be sent: {error}") from error


def subscribe_options(wanted: MqttSubscription, version: MqttVersion) -> int | SubscribeOptions:
    """Return how paho subscribes to it."""
    if version != "5":
        return wanted.qos
    return _options(wanted.qos, wanted.no_local, wanted.retain_as_published, wanted.retain_handling)


_options = lru_cache(maxsize=64)(SubscribeOptions)  # paho only reads them, and takes long to make one


def grant_of(version: MqttVersion, flags: paho.ConnectFlags, properties: PahoProperties | None) -> SessionGrant:
    """Return the properties granted by the broker."""
    return SessionGrant(
        resumed=bool(flags.session_present),
        protocol=version,
        maximum_qos=min(getattr(properties, "MaximumQoS", MAX_QOS), MAX_QOS),
        retain_available=bool(getattr(properties, "RetainAvailable", 1)),
        receive_maximum=getattr(properties, "ReceiveMaximum", 65_535),
        maximum_packet_size=getattr(properties, "MaximumPacketSize", None),
    )
