"""The log of packets and the journal of messages, and their words."""

import anyio
import pytest

from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker.message import BrokerMessage
from homebot.testing.mqtt import PacketLog
from homebot.testing.mqtt.journal import Journal
from homebot.testing.mqtt.packet_log import packet_text


def test_beyond_a_thousand_the_oldest_packet_is_forgotten_and_counted() -> None:
    log = PacketLog(lambda: 0.0)
    for _ in range(1_002):
        log.add("in", "lamp", mqtt.Pingreq())
    assert (len(log.records), log.total) == (1_000, 1_002)
    assert log.text(newest=1) == "… 1001 earlier packets\n   0.0000 s  lamp                  →  PINGREQ"


@pytest.mark.parametrize(
    ("packet", "words"),
    [
        (
            mqtt.Connect("a", clean_start=False, keep_alive=0, will=mqtt.Will("gone", b"secret")),
            "CONNECT 'a' MQTT 5, persistent session, keep-alive 0 s, will on gone",
        ),
        (mqtt.Connack(True, mqtt.ReasonCode.BANNED), "CONNACK banned, session present"),
        (
            mqtt.Publish("t", b"\xff" * 200, 2, True, True, 9),
            f"PUBLISH t '{'�' * 120}'… (200 bytes) QoS 2 id 9 retain dup",
        ),
        (mqtt.Publish("t", properties=mqtt.Properties(content_type="x")), "PUBLISH t '' QoS 0 [content_type='x']"),
        (mqtt.Puback(3, mqtt.ReasonCode.QUOTA_EXCEEDED), "PUBACK id 3 quota exceeded"),
        (mqtt.Pubrel(3), "PUBREL id 3"),
        (
            mqtt.Subscribe(1, (mqtt.MqttSubscription("a"), mqtt.MqttSubscription("b", 2))),
            "SUBSCRIBE id 1: a QoS 0, b QoS 2",
        ),
        (
            mqtt.Suback(1, (mqtt.ReasonCode.NOT_AUTHORIZED, mqtt.ReasonCode.GRANTED_QOS_2)),
            "SUBACK id 1: not authorized, QoS 2",
        ),
        (mqtt.Unsubscribe(1, ("a", "b")), "UNSUBSCRIBE id 1: a, b"),
        (mqtt.Unsuback(1), "UNSUBACK id 1"),
        (mqtt.Unsuback(1, (mqtt.ReasonCode.NO_SUBSCRIPTION_EXISTED,)), "UNSUBACK id 1: no subscription existed"),
        (mqtt.Disconnect(), "DISCONNECT"),
        (mqtt.Disconnect(mqtt.ReasonCode.SERVER_MOVED), "DISCONNECT server moved"),
        (
            mqtt.Auth(properties=mqtt.Properties(authentication_method="m", authentication_data=b"secret")),
            "AUTH [authentication_method='m']",
        ),
    ],
)
def test_a_packet_has_words_without_secrets(packet: mqtt.Packet, words: str) -> None:
    assert packet_text(packet) == words


async def test_beyond_ten_thousand_the_oldest_message_is_forgotten_and_counted() -> None:
    journal = Journal()
    for number in range(10_003):
        journal.record(BrokerMessage("t", b"%d" % number, origin="lamp"))
    assert journal.forgotten == 3
    first = await journal.pop("t", None, 1.0)
    assert first is not None
    assert first.payload == b"3"


async def test_what_the_test_published_itself_is_not_kept() -> None:
    journal = Journal()
    journal.record(BrokerMessage("t", b"1"))
    assert journal.waiting("#") == []


async def test_only_one_of_two_that_wait_gets_the_message() -> None:
    journal = Journal()
    got: list[object] = []

    async def wait() -> None:
        got.append(await journal.pop("t", None, 0.05))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(wait)
        tasks.start_soon(wait)
        await anyio.lowlevel.checkpoint()
        journal.record(BrokerMessage("t", b"1", origin="lamp"))
    assert [each is None for each in got] == [False, True]
