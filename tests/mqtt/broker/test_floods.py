"""What all clients together may have the broker keep, and who loses when it is more."""

from random import Random

import pytest
from tests.mqtt.broker.conftest import Join, MemoryClient, NewState, Stranger

from homebot.clock import ManualClock
from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import BrokerState

FOREVER = 0xFFFF_FFFF
MIB = 1024 * 1024


@pytest.fixture
def small(new_state: NewState) -> BrokerState:
    return new_state(max_all_queued_bytes=MIB, max_queued_bytes=600_000, max_sessions=20)


def relieve(state: BrokerState) -> None:
    state.deadlines.run(state.clock.monotonic())


def absent(join: Join, state: BrokerState, name: str) -> None:
    client = join(name, at=state, session_expiry_interval=FOREVER)
    client.subscribe(f"to/{name}")
    client.lose()


def test_the_sessions_for_which_most_waits_lose_their_oldest(small: BrokerState, join: Join) -> None:
    absent(join, small, "honest")
    for number in range(10):
        absent(join, small, f"flood{number}")
    publisher = join("p", at=small)
    for number in range(20):
        publisher.publish("to/honest", b"%d" % number, 1, 1)
    for number in range(300):
        publisher.publish(f"to/flood{number % 10}", bytes(20_000), 1, 1)
        relieve(small)
        assert small.queued.used < MIB + 30_000
    assert small.stats.dropped_offline > 200
    honest = join("honest", at=small, clean=False, present=True)
    assert [message.payload for message in honest.messages()] == [b"%d" % number for number in range(20)]


def test_a_message_that_waits_for_many_counts_once(small: BrokerState, join: Join) -> None:
    for number in range(15):
        client = join(f"s{number}", at=small, session_expiry_interval=FOREVER, to="all")
        client.lose()
    publisher = join("p", at=small)
    for _ in range(8):
        publisher.publish("all", bytes(50_000), 1, 1)
    relieve(small)
    assert small.stats.dropped_offline == 0
    assert small.stats.queued_messages == 15 * 8


@pytest.mark.parametrize("acknowledges", [True, False])
def test_the_connected_client_for_which_most_waits_is_cut_off(
    small: BrokerState,
    join: Join,
    acknowledges: bool,  # noqa: FBT001 - by name
) -> None:
    """It reads nothing, or reads and acknowledges nothing; one that is a little behind stays."""
    behind, stuck, second, third = (join(name, at=small) for name in ("behind", "stuck", "second", "third"))
    publisher = join("p", at=small)
    for client in (behind, stuck, second, third):
        client.subscribe(f"to/{client.peer.client_id}")
        client.link.write_blocked = acknowledges
    publisher.publish("to/behind", bytes(5000), 1, 1)
    for name, count in (("stuck", 18), ("second", 15), ("third", 15)):
        for _ in range(count):
            publisher.publish(f"to/{name}", bytes(24_000), 1, 1)
    relieve(small)
    assert small.queued.used <= MIB
    assert small.stats.clients_stalled >= 1
    assert stuck.link.closed
    assert [client.link.closed for client in (behind, second, third)] == [False] * 3
    assert any(packet.reason is mqtt.ReasonCode.QUOTA_EXCEEDED for packet in stuck.take_only(mqtt.Disconnect))


def test_what_is_counted_is_gone_when_the_sessions_are(new_state: NewState, join: Join, clock: ManualClock) -> None:
    """Whatever clients do in between."""
    random = Random(7)  # noqa: S311 - a test that is the same each time
    state = new_state(max_queued_messages=20, max_inflight=5)
    clients: dict[str, MemoryClient] = {}
    for _ in range(3000):
        name = random.choice("abcdef")
        client = clients.get(name)
        act = random.randrange(9)
        if client is None or client.link.closed:
            client = clients[name] = MemoryClient(state)
            client.send(
                mqtt.Connect(
                    name, clean_start=random.random() < 0.3, properties=mqtt.Properties(session_expiry_interval=99)
                )
            )
        elif act == 0:
            client.lose()
        elif act == 1:
            client.send(
                mqtt.Subscribe(
                    1, (mqtt.MqttSubscription(random.choice(["t/#", "t/1", "$share/g/t/#"]), random.randrange(3)),)
                )
            )
        elif act == 2:
            client.link.write_blocked = not client.link.write_blocked
            client.peer.writable()
        elif act < 5:
            client.acknowledge(*(each for each in client.messages() if each.qos))
        else:
            qos = random.randrange(3)
            topic, size = f"t/{random.randrange(3)}", random.choice([10, 2000, 100_000])
            packet_id = random.randrange(1, 9) if qos else None
            client.send(mqtt.Publish(topic, bytes(size), qos, random.random() < 0.2, packet_id=packet_id))
        clock.advance(0.05)
        state.deadlines.run(clock.monotonic())
    for client in clients.values():
        if not client.link.closed:
            client.lose()
    clock.advance(100)
    state.deadlines.run(clock.monotonic())
    assert state.stats.sessions == 0
    assert state.queued.used == 0


