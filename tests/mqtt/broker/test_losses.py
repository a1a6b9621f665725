"""Reports of lost messages."""

from __future__ import annotations

from structlog.testing import capture_logs
from tests.mqtt.broker.conftest import Dial

from homebot.clock import ManualClock
from homebot.mqtt.broker import Broker, BrokerLimits
from homebot.mqtt.broker.stats import Counters, LossReport, loss_text
from homebot.mqtt.packets import MqttSubscription, Publish, Subscribe


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
