"""Hostile clients against the embedded broker, over real sockets; what each attack cost is printed (``-s``)."""

import resource
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from itertools import product
from typing import Any

import pytest
from tests.patience import PATIENCE
from tests.sizes import nightly, size
from tests.system.broker_probe import PASSWORD, AttackedBroker, Client, Toll, attacked_broker, closing, is_closed
from tests.turns import slowness

from homebot.mqtt.packets import (
    Connect,
    MqttSubscription,
    Pingreq,
    Pingresp,
    Properties,
    Publish,
    ReasonCode,
    Suback,
    Subscribe,
    Will,
    encode,
)

pytestmark = [
    pytest.mark.no_cover,
    pytest.mark.system,
    pytest.mark.skipif(sys.platform != "linux", reason="reads /proc"),
]

LONGEST_TURN = 0.05  # seconds of the processor of the reference machine
MOST_MEMORY = 64
MOST_KEPT = 32
"""MiB after a flood: nothing is referenced any more, but glibc keeps freed messages of all sockets, about 20 MiB."""


@pytest.fixture
def broker() -> Iterator[AttackedBroker]:
    with attacked_broker() as broker:
        yield broker


@pytest.fixture(autouse=True)
def many_files() -> None:
    """An attacker has as many sockets as it likes."""
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 20_000), hard))


def withstood(broker: AttackedBroker, before: Toll, what: str, *, memory: float = MOST_MEMORY) -> Toll:
    """Print and check what an attack that goes on costs; an honest client is served all the same."""
    honest = broker.client("honest")
    began = time.monotonic()
    honest.send(Pingreq())
    assert honest.take() == Pingresp()
    answered = time.monotonic() - began
    honest.close()
    now = broker.toll()
    print(f"\n{what}: {now}, {now.rss - before.rss:+.0f} MiB, a ping took {answered * 1000:.0f} ms")
    assert now.rss < before.rss + memory
    assert now.turn < LONGEST_TURN * slowness()
    return now


def recovered(broker: AttackedBroker, before: Toll) -> Toll:
    """Check that no more is open than before, and that most of the memory is free again."""
    after = broker.settled(before)
    print(f"afterwards: {after}, {after.rss - before.rss:+.0f} MiB")
    assert after.left_open == before.left_open
    assert after.rss < before.rss + MOST_KEPT
    return after


def begun_connect() -> bytes:
    """As much of a CONNECT as a broker can be made to keep."""
    return encode(Connect("x" * 60_000, username="u" * 60_000, password=b"p" * 60_000))[:-1]


def flood(broker: AttackedBroker, count: int, data: bytes) -> list[socket.socket]:
    """Open many sockets and say *data* on each."""
    opened = []
    for _ in range(count):
        opened.append(socket.create_connection(("127.0.0.1", broker.port), timeout=PATIENCE))
        try:
            opened[-1].sendall(data)
        except OSError:  # the broker closed it already
            continue
    return opened


def test_sockets_that_never_log_in_take_little_memory_and_keep_nobody_out(broker: AttackedBroker) -> None:
    before = broker.toll()
    for _ in range(size(1, 3)):
        sockets = flood(broker, 2000, begun_connect())
        with closing(sockets):
            withstood(broker, before, "2,000 sockets with a CONNECT that does not end")
            assert [is_closed(each) for each in sockets].count(False) <= 256
    stats = recovered(broker, before).stats
    assert stats.logins_pushed_out + stats.unread_given_up > size(1500, 5000)


def test_sockets_that_say_nothing_take_little_memory(broker: AttackedBroker) -> None:
    before = broker.toll()
    with closing(flood(broker, size(1000, 4000), b"")):
        withstood(broker, before, "silent sockets")
    recovered(broker, before)


def test_packets_that_do_not_end_take_bounded_memory(broker: AttackedBroker) -> None:
    before = broker.toll()
    for turn in range(size(1, 3)):
        clients = []
        for number in range(size(60, 150)):
            clients.append(broker.client(f"{turn}-{number}").socket)
            announced = b"\x30\xff\xff\xff\x03" + encode(Publish("t", bytes(2_000_000)))[4:]
            clients[-1].sendall(announced)
        with closing(clients):
            withstood(broker, before, "clients with 2 MB each of a packet that does not end")
    recovered(broker, before)


@pytest.mark.parametrize(
    ("topics", "filters"),
    [
        pytest.param(
            [f"a/{one}/b/{two}" for one in range(200) for two in range(50)],
            [f"+/+/b/{number}" for number in range(460)],
            id="13.9 kB of wildcards",
        ),
        pytest.param([f"t/{number}" for number in range(10_000)], [f"f/{number}" for number in range(5000)], id="many"),
        pytest.param(
            ["/".join(levels) for levels in product("abc", repeat=8)],
            ["/".join(levels) for levels in product("a+", repeat=8)],
            id="all ways to put a plus",
        ),
    ],
)
def test_no_subscribe_stops_the_others(broker: AttackedBroker, topics: list[str], filters: list[str]) -> None:
    keeper = broker.client("keeper")
    for start in range(0, len(topics), 1000):
        keeper.send(*(Publish(topic, b"x", 0, retain=True) for topic in topics[start : start + 1000]))
    keeper.send(Pingreq())
    keeper.take()
    keeper.close()
    before = broker.toll()
    client = broker.client("subscriber")
    client.send(Subscribe(1, tuple(MqttSubscription(each) for each in filters)))
    withstood(
        broker, before, f"a SUBSCRIBE with {len(filters)} filters over {len(topics)} retained messages", memory=32
    )
    received = 0
    while not isinstance(client.take(), Suback):
        pass
    client.send(Pingreq())
    while not isinstance(client.take(), Pingresp):
        received += 1
    client.close()
    after = recovered(broker, before)
    print(f"the subscriber got {received} of its retained messages before its ping was answered")
    assert after.turn < LONGEST_TURN * slowness()


