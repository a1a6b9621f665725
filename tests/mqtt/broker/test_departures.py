"""Clients that go with much left to do: it is done in slices and in its order, whatever comes meanwhile."""

import pytest
from tests.mqtt.broker.conftest import Join, MemoryClient, NewState, Stranger

from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import BrokerState

TAKEN, HELD = 451, 100
SENT = [b"%d" % number for number in range(1, TAKEN + HELD + 1)]
WILL = mqtt.Will("t", b"will", 1)


class StepClock:
    """A clock that goes on by half a millisecond with each look at it."""

    def __init__(self) -> None:
        self._time = 1000.0

    def monotonic(self) -> float:
        self._time += 0.0005
        return self._time

    now = monotonic

    def advance(self, seconds: float) -> None:
        self._time += seconds


@pytest.fixture
def clock() -> StepClock:
    return StepClock()


@pytest.fixture
def state(new_state: NewState) -> BrokerState:
    """Six hundred messages may wait for a client: publishers are held back from the 450th on."""
    return new_state(max_inflight=1, max_queued_messages=600)


def turn(state: BrokerState) -> None:
    state.deadlines.run(state.clock.monotonic())


def finish(state: BrokerState) -> int:
    """Run turns until nothing waits; return how many."""
    turns = 0
    while state.turn.waiting:
        turn(state)
        turns += 1
    return turns


def hold(join: Join, **more: object) -> tuple[MemoryClient, MemoryClient]:
    """A subscriber that is slow, and a publisher with a hundred messages that are held back for it."""
    slow = join("slow", session_expiry_interval=60, to="t")
    publisher = join("p", will=WILL, session_expiry_interval=60, **more)
    publisher.send(*(mqtt.Publish("t", payload, 1, packet_id=int(payload)) for payload in SENT))
    finish(publisher.state)
    assert len(publisher.take_only(mqtt.Puback)) == TAKEN
    return slow, publisher


def drain(client: MemoryClient) -> list[bytes]:
    """Acknowledge everything until nothing more comes."""
    payloads = []
    while messages := client.messages():
        payloads += [message.payload for message in messages]
        client.acknowledge(*messages)
        finish(client.state)
    return payloads


def log_in(client: MemoryClient, *then: mqtt.Packet) -> None:
    connect = mqtt.Connect("p", clean_start=False, properties=mqtt.Properties(session_expiry_interval=60))
    client.send(connect, *then)


def test_held_messages_and_then_the_will_are_forwarded_a_few_in_each_turn(state: BrokerState, join: Join) -> None:
    slow, publisher = hold(join)
    publisher.lose()
    assert state.stats.waiting_work == 1
    turn(state)
    assert state.stats.queued_messages < TAKEN + 20
    assert "p" in state.peers
    assert finish(state) > 5
    assert state.stats.clients == 1
    assert drain(slow) == [*SENT, b"will"]


def test_a_login_with_the_same_client_id_waits_until_all_is_done(
    state: BrokerState, join: Join, stranger: Stranger
) -> None:
    watcher = join("w")
    watcher.subscribe("t", qos=0)
    _, publisher = hold(join)
    again = stranger()
    log_in(again, mqtt.Publish("t", b"back"))
    assert publisher.take_only(mqtt.Disconnect)[0].reason is mqtt.ReasonCode.SESSION_TAKEN_OVER
    assert publisher.link.closed
    assert (again.take(), again.link.reading) == ([], False)
    finish(state)
    assert again.link.reading
    (connack,) = again.take_only(mqtt.Connack)
    assert (connack.reason, connack.session_present) == (mqtt.ReasonCode.SUCCESS, True)
    assert [message.payload for message in watcher.messages()] == [*SENT, b"will", b"back"]
    assert state.peers["p"] is again.peer


def test_of_two_logins_that_wait_the_later_one_takes_over(state: BrokerState, join: Join, stranger: Stranger) -> None:
    _, publisher = hold(join)
    publisher.lose()
    first, second = stranger(), stranger()
    log_in(first)
    log_in(second)
    assert first.link.closed
    finish(state)
    assert first.take() == []
    assert second.take_only(mqtt.Connack)[0].session_present
    assert state.stats.clients == 2


def test_a_login_that_is_lost_while_it_waits_takes_over_nothing(
    state: BrokerState, join: Join, stranger: Stranger
) -> None:
    _, publisher = hold(join)
    publisher.lose()
    again = stranger()
    log_in(again)
    again.lose()
    finish(state)
    assert (state.stats.clients, state.stats.sessions) == (1, 2)
    join("p", clean=False, present=True)


def test_publishers_do_not_wait_for_a_subscriber_whose_own_messages_are_still_forwarded(
    state: BrokerState, join: Join
) -> None:
    _, publisher = hold(join, to="mine")
    other = join("o")
    for number in range(1, TAKEN + 10):
        other.publish("mine", b"x", 1, number)
        finish(state)
    assert len(other.take_only(mqtt.Puback)) == TAKEN
    publisher.lose()
    turn(state)
    turn(state)
    assert "p" in state.peers
    finish(state)
    assert len(other.take_only(mqtt.Puback)) == 9


def test_a_broker_that_forgets_all_forgets_the_messages_of_those_who_left(state: BrokerState, join: Join) -> None:
    slow, publisher = hold(join)
    slow.lose()
    publisher.lose()
    before = state.stats.messages_received
    state.forget()
    finish(state)
    assert state.stats.messages_received == before
    assert (state.stats.clients, state.stats.sessions, state.queued.used) == (0, 0, 0)


@pytest.mark.parametrize("kept", [0, 60])
@pytest.mark.parametrize("unacknowledged", [1, 500])
def test_only_those_for_which_most_waits_lose_something_while_others_leave(
    new_state: NewState, join: Join, kept: int, unacknowledged: int
) -> None:
    """What one that leaves does not give back at once is not asked of all the others."""
    state = new_state(max_inflight=unacknowledged, max_all_queued_bytes=200_000)
    honest = join("honest", at=state, to="h")
    greedy = join("greedy", at=state, session_expiry_interval=kept, to="g")
    publisher = join("p", at=state)
    publisher.publish("h", bytes(2000), 1, 1)
    publisher.publish("h", b"2", 1, 2)
    while state.turn.has_time():  # whatever comes next has to wait
        pass
    for number in range(200):
        publisher.peer.receive(mqtt.encode(mqtt.Publish("g", bytes(2000), 1, packet_id=number + 3), publisher.version))
    finish(state)
    turn(state)
    finish(state)
    assert greedy.link.closed
    assert not honest.link.closed
    assert state.stats.clients_stalled == 1
    assert state.queued.used <= 200_000
    assert drain(honest) == [bytes(2000), b"2"]


def test_wills_and_sessions_that_are_due_together_take_their_turns(
    state: BrokerState, join: Join, clock: StepClock
) -> None:
    watcher = join("w", to="t")
    will = mqtt.Will("t", b"will", 1, properties=mqtt.Properties(will_delay_interval=10))
    for number in range(40):
        join(f"c{number}", will=will, session_expiry_interval=20 + number % 2).lose()
    clock.advance(10.5)
    turn(state)
    assert state.stats.waiting_work > 20
    assert state.sessions.open("c39", clean_start=False)[1]  # it has come back
    finish(state)
    assert drain(watcher) == [b"will"] * 39
    clock.advance(12)
    turn(state)
    assert state.stats.waiting_work > 20
    finish(state)
    assert state.stats.sessions == 2
