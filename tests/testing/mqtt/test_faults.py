"""What a test can let go wrong."""

from collections.abc import Iterator

import anyio
import pytest
from tests.testing.mqtt.conftest import Join

from homebot.errors import InvalidNameError, UsageError
from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import BrokerLimits
from homebot.testing.mqtt import BlockingTestBroker, BrokerSettings, TestBroker, broker_thread, serve_broker

V311 = mqtt.ProtocolVersion.V311
SMALL = BrokerSettings(limits=BrokerLimits(write_buffer=1000))


def message(number: int, topic: str = "lamp") -> mqtt.Publish:
    return mqtt.Publish(topic, b"on", 1, packet_id=number)


async def test_a_dropped_connection_ends_without_a_disconnect(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    await mqtt_broker.faults.drop_connection("lamp")
    with pytest.raises(EOFError):
        await lamp.take()


async def test_only_connected_clients_can_be_dropped(mqtt_broker: TestBroker, join: Join) -> None:
    await join("door")
    with pytest.raises(UsageError, match="no client 'lamp' is connected; connected: door"):
        await mqtt_broker.faults.drop_connection("lamp")


async def test_a_client_is_sent_away_with_a_reason(mqtt_broker: TestBroker, join: Join) -> None:
    lamp, door = await join("lamp"), await join("door")
    await mqtt_broker.faults.disconnect("lamp", mqtt.ReasonCode.SERVER_BUSY)
    await mqtt_broker.faults.take_over("door")
    assert await lamp.take() == mqtt.Disconnect(mqtt.ReasonCode.SERVER_BUSY)
    assert await door.take() == mqtt.Disconnect(mqtt.ReasonCode.SESSION_TAKEN_OVER)


async def test_dropped_acknowledgements_concern_one_client_and_end_with_the_block(
    mqtt_broker: TestBroker, join: Join
) -> None:
    lamp, door = await join("lamp"), await join("door")
    with mqtt_broker.faults.drop_acks("lamp") as fault:
        await lamp.send(message(1), mqtt.Pingreq())
        assert await lamp.take() == mqtt.Pingresp()
        assert isinstance(await door.call(message(1)), mqtt.Puback)
        assert fault.hits == 1
    assert isinstance(await lamp.call(message(2)), mqtt.Puback)
    assert (await mqtt_broker.expect("lamp")).client_id == "lamp"


async def test_delayed_acknowledgements_are_overtaken(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    with mqtt_broker.faults.delay_acks(0.02):
        await lamp.send(message(1), mqtt.Pingreq())
        assert [await lamp.take(), await lamp.take()] == [
            mqtt.Pingresp(),
            mqtt.Puback(1, mqtt.ReasonCode.NO_MATCHING_SUBSCRIBERS),
        ]


async def test_a_refused_subscription_is_answered_with_the_reason(mqtt_broker: TestBroker, join: Join) -> None:
    lamp, door = await join("lamp"), await join("door")
    request = mqtt.Subscribe(1, (mqtt.MqttSubscription("a"), mqtt.MqttSubscription("b")))
    with mqtt_broker.faults.refuse_subscribe("a", "lamp", mqtt.ReasonCode.QUOTA_EXCEEDED):
        assert await lamp.call(request) == mqtt.Suback(1, (mqtt.ReasonCode.QUOTA_EXCEEDED, mqtt.ReasonCode.SUCCESS))
        assert await door.call(request) == mqtt.Suback(1, (mqtt.ReasonCode.SUCCESS, mqtt.ReasonCode.SUCCESS))
    assert await lamp.call(request) == mqtt.Suback(1, (mqtt.ReasonCode.SUCCESS, mqtt.ReasonCode.SUCCESS))


async def test_a_refused_message_is_answered_and_not_forwarded(mqtt_broker: TestBroker, join: Join) -> None:
    lamp, old = await join("lamp"), await join("old", V311)
    with mqtt_broker.faults.refuse_publish("lamp/+") as fault:
        assert await lamp.call(message(1, "lamp/a")) == mqtt.Puback(1, mqtt.ReasonCode.NOT_AUTHORIZED)
        assert await old.call(message(1, "lamp/a")) == mqtt.Puback(1)
        await lamp.call(message(2, "lamp"))
        assert fault.hits == 2
    await mqtt_broker.expect("lamp")
    mqtt_broker.assert_not_published("lamp/+")


async def test_half_a_packet_comes_and_then_the_end(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    await lamp.call(mqtt.Subscribe(1, (mqtt.MqttSubscription("lamp"),)))
    fault = mqtt_broker.faults.half_packet("lamp")
    await mqtt_broker.publish("lamp", "0123456789")
    with pytest.raises(EOFError):
        await lamp.take()
    whole = mqtt.encode(mqtt.Publish("lamp", b"0123456789"))
    assert lamp.unread == whole[: len(whole) // 2]
    assert fault.hits == 1
    again = await join("lamp")
    assert await again.call(mqtt.Pingreq()) == mqtt.Pingresp()


async def test_a_slow_reader_gets_everything_that_must_come_when_it_reads_again(
    mqtt_broker: TestBroker, join: Join
) -> None:
    lamp = await join("lamp")
    await lamp.call(mqtt.Subscribe(1, (mqtt.MqttSubscription("lamp", 1),)))
    with mqtt_broker.faults.slow_reader("lamp"):
        for number in range(100):
            await mqtt_broker.publish("lamp", str(number), qos=1)
        await mqtt_broker.publish("lamp", "lost", qos=0)
        assert mqtt_broker.clients["lamp"].queued == 100
        await lamp.send(mqtt.Pingreq())
    got: list[int] = []
    while len(got) < 100:
        packet = await lamp.take()
        if isinstance(packet, mqtt.Publish) and packet.packet_id:
            got.append(int(packet.payload))
            await lamp.send(mqtt.Puback(packet.packet_id))
    assert got == list(range(100))


@pytest.fixture
def tight_broker() -> Iterator[TestBroker]:
    with broker_thread() as thread, serve_broker(thread, TestBroker, SMALL) as broker:
        yield broker


async def test_a_slow_reader_that_goes_on_asking_is_cut_off_before_memory_is_full(tight_broker: TestBroker) -> None:
    tight_broker.faults.slow_reader("lamp")
    async with await anyio.connect_tcp(tight_broker.host, tight_broker.port) as stream:
        await stream.send(mqtt.encode(mqtt.Connect("lamp")) + mqtt.encode(mqtt.Pingreq()) * 501)
        with pytest.raises((anyio.EndOfStream, anyio.BrokenResourceError)):
            await stream.receive()
    assert "fault: connection dropped" in tight_broker.packet_log.text()


async def test_an_acknowledgement_cannot_be_early(mqtt_broker: TestBroker) -> None:
    with pytest.raises(UsageError, match="cannot be 0 s late"):
        mqtt_broker.faults.delay_acks(0)


async def test_a_refusal_needs_a_filter_and_a_reason_that_fails(mqtt_broker: TestBroker) -> None:
    with pytest.raises(InvalidNameError):
        mqtt_broker.faults.refuse_publish("a/#/b")
    with pytest.raises(UsageError, match="refuses nothing"):
        mqtt_broker.faults.refuse_subscribe("a", reason=mqtt.ReasonCode.SUCCESS)


async def test_all_faults_end_together(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    mqtt_broker.faults.drop_acks()
    mqtt_broker.faults.refuse_subscribe("a")
    mqtt_broker.faults.lift_all()
    assert isinstance(await lamp.call(message(1)), mqtt.Puback)


def test_blocking_tests_have_the_same_faults(mqtt_broker_thread: BlockingTestBroker) -> None:
    with pytest.raises(UsageError, match="connected: nobody"):
        mqtt_broker_thread.faults.take_over("lamp")
    with mqtt_broker_thread.faults.drop_acks() as fault:
        assert fault.hits == 0