def test_a_flood_of_small_messages_to_many_stops_nobody(broker: AttackedBroker) -> None:
    before = broker.toll()
    listeners = [broker.client(f"l{number}") for number in range(200)]
    for listener in listeners:
        listener.send(Subscribe(1, (MqttSubscription("t", 0),)))
        listener.take()
    publisher = broker.client("publisher")
    with closing([each.socket for each in (*listeners, publisher)]):
        for _ in range(4):
            publisher.socket.sendall(encode(Publish("t")) * 2700)
        withstood(broker, before, "10,800 messages to 200 clients that do not read")
    recovered(broker, before)


@pytest.mark.parametrize("listeners", [pytest.param(0, marks=nightly), 20])
def test_floods_of_48_clients_share_one_turn(broker: AttackedBroker, listeners: int) -> None:
    """The share is that of the broker, not of each connection."""
    before = broker.toll()
    deaf = [subscribed(broker, f"l{number}", "t", 0) for number in range(listeners)]
    floods = [broker.client(f"f{number}") for number in range(48)]
    data = encode(Publish("t")) * 3000
    with closing([each.socket for each in (*deaf, *floods)]):
        for each in floods:
            each.socket.setblocking(False)
        for _ in range(size(2, 6)):
            for each in floods:
                with suppress(BlockingIOError):
                    each.socket.send(data)
        toll = withstood(broker, before, f"floods of 48 clients to {listeners} others")
    assert toll.turn < 0.05 * slowness()
    recovered(broker, before)


def test_48_publishers_that_go_with_much_held_back_share_one_turn(broker: AttackedBroker) -> None:
    before = broker.toll()
    slow = subscribed(broker, "slow", "t", 1)
    groups = broker.client("groups")
    groups.send(Subscribe(1, tuple(MqttSubscription(f"$share/{number}/t", 0) for number in range(20))))
    publishers = [broker.client(f"p{number}") for number in range(49)]
    with closing([each.socket for each in (slow, groups, *publishers)]):
        for each, count in zip(publishers, (7600, *[300] * 48), strict=True):
            each.send(*(Publish("t", b"x", 1, packet_id=number + 1) for number in range(count)), Pingreq())
            while not isinstance(each.take(), Pingresp):
                pass
        assert broker.toll().stats.holds == 49
        for each in publishers:
            each.close()
        withstood(broker, before, "48 publishers that have gone, with 300 messages each that were held back")
    assert recovered(broker, before).turn < LONGEST_TURN * slowness()


def test_twenty_replays_of_many_retained_messages_share_one_turn(broker: AttackedBroker) -> None:
    count = size(10_000, 50_000)
    keeper = broker.client("keeper")
    for start in range(0, count, 1000):
        keeper.send(*(Publish(f"r/{number}", b"x", 0, retain=True) for number in range(start, start + 1000)))
    keeper.send(Pingreq())
    keeper.take()
    before = broker.toll()
    clients = [broker.client(f"c{number}") for number in range(20)]
    with closing([each.socket for each in clients]):
        for each in clients:
            each.send(Subscribe(1, (MqttSubscription("#"),)))
        toll = withstood(broker, before, f"20 subscriptions to {count:,} retained messages")
        for each in clients:
            assert isinstance(each.take(), Suback)
        received = sum(isinstance(clients[-1].take(), Publish) for _ in range(count))
    assert received == count
    assert max(toll.turn, broker.toll().turn) < 0.05 * slowness()
    keeper.close()


def test_passwords_are_guessed_slowly_and_a_known_client_comes_in_at_once() -> None:
    with attacked_broker(user="u") as broker:
        before = broker.toll()
        broker.client("lamp", username="u", password=PASSWORD.encode()).close()
        guesses = [
            encode(Connect("guesser", username="u", password=str(number).encode())) for number in range(size(500, 2000))
        ]
        began = time.monotonic()
        sockets = [broker.open(guess) for guess in guesses]
        with closing(sockets):
            honest = broker.client("lamp", username="u", password=PASSWORD.encode())
            assert honest.connack.reason is ReasonCode.SUCCESS
            honest.close()
            toll = broker.toll()
            took = time.monotonic() - began
            print(f"\n{len(guesses):,} guesses in {took:.1f} s: {toll.stats.logins_failed} were looked at; {toll}")
            assert toll.stats.logins_failed <= 4 + took / 0.5
            assert toll.turn < LONGEST_TURN * slowness()
        recovered(broker, before)


