"""Packets that never come to their end, and connections that never log in."""

import tracemalloc

import pytest
from tests.mqtt.broker.conftest import Join, NewState, Stranger

from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import BrokerState
from homebot.mqtt.broker.authentication import host_of

KIB = 1024


def begun(size: int, came: int) -> bytes:
    """The first *came* bytes of a PUBLISH of *size* bytes of payload."""
    return mqtt.encode(mqtt.Publish("t", bytes(size)))[:came]


def test_what_a_packet_announces_is_not_reserved_before_it_comes() -> None:
    reader = mqtt.PacketReader()
    tracemalloc.start()
    try:
        reader.feed(b"\x30\xff\xff\xff\x7f" + bytes(1000))
        for packet in reader.feed(b""):
            raise AssertionError(packet)
        assert tracemalloc.get_traced_memory()[0] < 10 * KIB
    finally:
        tracemalloc.stop()
    assert reader.held == 1005


def test_a_packet_in_single_bytes_takes_no_more_memory_than_its_bytes() -> None:
    reader = mqtt.PacketReader()
    data = begun(100 * KIB, 50 * KIB)
    pieces = [data[place : place + 1] for place in range(len(data))]
    tracemalloc.start()
    try:
        for piece in pieces:
            assert list(reader.feed(piece)) == []
        assert tracemalloc.get_traced_memory()[0] < 80 * KIB
    finally:
        tracemalloc.stop()


def test_a_reader_does_not_keep_what_was_taken() -> None:
    reader = mqtt.PacketReader()
    whole = mqtt.encode(mqtt.Publish("t", bytes(10 * KIB)))
    assert len(list(reader.feed(whole + whole[:7]))) == 1
    assert reader.held == 7
    assert len(reader._data) == 7
    assert len(list(reader.feed(whole[7:]))) == 1
    assert reader.held == 0


def test_among_incomplete_packets_of_equal_size_the_oldest_is_dropped(new_state: NewState, join: Join) -> None:
    """Honest packets are complete sooner than those that are only begun."""
    state = new_state(max_packet_size=100 * KIB, max_unread_bytes=250 * KIB)
    slow, second, third = (join(name, at=state) for name in "abc")
    for client in (slow, second, third):
        client.send_bytes(begun(90 * KIB, 80 * KIB))
    assert not slow.link.closed
    honest = join("honest", at=state)
    honest.subscribe("t", qos=0)
    honest.send_bytes(begun(90 * KIB, 80 * KIB))
    (goodbye,) = slow.take_only(mqtt.Disconnect)
    assert goodbye.reason is mqtt.ReasonCode.QUOTA_EXCEEDED
    honest.send_bytes(mqtt.encode(mqtt.Publish("t", bytes(90 * KIB)))[80 * KIB :])
    assert [len(message.payload) for message in honest.messages()] == [90 * KIB]
    assert [client.link.closed for client in (slow, second, third)] == [True, False, False]
    assert state.stats.unread_given_up == 1


def test_packets_that_come_to_their_end_or_whose_client_goes_count_no_longer(new_state: NewState, join: Join) -> None:
    state = new_state(max_packet_size=100 * KIB, max_unread_bytes=100 * KIB)
    clients = [join(str(number), at=state) for number in range(20)]
    for number, client in enumerate(clients):
        client.send_bytes(begun(90 * KIB, 80 * KIB))
        if number % 2:
            client.lose()
        else:
            client.send_bytes(mqtt.encode(mqtt.Publish("t", bytes(90 * KIB)))[80 * KIB :])
    assert state.unread.used == 0
    assert state.stats.unread_given_up == 0


def test_before_the_login_all_incomplete_packets_together_have_a_bound(new_state: NewState, stranger: Stranger) -> None:
    state = new_state(max_connect_size=64 * KIB, max_unread_login_bytes=256 * KIB)
    flood = [stranger(at=state) for _ in range(200)]
    for each in flood:
        each.send_bytes(mqtt.encode(mqtt.Connect("x" * 60_000))[: 50 * KIB])
    assert state.unread_logins.used <= 256 * KIB
    assert [each.link.closed for each in flood].count(False) == 5
    honest = stranger(at=state)
    honest.send(mqtt.Connect("honest"))
    assert honest.take_only(mqtt.Connack)[0].reason is mqtt.ReasonCode.SUCCESS


def test_a_connect_is_small(stranger: Stranger) -> None:
    client = stranger()
    client.send_bytes(b"\x10\x80\x80\x40")
    assert client.link.closed


def test_connections_that_do_not_log_in_make_room_for_later_ones(new_state: NewState, stranger: Stranger) -> None:
    state = new_state(max_waiting_logins=50)
    silent = [stranger(at=state) for _ in range(500)]
    assert [each.link.closed for each in silent] == [True] * 450 + [False] * 50
    assert len(state.waiting_logins) == 50
    assert state.stats.logins_pushed_out == 450


def test_a_flood_from_one_host_keeps_nobody_else_out(new_state: NewState, stranger: Stranger) -> None:
    state = new_state(max_waiting_logins=50)
    honest = stranger(mqtt.ProtocolVersion.V311, at=state)
    honest.link.address = "192.168.1.7:50000"
    silent = []
    for number in range(500):
        silent.append(stranger(at=state))
        silent[-1].link.address = f"192.168.1.66:{number}"
    assert not honest.link.closed
    honest.send(mqtt.Connect("honest", mqtt.ProtocolVersion.V311), mqtt.Pingreq())
    assert honest.take_only(mqtt.Pingresp) == [mqtt.Pingresp()]
    assert len(state.waiting_logins) == 49


def test_those_who_logged_in_or_went_take_no_place_of_the_waiting(
    state: BrokerState, join: Join, stranger: Stranger
) -> None:
    join("a")
    stranger().lose()
    wrong = stranger()
    wrong.send_bytes(b"GET / HTTP/1.1\r\n")
    assert len(state.waiting_logins) == 0


@pytest.mark.parametrize(
    ("address", "host"),
    [
        ("192.168.1.7:50000", "192.168.1.7"),
        ("::1:50000", "::/64"),
        ("fe80::1:2:50000", "fe80::/64"),
        ("2001:db8:1:2:3:4:5:6:50000", "2001:db8:1:2::/64"),
        ("::ffff:10.0.0.5:50000", "10.0.0.5"),
        ("memory:3", "memory"),
        ("?", ""),
    ],
)
def test_a_host_is_what_one_owner_has(address: str, host: str) -> None:
    assert host_of(address) == host
