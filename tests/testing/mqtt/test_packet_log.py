"""The log of packets, and its words."""

from __future__ import annotations

import pytest

from homebot.mqtt.packets import (
    Auth,
    Connack,
    Connect,
    Disconnect,
    MqttSubscription,
    Packet,
    Pingreq,
    Properties,
    Puback,
    Publish,
    Pubrel,
    ReasonCode,
    Suback,
    Subscribe,
    Unsuback,
    Unsubscribe,
    Will,
)
from homebot.testing.mqtt import PacketLog
from homebot.testing.mqtt.packet_log import packet_text


def test_beyond_a_thousand_the_oldest_packet_is_forgotten_and_counted() -> None:
    log = PacketLog(lambda: 0.0)
    for _ in range(1_002):
        log.add("in", "lamp", Pingreq())
    assert (len(log.records), log.total) == (1_000, 1_002)
    assert log.text(newest=1) == "… 1001 earlier packets\n   0.0000 s  lamp                  →  PINGREQ"


@pytest.mark.parametrize(
    ("packet", "words"),
    [
        (
            Connect("a", clean_start=False, keep_alive=0, will=Will("gone", b"secret")),
            "CONNECT 'a' MQTT 5, persistent session, keep-alive 0 s, will on gone",
        ),
        (Connack(True, ReasonCode.BANNED), "CONNACK banned, session present"),
        (Publish("t", b"\xff" * 200, 2, True, True, 9), f"PUBLISH t '{'�' * 120}'… (200 bytes) QoS 2 id 9 retain dup"),
        (Publish("t", properties=Properties(content_type="x")), "PUBLISH t '' QoS 0 [content_type='x']"),
        (Puback(3, ReasonCode.QUOTA_EXCEEDED), "PUBACK id 3 quota exceeded"),
        (Pubrel(3), "PUBREL id 3"),
        (Subscribe(1, (MqttSubscription("a"), MqttSubscription("b", 2))), "SUBSCRIBE id 1: a QoS 0, b QoS 2"),
        (Suback(1, (ReasonCode.NOT_AUTHORIZED, ReasonCode.GRANTED_QOS_2)), "SUBACK id 1: not authorized, QoS 2"),
        (Unsubscribe(1, ("a", "b")), "UNSUBSCRIBE id 1: a, b"),
        (Unsuback(1), "UNSUBACK id 1"),
        (Unsuback(1, (ReasonCode.NO_SUBSCRIPTION_EXISTED,)), "UNSUBACK id 1: no subscription existed"),
        (Disconnect(), "DISCONNECT"),
        (Disconnect(ReasonCode.SERVER_MOVED), "DISCONNECT server moved"),
        (
            Auth(properties=Properties(authentication_method="m", authentication_data=b"secret")),
            "AUTH [authentication_method='m']",
        ),
    ],
)
def test_a_packet_has_words_without_secrets(packet: Packet, words: str) -> None:
    assert packet_text(packet) == words
