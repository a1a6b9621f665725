"""The packets of MQTT 3.1, 3.1.1 and 5 as values, and the pure functions between them and bytes.

Sources: MQTT 3.1 (IBM and Eurotech, 2010), MQTT 3.1.1 (OASIS, 2014), MQTT 5.0 (OASIS, 2019).
"""

from homebot.mqtt.packets.connect import Auth, Connack, Connect, Disconnect, Pingreq, Pingresp, Will
from homebot.mqtt.packets.properties import NO_PROPERTIES, PacketType, Properties
from homebot.mqtt.packets.publish import Acknowledgement, Puback, Pubcomp, Publish, Pubrec, Pubrel
from homebot.mqtt.packets.reader import MAX_PACKET_SIZE, Packet, PacketReader, decode, encode
from homebot.mqtt.packets.reason import PacketError, ProtocolVersion, ReasonCode
from homebot.mqtt.packets.subscribe import MqttSubscription, Suback, Subscribe, Unsuback, Unsubscribe

__all__ = [
    "MAX_PACKET_SIZE",
    "NO_PROPERTIES",
    "Acknowledgement",
    "Auth",
    "Connack",
    "Connect",
    "Disconnect",
    "MqttSubscription",
    "Packet",
    "PacketError",
    "PacketReader",
    "PacketType",
    "Pingreq",
    "Pingresp",
    "Properties",
    "ProtocolVersion",
    "Puback",
    "Pubcomp",
    "Publish",
    "Pubrec",
    "Pubrel",
    "ReasonCode",
    "Suback",
    "Subscribe",
    "Unsuback",
    "Unsubscribe",
    "Will",
    "decode",
    "encode",
]