def subscribed(broker: AttackedBroker, name: str, topic: str, qos: int, **more: Any) -> Client:
    client = broker.client(name, **more)
    client.send(Subscribe(1, (MqttSubscription(topic, qos),)))
    assert isinstance(client.take(), Suback)
    return client


def test_clients_that_do_not_read_take_bounded_memory(broker: AttackedBroker) -> None:
    before = broker.toll()
    for turn in range(size(1, 2)):
        deaf = [subscribed(broker, f"{turn}-{number}", f"deaf/{number}", 0) for number in range(60)]
        for each in deaf:  # else it depends on the system how many MB of 12 it takes for a socket that nobody reads
            each.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 64 * 1024)
        publisher = broker.client("publisher")
        with closing([each.socket for each in (*deaf, publisher)]):
            for _ in range(size(12, 24)):
                for number in range(60):
                    publisher.send(Publish(f"deaf/{number}", bytes(500_000)))
            publisher.send(Pingreq())
            publisher.take()
            withstood(broker, before, "messages for 60 clients that do not read")
    stats = recovered(broker, before).stats
    print(f"{stats.clients_stalled} were cut off, {stats.dropped_qos0} messages dropped")
    assert stats.clients_stalled > size(15, 30)


def test_clients_that_do_not_acknowledge_take_bounded_memory(broker: AttackedBroker) -> None:
    before = broker.toll()
    mute = [subscribed(broker, f"mute{number}", f"mute/{number}", 1) for number in range(50)]
    publisher = broker.client("publisher")
    with closing([each.socket for each in (*mute, publisher)]):
        for count in range(40):
            for number in range(50):
                publisher.send(Publish(f"mute/{number}", bytes(100_000), 1, packet_id=count * 50 + number + 1))
                for each in mute[number : number + 1]:
                    each.socket.setblocking(False)
                    with suppress(BlockingIOError, ConnectionError):
                        while each.socket.recv(1 << 20):
                            pass
                publisher.take()
        withstood(broker, before, "200 MB for 50 clients that do not acknowledge")
    recovered(broker, before)


def test_sessions_that_nobody_comes_back_for_take_bounded_memory(broker: AttackedBroker) -> None:
    before = broker.toll()
    forever = Properties(session_expiry_interval=0xFFFF_FFFF)
    subscribed(broker, "kept", "to/kept", 1, properties=forever).close()
    publisher = broker.client("publisher")
    publisher.send(Publish("to/kept", b"kept", 1, packet_id=1))
    publisher.take()
    for number in range(400):
        subscribed(broker, f"left{number}", f"to/left{number}", 1, properties=forever).close()
    for count in range(3):
        for number in range(400):
            publisher.send(Publish(f"to/left{number}", bytes(100_000), 1, packet_id=2))
            publisher.take()
        print(f"\nround {count}: {broker.toll()}")
    withstood(broker, before, "120 MB for 400 sessions without a client")
    honest = broker.client("kept", clean_start=False, properties=forever)
    kept = honest.take()
    assert isinstance(kept, Publish)
    assert kept.payload == b"kept"
    honest.close()
    publisher.close()
    assert broker.toll().stats.dropped_offline > 500


def test_retained_messages_take_bounded_memory(broker: AttackedBroker) -> None:
    before = broker.toll()
    publisher = broker.client("publisher")
    for number in range(1000):
        publisher.send(Publish(f"r/{number}", bytes(100_000), 1, True, packet_id=1))
        publisher.take()
    for number in range(size(15_000, 60_000)):
        publisher.send(Publish(f"s/{number}", b"x", 0, True))
    publisher.send(Pingreq())
    publisher.take()
    now = withstood(broker, before, "100 MB and many topics of retained messages")
    assert now.stats.retained_refused > 600
    publisher.close()


def test_wills_take_bounded_memory(broker: AttackedBroker) -> None:
    before = broker.toll()
    will = Will("w", bytes(65_000), properties=Properties(will_delay_interval=1000))
    clients = []
    refused = 0
    for number in range(600):
        opened = broker.open()
        client = Client(opened, Connect(f"w{number}", will=will, properties=Properties(session_expiry_interval=2000)))
        refused += client.connack.reason.failed
        clients.append(opened)
    with closing(clients):
        withstood(broker, before, f"600 wills of 65 kB, {refused} refused", memory=32)
    assert refused > 400


def test_clients_that_come_and_go_leave_nothing(broker: AttackedBroker) -> None:
    """Each comes, subscribes, publishes and goes without a word; a third takes over the id of another."""
    before = broker.toll()
    began = time.monotonic()
    for number in range(size(400, 1500)):
        client = broker.client(f"c{number % 3}" if number % 3 else f"n{number}")
        client.send(Subscribe(1, (MqttSubscription(f"t/{number}/#", 1),)), Publish(f"t/{number}", bytes(1000)))
        client.close()
    withstood(broker, before, f"logins in {time.monotonic() - began:.1f} s", memory=16)
    recovered(broker, before)
