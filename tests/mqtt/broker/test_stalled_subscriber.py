"""A subscriber stalls with 2,000 QoS 1 messages outstanding: none that was acknowledged is lost, memory is bounded."""

import tracemalloc

import pytest
from tests.mqtt.broker.conftest import Dial, Join, MemoryClient, NewState

from homebot.clock import ManualClock
from homebot.mqtt.broker import Broker, BrokerLimits, BrokerState
from homebot.mqtt.packets import MqttSubscription, ProtocolVersion, Puback, Publish, ReasonCode, Subscribe

COUNT = 2000
FOREVER = 2**32 - 1
V5, V311 = ProtocolVersion.V5, ProtocolVersion.V311


def pour(publisher: MemoryClient, payload: bytes = b"") -> None:
    for number in range(1, COUNT + 1):
        publisher.publish("t", b"%d" % number + payload, 1, number)


def taken(publisher: MemoryClient) -> list[int]:
    """The numbers of the messages that the broker took: acknowledged, and not with a refusal."""
    return [each.packet_id for each in publisher.take_only(Puback) if not each.reason.failed]


def drain(client: MemoryClient) -> list[int]:
    """Acknowledge everything until nothing more comes."""
    numbers: list[int] = []
    while messages := client.messages():
        numbers += [int(message.payload) for message in messages]
        client.acknowledge(*messages)
    return numbers


@pytest.mark.parametrize("version", [V5, V311])
def test_all_are_taken_at_once_and_wait(state: BrokerState, join: Join, version: ProtocolVersion) -> None:
    stalled, publisher = join("s", version=version, to="t"), join("p", version=V311)
    pour(publisher)
    assert taken(publisher) == list(range(1, COUNT + 1))
    assert state.stats.queued_messages == COUNT - state.limits.max_inflight
    assert drain(stalled) == list(range(1, COUNT + 1))


@pytest.mark.parametrize("returns", [False, True], ids=["stays", "is lost and returns"])
def test_with_less_room_those_that_were_taken_arrive_and_the_others_are_refused(
    new_state: NewState, join: Join, clock: ManualClock, *, returns: bool
) -> None:
    """The publisher is held back, and told no once the stall has lasted too long."""
    state = new_state(max_queued_messages=500, receive_maximum=COUNT)
    stalled, publisher = join("s", at=state, session_expiry_interval=FOREVER, to="t"), join("p", at=state)
    pour(publisher)
    acknowledged = taken(publisher)
    assert len(acknowledged) == 64 + 375
    clock.advance(state.limits.hold_time)
    state.deadlines.run(clock.monotonic())
    answers = publisher.take_only(Puback)
    acknowledged += [each.packet_id for each in answers if each.reason is ReasonCode.SUCCESS]
    assert state.stats.queued_messages == 500
    assert len(acknowledged) == 64 + 500
    assert state.stats.dropped_overrun == COUNT - len(acknowledged)
    if returns:
        stalled.take()
        stalled.lose()
        stalled = join("s", at=state, clean=False, present=True, session_expiry_interval=FOREVER)
    assert drain(stalled) == acknowledged


def test_memory_stays_within_the_bounds_in_bytes(new_state: NewState, join: Join) -> None:
    """40 MB are sent; one MiB may wait in the queue and one at the publisher, whose socket is then left alone."""
    mib = 1024 * 1024
    state = new_state(max_inflight=4, max_queued_bytes=mib, max_held_bytes=mib)
    stalled, publisher = join("s", at=state, to="t"), join("p", at=state, version=V311)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        sent = 0
        while sent < COUNT and publisher.link.reading:
            sent += 1
            publisher.publish("t", b"%05d" % sent + bytes(20_000), 1, sent)
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert not publisher.link.reading
    assert grown < 3 * mib
    received: list[Publish] = []
    while messages := stalled.messages():
        received += messages
        stalled.acknowledge(*messages)
    assert [int(message.payload[:5]) for message in received] == list(range(1, sent + 1))
    assert publisher.link.reading
    assert taken(publisher) == list(range(1, sent + 1))


async def test_all_of_it_over_sockets(dial: Dial) -> None:
    limits = BrokerLimits(max_queued_messages=500, max_held_packets=100)
    async with Broker(limits=limits) as broker:
        stalled, publisher = await dial(broker, "s", V311), await dial(broker, "p", V311)
        await stalled.call(Subscribe(1, (MqttSubscription("t", 1),)))
        for number in range(1, COUNT + 1):
            await publisher.send(Publish("t", b"%d" % number, 1, packet_id=number))
        assert broker.stats.queued_messages <= 500
        received: list[int] = []
        while len(received) < COUNT:
            message = await stalled.take()
            assert isinstance(message, Publish)
            received.append(int(message.payload))
            await stalled.send(Puback(message.packet_id or 0))
        assert received == list(range(1, COUNT + 1))
        assert [await publisher.take() for _ in range(COUNT)] == [Puback(each) for each in received]
        assert broker.stats.dropped_overrun == 0
