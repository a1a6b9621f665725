"""Between the values of the client port and the packets of MQTT, pure."""

from __future__ import annotations

from functools import lru_cache

from homebot.mqtt.client.port import MqttSubscription, SessionGrant
from homebot.mqtt.message import NO_PROPERTIES, MessageProperties
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.options import MqttWill as WillMessage
from homebot.mqtt.packets import NO_PROPERTIES as NOTHING
from homebot.mqtt.packets import (
    Connack,
    Connect,
    Disconnect,
    FilterRequest,
    PacketType,
    Properties,
    ProtocolVersion,
    Will,
)
from homebot.mqtt.packets.properties import encode_properties

__all__ = [
    "connect_packet",
    "disconnect_packet",
    "encoded_properties",
    "filter_request",
    "publish_properties",
    "session_of",
]


def connect_packet(options: MqttOptions, version: ProtocolVersion) -> Connect:
    """Return the login that *options* ask for."""
    is_v5 = version is ProtocolVersion.V5
    properties = NOTHING
    if is_v5:
        properties = Properties(
            receive_maximum=options.receive_maximum,
            maximum_packet_size=options.maximum_packet_size,
            session_expiry_interval=options.session_expiry,
        )
    return Connect(
        client_id=options.client_id,
        version=version,
        clean_start=options.session_expiry == 0,
        keep_alive=options.keep_alive,
        username=options.user,
        password=None if options.password is None else options.password.get_secret_value().encode(),
        will=None if options.will is None else _will(options.will, is_v5=is_v5),
        properties=properties,
    )


def disconnect_packet(*, ends_session: bool) -> Disconnect:
    """Return the DISCONNECT; in MQTT 5 it can end the session with it."""
    return Disconnect(properties=Properties(session_expiry_interval=0)) if ends_session else Disconnect()


def session_of(answer: Connack, version: ProtocolVersion) -> SessionGrant:
    """Return the properties granted by the broker."""
    granted = answer.properties
    return SessionGrant(
        resumed=answer.session_present,
        protocol="5" if version is ProtocolVersion.V5 else "3.1.1",
        maximum_qos=2 if granted.maximum_qos is None else granted.maximum_qos,
        retain_available=granted.retain_available != 0,
        receive_maximum=granted.receive_maximum or 65_535,
        maximum_packet_size=granted.maximum_packet_size,
    )


def filter_request(subscription: MqttSubscription) -> FilterRequest:
    """Return one line of a SUBSCRIBE."""
    return FilterRequest(
        subscription.filter,
        subscription.qos,
        subscription.no_local,
        subscription.retain_as_published,
        subscription.retain_handling,
    )


def publish_properties(wanted: MessageProperties) -> Properties:
    """Return the properties of a PUBLISH or a will."""
    if wanted is NO_PROPERTIES:
        return NOTHING
    return Properties(
        payload_format_indicator=1 if wanted.payload_is_text else None,
        message_expiry_interval=wanted.expiry,
        content_type=wanted.content_type,
        response_topic=wanted.response_topic,
        correlation_data=wanted.correlation_data,
        user_properties=wanted.user,
    )


@lru_cache(maxsize=32)
def encoded_properties(wanted: MessageProperties) -> bytes:
    """Return the properties of a PUBLISH as they are sent; the last ones are remembered: most say none, or how long."""
    return encode_properties(publish_properties(wanted), PacketType.PUBLISH)


def _will(will: WillMessage, *, is_v5: bool) -> Will:
    properties = publish_properties(will.properties) if is_v5 else NOTHING
    return Will(will.topic, will.payload, will.qos, will.retain, properties)
