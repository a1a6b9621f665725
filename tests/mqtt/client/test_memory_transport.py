"""What a link in memory can do beside the contract: be cut, frozen and slow, and run where time is virtual."""

import asyncio
from collections.abc import AsyncIterator
from dataclasses import replace
from random import Random

import anyio
import anyio.lowlevel
import pytest

from homebot.errors import LinkError, RefusedError, UsageError
from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import BrokerLimits
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.client.requests import Requests
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.support.unanswered import SENT_REQUESTS, SentRequests

pytestmark = pytest.mark.virtual_time


@pytest.fixture
async def broker() -> AsyncIterator[MemoryBroker]:
    async with MemoryBroker(limits=BrokerLimits(write_buffer=2_000)) as broker:
        yield broker


@pytest.fixture
def options(broker: MemoryBroker) -> MqttOptions:
    return MqttOptions.from_url(broker.url, client_id="hub")


def now() -> float:
    return asyncio.get_running_loop().time()


class RawClient:
    """Speaks packets, so that it can ask for what the client port does not know."""

    def __init__(self, broker: MemoryBroker) -> None:
        self.packets: list[mqtt.Packet] = []
        self.ended = anyio.Event()
        self.socket = broker.dial(broker.host, broker.port, self)
        self._reader = mqtt.PacketReader(mqtt.ProtocolVersion.V5)

    def say(self, *packets: mqtt.Packet) -> None:
        self.socket.write(b"".join(mqtt.encode(packet, mqtt.ProtocolVersion.V5) for packet in packets))

    def data_received(self, data: bytes) -> None:
        self.packets += self._reader.feed(data)

    def drained(self) -> None:
        pass

    def link_ended(self, reason: LinkError | RefusedError) -> None:  # noqa: ARG002 - the port's own
        self.ended.set()


async def test_nothing_takes_time(broker: MemoryBroker, options: MqttOptions) -> None:
    client = broker.make_client(options)
    async with client.connected():
        await client.subscribe(MqttSubscription("t", 2))
        await client.publish("t", b"x", qos=2)
        assert await client.receive() == [MqttMessage("t", b"x", 2)]
    assert now() == 0.0


@pytest.mark.parametrize(("pause", "expiries"), [(4.0, [6]), (11.0, [])])
async def test_a_publish_of_qos_2_goes_on_on_the_next_link_until_it_expires(
    broker: MemoryBroker, options: MqttOptions, pause: float, expiries: list[int]
) -> None:
    """A command that its issuer has given up must not be carried out when the broker is back."""
    listener = broker.make_client(replace(options, client_id="listener"))
    client = broker.make_client(replace(options, session_expiry=3_600, timeout=1.0))
    async with listener.connected():
        await listener.subscribe(MqttSubscription("+", 2))
        async with client.connected():
            broker.link_of("hub").freeze()
            with pytest.raises(LinkError):
                await client.publish("lamp", b"on", qos=2, properties=mqtt.Properties(message_expiry_interval=10))
            broker.link_of("hub").abort()
        await anyio.sleep(pause - now())
        async with client.connected():
            await client.publish("end", qos=2)
            received = await listener.receive()
    assert [one.properties.message_expiry_interval for one in received] == [*expiries, None]


async def test_a_request_that_left_is_told_from_one_that_did_not(broker: MemoryBroker, options: MqttOptions) -> None:
    client = broker.make_client(options)
    requests = SentRequests()
    SENT_REQUESTS.set(requests)
    async with client.connected():
        await client.publish("t", b"x", qos=1)
        assert not requests.is_unanswered
        broker.link_of("hub").freeze()
        with anyio.move_on_after(5):
            await client.publish("t", b"x", qos=1)
        assert requests.is_unanswered
    requests.is_unanswered = False
    with pytest.raises(LinkError):
        await client.publish("t", b"x", qos=1)
    assert not requests.is_unanswered


async def test_who_breaks_the_protocol_is_told_why(broker: MemoryBroker) -> None:
    client = RawClient(broker)
    client.say(mqtt.Connect("a"), mqtt.Connect("a"))
    await client.ended.wait()
    assert client.packets[-1] == mqtt.Disconnect(
        mqtt.ReasonCode.PROTOCOL_ERROR, mqtt.Properties(reason_string="a client must not send Connect")
    )


async def test_a_client_that_does_not_read_loses_only_qos_0(broker: MemoryBroker, options: MqttOptions) -> None:
    """Its link is choked from the limit on, and goes on where it stopped when it is read again."""
    reader = broker.make_client(options)
    writer = broker.make_client(replace(options, client_id="writer"))
    async with reader.connected(), writer.connected():
        await reader.subscribe(MqttSubscription("t", 1))
        link = broker.link_of("hub")
        link.socket.pause_reading()
        for number in range(100):
            await writer.publish("t", b"%0100d" % number, qos=number % 2)
        assert link.write_blocked
        link.socket.resume_reading()
        got: list[bytes] = []
        while len(got) < 50 or got[-1] != b"%0100d" % 99:
            batch = await reader.receive()
            got += [message.payload for message in batch]
            reader.ack(batch)
        assert [payload for payload in got if int(payload) % 2] == [b"%0100d" % number for number in range(1, 100, 2)]
        assert broker.stats.dropped_qos0 == 100 - len(got) > 0


