"""MQTT packets in words, for people who read the log of a failed test."""

from __future__ import annotations

from dataclasses import fields

from homebot.mqtt.packets import (
    NO_PROPERTIES,
    Connack,
    Connect,
    Disconnect,
    Packet,
    Properties,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    Suback,
    Subscribe,
    Unsuback,
    Unsubscribe,
)

__all__ = ["PROTOCOL_NAMES", "packet_text"]

PROTOCOL_NAMES = {ProtocolVersion.V31: "3.1", ProtocolVersion.V311: "3.1.1", ProtocolVersion.V5: "5"}
"""What people call the versions."""

_MAX_PAYLOAD = 120
_SECRET = ("authentication_data",)


def packet_text(packet: Packet) -> str:
    """One line about *packet*; passwords are left out, long payloads cut."""
    properties = getattr(packet, "properties", NO_PROPERTIES)
    return f"{type(packet).__name__.upper()}{_facts(packet)}{_property_text(properties)}"


def _facts(packet: Packet) -> str:
    match packet:
        case Publish():
            return _publish(packet)
        case Connect():
            return _connect(packet)
        case Connack(session_present=present, reason=reason):
            return f" {reason.words}{', session present' if present else ''}"
        case Puback() | Pubrec() | Pubrel() | Pubcomp():
            return f" id {packet.packet_id}{f' {packet.reason.words}' if packet.reason else ''}"
        case Subscribe(packet_id=number, filters=requests):
            return f" id {number}: {', '.join(f'{each.filter} QoS {each.qos}' for each in requests)}"
        case Unsubscribe(packet_id=number, filters=filters):
            return f" id {number}: {', '.join(filters)}"
        case Suback(packet_id=number, reasons=reasons):
            return f" id {number}: {', '.join(each.words if each.failed else f'QoS {int(each)}' for each in reasons)}"
        case Unsuback(packet_id=number, reasons=reasons):
            return f" id {number}: {', '.join(each.words for each in reasons)}".rstrip(": ")
        case Disconnect(reason=reason):
            return f" {reason.words}" if reason else ""
        case _:
            return ""


def _publish(packet: Publish) -> str:
    payload = repr(packet.payload[:_MAX_PAYLOAD].decode(errors="replace"))
    cut = f"… ({len(packet.payload)} bytes)" if len(packet.payload) > _MAX_PAYLOAD else ""
    number = f" id {packet.packet_id}" if packet.packet_id else ""
    flags = f"{' retain' if packet.retain else ''}{' dup' if packet.dup else ''}"
    return f" {packet.topic} {payload}{cut} QoS {packet.qos}{number}{flags}"


def _connect(packet: Connect) -> str:
    user = "" if packet.username is None else f", user {packet.username!r}"
    will = "" if packet.will is None else f", will on {packet.will.topic}"
    clean = "clean start" if packet.clean_start else "session to be kept"
    name = f"{packet.client_id!r} MQTT {PROTOCOL_NAMES[packet.version]}"
    return f" {name}, {clean}, keep-alive {packet.keep_alive} s{user}{will}"


def _property_text(properties: Properties) -> str:
    if properties == NO_PROPERTIES:
        return ""
    known = {each.name: getattr(properties, each.name) for each in fields(properties) if each.name not in _SECRET}
    shown = ", ".join(f"{name}={value!r}" for name, value in known.items() if value is not None and value != ())
    return f" [{shown}]" if shown else ""
