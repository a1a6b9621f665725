"""The mark that says what a broker is to be like, and clients that break the protocol."""

import ssl

import aiomqtt
import anyio
import pytest
from tests.testing.mqtt.conftest import Join

from homebot.errors import UsageError
from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import BrokerLimits
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.options import MqttOptions
from homebot.testing.mqtt import BlockingTestBroker, BrokerSettings, TestBroker


@pytest.mark.mqtt_broker(user="u", password="right")
async def test_a_password_is_asked_for(mqtt_broker: TestBroker) -> None:
    with pytest.raises(aiomqtt.MqttError, match=r"Not authorized|Bad user name"):
        await aiomqtt.Client(mqtt_broker.host, mqtt_broker.port, username="u", password="wrong").__aenter__()
    async with aiomqtt.Client(mqtt_broker.host, mqtt_broker.port, username="u", password="right") as client:
        await client.publish("t", "hello")
    await mqtt_broker.expect("t", "hello")


@pytest.mark.mqtt_broker(tls=True)
async def test_tls_serves_clients_that_trust_its_authority(mqtt_broker: TestBroker) -> None:
    assert mqtt_broker.url == f"mqtts://127.0.0.1:{mqtt_broker.port}"
    assert mqtt_broker.ca_file is not None
    trusting = ssl.create_default_context(cafile=mqtt_broker.ca_file)
    async with aiomqtt.Client("localhost", mqtt_broker.port, tls_context=trusting) as client:
        await client.publish("t", "from aiomqtt")
        await mqtt_broker.expect("t", "from aiomqtt")
    own = AiomqttClient(MqttOptions(host="127.0.0.1", port=mqtt_broker.port, tls=True, ca_file=mqtt_broker.ca_file))
    async with own.connected():
        await own.publish("t", b"from homebot")
        await mqtt_broker.expect("t", "from homebot")


@pytest.mark.mqtt_broker(tls=True)
def test_tls_is_there_for_blocking_tests_too(mqtt_broker_thread: BlockingTestBroker) -> None:
    assert mqtt_broker_thread.url.startswith("mqtts://")
    assert mqtt_broker_thread.ca_file is not None


async def test_without_tls_there_is_no_authority(mqtt_broker: TestBroker) -> None:
    assert mqtt_broker.ca_file is None


@pytest.mark.mqtt_broker(keep_alive=7, refuse_filter=["secret/#", "b"], limits=BrokerLimits(receive_maximum=3))
async def test_keep_alive_filters_and_limits_are_those_of_the_mark(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    answer = await lamp.call(mqtt.Subscribe(1, tuple(mqtt.MqttSubscription(one, 0) for one in ("secret/#", "t", "b"))))
    refused = mqtt.ReasonCode.UNSPECIFIED_ERROR
    assert answer == mqtt.Suback(1, (refused, mqtt.ReasonCode.SUCCESS, refused))
    welcome = next(each.what for each in mqtt_broker.packet_log.records if isinstance(each.what, mqtt.Connack))
    assert (welcome.properties.server_keep_alive, welcome.properties.receive_maximum) == (7, 3)


@pytest.mark.mqtt_broker(refuse_filter="a")
async def test_a_fault_comes_before_the_filters_of_the_mark(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    with mqtt_broker.faults.refuse_subscribe("a", reason=mqtt.ReasonCode.QUOTA_EXCEEDED):
        assert await lamp.call(mqtt.Subscribe(1, (mqtt.MqttSubscription("a", 0),))) == mqtt.Suback(
            1, (mqtt.ReasonCode.QUOTA_EXCEEDED,)
        )
    assert await lamp.call(mqtt.Subscribe(2, (mqtt.MqttSubscription("a", 0),))) == mqtt.Suback(
        2, (mqtt.ReasonCode.UNSPECIFIED_ERROR,)
    )


@pytest.mark.mqtt_broker(allow_protocol_errors=True)
async def test_a_breach_is_kept_with_its_client_and_reason(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    await lamp.send(mqtt.Pingresp())
    await lamp.take()
    (breach,) = mqtt_broker.protocol_errors
    assert (breach.client, breach.reason) == ("lamp", mqtt.ReasonCode.PROTOCOL_ERROR)
    assert str(breach) == ("client 'lamp' broke the protocol: a client must not send Pingresp (0x82, protocol error)")
    mqtt_broker.forget_protocol_errors()
    assert mqtt_broker.protocol_errors == ()


async def test_what_a_fault_led_to_is_no_breach(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    with mqtt_broker.faults.drop_acks("lamp"):
        await lamp.send(mqtt.Publish("t", b"on", 1, packet_id=1))
        await mqtt_broker.expect("t")
    await lamp.send(mqtt.Pingresp())
    await lamp.take()
    assert mqtt_broker.protocol_errors == ()


async def test_a_version_that_the_broker_does_not_speak_is_no_breach(mqtt_broker: TestBroker) -> None:
    async with await anyio.connect_tcp(mqtt_broker.host, mqtt_broker.port) as stream:
        await stream.send(bytes.fromhex("100d 0004 4d515454 06 02 003c 0001 61"))
        assert await stream.receive() == bytes.fromhex("2003 00 84 00")
    assert mqtt_broker.protocol_errors == ()


@pytest.mark.mqtt_broker(allow_protocol_errors=True)
async def test_many_breaches_are_kept_in_part_and_counted(mqtt_broker: TestBroker, join: Join) -> None:
    for number in range(22):
        client = await join(f"c{number}")
        await client.send(mqtt.Connect("again", mqtt.ProtocolVersion.V5))
        await client.take()
    assert [each.client for each in mqtt_broker.protocol_errors] == [f"c{number}" for number in range(20)]
    assert mqtt_broker._core.breaches.untold == 2


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"keepalive": 5}, "there is no argument 'keepalive'; did you mean keep_alive?"),
        ({"colour": 5}, "there is no argument 'colour'; there are: user, password, tls, keep_alive"),
        ({"user": "u"}, "user and password go together"),
        ({"user": 5, "password": "p"}, "user is text, not 5"),
        ({"tls": "yes"}, "tls is True or False, not 'yes'"),
        ({"keep_alive": 0}, "a keep-alive of 0 s is not from 1 to 65535"),
        ({"keep_alive": True}, "keep_alive is a whole number of seconds, not True"),
        ({"keep_alive": 1.5}, "keep_alive is a whole number of seconds, not 1.5"),
        ({"limits": {"max_queued_messages": 3}}, "limits is a BrokerLimits, not {"),
        ({"refuse_filter": 7}, "refuse_filter is a topic filter or a list of them, not 7"),
        ({"refuse_filter": "a/#/b"}, "topic filter 'a/#/b' has # before its end"),
        ({"refuse_filter": [7]}, "refuse_filter is a topic filter or a list of them, not 7"),
        ({"allow_protocol_errors": 1}, "allow_protocol_errors is True or False, not 1"),
    ],
)
def test_a_wrong_argument_is_refused_in_words(arguments: dict[str, object], problem: str) -> None:
    with pytest.raises(UsageError) as caught:
        BrokerSettings.parse(arguments)
    assert problem in str(caught.value)


def test_a_password_is_never_shown() -> None:
    with pytest.raises(UsageError) as caught:
        BrokerSettings.parse({"user": "u", "password": b"hunter2"})
    settings = BrokerSettings(user="u", password="hunter2", limits=BrokerLimits())
    assert "hunter2" not in f"{caught.value} {settings}"
