"""What the broker's log says of clients that do wrong, and of lost messages."""

from structlog.testing import capture_logs
from tests.mqtt.broker.conftest import Dial, Join, NewState, Stranger

from homebot.clock import ManualClock
from homebot.mqtt.broker import Broker, BrokerLimits
from homebot.mqtt.broker.stats import Counters, LossReport, loss_text
from homebot.mqtt.packets import Connect, MqttSubscription, Pingreq, Publish, Subscribe


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


def test_losses_are_told_by_their_reasons() -> None:
    counters = Counters(dropped_qos0=3, dropped_too_large=1, dropped_expired=7, dropped_refused=7)
    assert loss_text(counters) == (
        "4 messages (3 at QoS 0 for clients that read too slowly, 1 too large for their clients)"
    )
    assert loss_text(Counters(dropped_offline=1)) == "1 message (1 for clients that were away too long)"
    assert loss_text(Counters()) == ""


def test_each_loss_is_told_once_and_remembered_for_a_while() -> None:
    counters = Counters()
    report = LossReport(counters)
    assert (report.next(), report.recent) == ("", "")
    counters.dropped_overrun += 2
    assert report.next() == "2 messages (2 for clients that stayed too slow)"
    assert report.next() == ""
    for _ in range(50):
        report.next()
    assert report.recent == "2 messages (2 for clients that stayed too slow)"
    for _ in range(10):
        report.next()
    assert report.recent == ""


async def test_a_loss_is_logged_once_and_reported_by_the_broker(dial: Dial) -> None:
    clock = ManualClock()
    with capture_logs() as lines:
        async with Broker(clock=clock, limits=BrokerLimits(max_retained_messages=1)) as broker:
            client = await dial(broker)
            await client.send(Publish("a", b"x", retain=True), Publish("b", b"x", retain=True))
            await client.call(Subscribe(1, (MqttSubscription("c"),)))
            for _ in range(2):
                clock.advance(10)
                broker.tick()
            assert broker.losses == "1 message (1 to be retained, because the limit was reached)"
        assert broker.losses == ""
    told = [line["message"] for line in lines if line["event"] == "broker.dropped"]
    assert told == ["the broker dropped 1 message (1 to be retained, because the limit was reached) in the last 10 s"]