def test_wills_are_bounded(new_state: NewState, stranger: Stranger) -> None:
    state = new_state(max_will_bytes=200_000)
    reasons = []
    for number in range(6):
        client = stranger(at=state)
        client.send(mqtt.Connect(f"c{number}", will=mqtt.Will("w", bytes(60_000))))
        reasons += [connack.reason for connack in client.take_only(mqtt.Connack)]
    assert reasons == [mqtt.ReasonCode.SUCCESS] * 3 + [mqtt.ReasonCode.QUOTA_EXCEEDED] * 3
    modest = stranger(at=state)
    modest.send(mqtt.Connect("modest", will=mqtt.Will("w", b"offline")))
    assert modest.take_only(mqtt.Connack)[0].reason is mqtt.ReasonCode.SUCCESS


def test_wills_that_wait_for_their_time_count_as_well(new_state: NewState, join: Join, stranger: Stranger) -> None:
    state = new_state(max_will_bytes=100_000)
    late = mqtt.Will("w", bytes(60_000), properties=mqtt.Properties(will_delay_interval=1000))
    join("first", at=state, will=late, session_expiry_interval=2000).lose()
    second = stranger(at=state)
    second.send(mqtt.Connect("second", will=mqtt.Will("w", bytes(60_000))))
    assert second.take_only(mqtt.Connack)[0].reason is mqtt.ReasonCode.QUOTA_EXCEEDED


def test_a_host_that_leaves_many_sessions_pushes_out_its_own(small: BrokerState, stranger: Stranger) -> None:
    def leave(name: str, host: str) -> None:
        client = stranger(at=small)
        client.link.address = f"{host}:5000"
        client.send(mqtt.Connect(name, properties=mqtt.Properties(session_expiry_interval=FOREVER)))
        client.lose()

    leave("honest", "10.0.0.7")
    for number in range(200):
        leave(f"flood{number}", "10.0.0.66")
    assert small.stats.sessions == 20
    assert "honest" in small.sessions._sessions
    assert small.stats.sessions_evicted == 181


@pytest.mark.parametrize("version", [mqtt.ProtocolVersion.V311, mqtt.ProtocolVersion.V5])
def test_a_client_id_is_not_a_book(stranger: Stranger, version: mqtt.ProtocolVersion) -> None:
    client = stranger(version)
    client.send(mqtt.Connect("x" * 2000, version))
    assert client.take_only(mqtt.Connack)[0].reason is mqtt.ReasonCode.CLIENT_IDENTIFIER_NOT_VALID


def test_topic_aliases_have_a_bound_in_characters(join: Join) -> None:
    client = join("a")
    for alias in range(1, 4):
        client.publish("x" * 10_000 + str(alias), properties=mqtt.Properties(topic_alias=alias))
    client.publish("short", properties=mqtt.Properties(topic_alias=3))
    assert not client.link.closed
    client.publish("x" * 20_000, properties=mqtt.Properties(topic_alias=4))
    assert client.link.closed


def test_long_topics_are_not_remembered_for_a_receiver(join: Join) -> None:
    client = join("a", topic_alias_maximum=10)
    client.subscribe("#", qos=0)
    for topic in ("x" * 600, "short"):
        client.publish(topic)
        client.publish(topic)
    aliases = [message.properties.topic_alias for message in client.messages()]
    assert aliases == [None, None, 1, 1]


def test_a_shared_subscription_is_one_of_few(new_state: NewState, join: Join) -> None:
    """Each group gets a copy of its own: a thousand groups of one client are a thousand messages."""
    state = new_state(max_shared_subscriptions=3)
    client = join("a", at=state)
    reasons = client.subscribe(*(f"$share/g{number}/t" for number in range(5)), "t")
    assert [reason.failed for reason in reasons] == [False, False, False, True, True, False]
    assert state.stats.subscriptions_refused == 2


def test_nothing_is_kept_of_clients_that_take_over_each_other(state: BrokerState, join: Join) -> None:
    for _ in range(500):
        join("same", session_expiry_interval=0)
    assert (state.stats.clients, state.stats.sessions, len(state.waiting_logins)) == (1, 1, 0)
    assert state.stats.connections_closed == 499


def test_acknowledgements_free_what_they_acknowledge(state: BrokerState, join: Join) -> None:
    client, publisher = join("a"), join("p")
    client.subscribe("t", qos=1)
    publisher.publish("t", bytes(50_000), 1, 1)
    assert state.queued.used > 50_000
    client.send(mqtt.Puback(client.messages()[0].packet_id or 0))
    assert state.queued.used == 0
