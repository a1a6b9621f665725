"""What the broker's log says of clients that do wrong: who, what, and not without end."""

from __future__ import annotations

from structlog.testing import capture_logs
from tests.mqtt.broker.conftest import Dial, Join, NewState, Stranger

from homebot.clock import ManualClock
from homebot.mqtt.broker import Broker, BrokerLimits
from homebot.mqtt.packets import Connect, Pingreq


def test_a_client_that_is_cut_off_is_named_with_its_mistake(stranger: Stranger, join: Join) -> None:
    with capture_logs() as lines:
        stranger().send_bytes(b"GET / HTTP/1.1\r\n\r\n")
        stranger().send(Pingreq())
        join("lamp").send(Connect("lamp"))
    assert [line["event"] for line in lines] == ["broker.connection_failed"] * 3
    assert [line["message"] for line in lines] == [
        "the broker cut off memory: the first byte is 0x47, not that of CONNECT",
        "the broker cut off memory: the first byte is 0xc0, not that of CONNECT",
        "the broker cut off client 'lamp' (memory): a client must not send Connect",
    ]


def test_a_refused_login_is_told_with_its_reason_and_without_the_password(
    new_state: NewState, stranger: Stranger
) -> None:
    state = new_state(credentials={"ann": "right"})
    with capture_logs() as lines:
        stranger(at=state).send(Connect("x" * 5000, username="ann", password=b"hunter2"))
    (line,) = lines
    assert line["message"] == (f"the broker refused client '{'x' * 99}…' (memory): bad user name or password")
    assert "hunter2" not in repr(line)
    assert len(line["client_id"]) == 100


def test_a_flood_of_mistakes_is_told_in_part_with_the_number_of_the_others(
    stranger: Stranger, clock: ManualClock
) -> None:
    with capture_logs() as lines:
        for _ in range(25):
            stranger().send_bytes(b"GET")
        clock.advance(10)
        stranger().send_bytes(b"GET")
    assert len(lines) == 21
    assert lines[-1]["message"].endswith("not that of CONNECT (and 5 more like this)")
    assert lines[-1]["held_back"] == 5


async def test_a_socket_too_many_is_named(dial: Dial) -> None:
    with capture_logs() as lines:
        async with Broker(limits=BrokerLimits(max_connections=1)) as broker:
            for _ in range(2):
                await dial(broker, None)
            third = await dial(broker, None)
            assert await third.rest() == []
            assert broker.stats.connections_refused == 1
    (line,) = [line for line in lines if line["event"] == "broker.too_many_sockets"]
    host, port = third.writer.get_extra_info("sockname")
    assert line["message"] == f"the broker refused {host}:{port}: 2 connections are already open"