async def test_a_window_bounds_what_is_open_and_a_lost_link_sets_those_free_who_wait(options: MqttOptions) -> None:
    async with MemoryBroker(limits=BrokerLimits(receive_maximum=2)) as broker:
        client = broker.make_client(options)
        failed: list[LinkError] = []

        async def publish(number: int) -> None:
            try:
                await client.publish(f"t/{number}", qos=2)
            except LinkError as error:
                failed.append(error)

        async with client.connected():
            async with anyio.create_task_group() as tasks:
                for number in range(10):
                    tasks.start_soon(publish, number)
            assert broker.stats.messages_received == 10
            broker.link_of("hub").freeze()
            async with anyio.create_task_group() as tasks:
                for number in range(10):
                    tasks.start_soon(publish, number)
                await anyio.sleep(1)
                broker.link_of("hub").abort()
                broker.link_of("hub").thaw()
        assert [str(error) for error in failed] == [
            "publish failed, the link is lost: the broker closed the connection"
        ] * 10


async def test_each_answer_is_overdue_in_its_own_time() -> None:
    requests = Requests(Random(1), 3.0)  # noqa: S311 - no secret
    answers = []
    for number in (1, 2, 3):
        answers.append(requests.expect(number))
        await anyio.sleep(1)
    requests.answered(2, (0,))
    for answer, overdue in zip(answers[::2], (3.0, 5.0), strict=True):
        with pytest.raises(TimeoutError):
            await answer
        assert now() == overdue
    assert await answers[1] == (0,)


async def test_only_this_broker_can_be_reached_and_only_while_it_runs(options: MqttOptions) -> None:
    broker = MemoryBroker()
    with pytest.raises(UsageError, match="never started"):
        _ = broker.stats
    client = broker.make_client(options)
    with pytest.raises(LinkError, match="is not running"):
        async with client.connected():
            pass
    async with broker:
        stranger = broker.make_client(replace(options, host="10.0.0.1"))
        with pytest.raises(LinkError, match=r"nothing answers at 10\.0\.0\.1 port 1883"):
            async with stranger.connected():
                pass
        with pytest.raises(UsageError, match="no client 'x' is connected; there are: none"):
            broker.link_of("x")
        with pytest.raises(UsageError, match="no TLS"):
            broker.make_client(MqttOptions.from_url("mqtts://memory:1883"))


async def test_too_many_links_are_turned_away(options: MqttOptions) -> None:
    async with MemoryBroker(limits=BrokerLimits(max_connections=1)) as broker:
        strangers = [RawClient(broker) for _ in range(2)]
        with pytest.raises(LinkError, match="too many connections"):
            async with broker.make_client(options).connected():
                pass
        assert len(strangers) == len(broker.links) == 2


def test_a_seed_fixes_the_packet_identifiers() -> None:
    """Without one they begin anywhere, so that a restarted process does not meet those of its predecessor."""
    first, again, other = (Requests(Random(seed), 1.0).new_id() for seed in (1, 1, 2))  # noqa: S311 - no secret
    assert first == again != other


async def test_a_seed_fixes_assigned_client_ids() -> None:
    """Without one nobody can guess them."""
    assigned = []
    for random in (Random(1), Random(1), None, None):  # noqa: S311 - as above
        async with MemoryBroker(random=random) as broker:
            client = RawClient(broker)
            client.say(mqtt.Connect(""))
            await anyio.sleep(0.001)
            assigned.append(broker.links[0].peer.client_id)
    first, again, secret, other = assigned
    assert first == again
    assert len({first, secret, other}) == 3


@pytest.mark.parametrize("qos", [0, 1, 2])
async def test_what_cannot_be_said_is_the_callers_mistake_and_harms_nobody(
    broker: MemoryBroker, options: MqttOptions, qos: int
) -> None:
    client = broker.make_client(options)
    properties = mqtt.Properties(content_type="x" * 70_000)
    async with client.connected():
        for _ in range(200):  # more than may be open at once
            with pytest.raises(UsageError):
                await client.publish("t", qos=qos, properties=properties)
        await client.publish("t", qos=qos)


async def test_a_publish_that_is_given_up_makes_room(broker: MemoryBroker, options: MqttOptions) -> None:
    client = broker.make_client(options)
    async with client.connected():
        broker.link_of("hub").freeze()
        async with anyio.create_task_group() as tasks:
            for _ in range(200):
                tasks.start_soon(_publish, client)
            await anyio.sleep(1)
            tasks.cancel_scope.cancel()
        broker.link_of("hub").thaw()
        await client.publish("t", qos=1)


async def _publish(client: MqttClient) -> None:
    await client.publish("t", qos=1)
