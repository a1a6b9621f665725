"""Passwords cannot be guessed quickly, and who knows the password does not wait for those who guess."""

import pytest
from tests.mqtt.broker.conftest import MemoryClient, NewState

from homebot.clock import ManualClock
from homebot.mqtt.broker import BrokerState
from homebot.mqtt.broker.authentication import Applicant, LoginThrottle
from homebot.mqtt.packets import Connack, Connect, Pingreq, Pingresp, ProtocolVersion, ReasonCode

BAD = ReasonCode.BAD_USER_NAME_OR_PASSWORD


@pytest.fixture
def state(new_state: NewState) -> BrokerState:
    return new_state(credentials={"u": "right"})


def attempt(
    state: BrokerState, password: bytes = b"wrong", host: str = "10.0.0.66", client_id: str = "c"
) -> MemoryClient:
    client = MemoryClient(state)
    client.link.address = f"{host}:5000"
    client.send(Connect(client_id, username="u", password=password))
    return client


def answer(client: MemoryClient) -> ReasonCode | None:
    answers = [connack.reason for connack in client.take_only(Connack)]
    return answers[0] if answers else None


def pass_time(state: BrokerState, clock: ManualClock, seconds: float) -> None:
    for _ in range(round(seconds * 10)):
        clock.advance(0.1)
        state.deadlines.run(clock.monotonic())


def test_who_mistypes_thrice_is_answered_at_once_and_let_in(state: BrokerState) -> None:
    assert [answer(attempt(state)) for _ in range(3)] == [BAD] * 3
    assert answer(attempt(state, b"right")) is ReasonCode.SUCCESS


@pytest.mark.no_cover
def test_passwords_are_tried_ever_more_slowly(state: BrokerState, clock: ManualClock) -> None:
    """Ten minutes of attempts, ten a second: some hundred are looked at."""
    began = clock.monotonic()
    while clock.monotonic() < began + 600:
        attempt(state)
        pass_time(state, clock, 0.1)
    assert 60 < state.stats.logins_failed < 120
    assert state.stats.logins_slowed > 5_000
    assert len(state.waiting_logins) <= 110


def test_many_connections_at_once_are_no_faster(state: BrokerState, clock: ManualClock) -> None:
    for _ in range(200):
        attempt(state)
    pass_time(state, clock, 60)
    assert state.stats.logins_failed < 12
    assert len(state.waiting_logins) == 0


def test_an_attempt_that_had_to_wait_is_answered_and_what_came_with_it_is_done(
    state: BrokerState, clock: ManualClock
) -> None:
    for _ in range(5):
        attempt(state)
        pass_time(state, clock, 0.6)
    honest = attempt(state, b"right")
    assert answer(honest) is None
    assert not honest.link.reading
    honest.peer.receive(b"\xc0\0")
    pass_time(state, clock, 1)
    assert [type(packet) for packet in honest.take()] == [Connack, Pingresp]
    assert honest.link.reading
    honest.send(Pingreq())
    assert honest.take() == [Pingresp()]


def test_an_attempt_that_waited_too_long_is_told_so(state: BrokerState, clock: ManualClock) -> None:
    for _ in range(30):
        attempt(state)
    last = attempt(state)
    pass_time(state, clock, 11)
    assert answer(last) is ReasonCode.QUOTA_EXCEEDED
    assert last.link.closed


def test_other_hosts_do_not_wait(state: BrokerState) -> None:
    for _ in range(30):
        attempt(state)
    assert answer(attempt(state, b"right", "10.0.0.7")) is ReasonCode.SUCCESS


def test_a_client_that_was_in_before_does_not_wait_until_it_is_wrong_itself(
    state: BrokerState, clock: ManualClock
) -> None:
    assert answer(attempt(state, b"right", client_id="lamp")) is ReasonCode.SUCCESS
    for _ in range(30):
        attempt(state)
    assert answer(attempt(state, b"right", client_id="lamp")) is ReasonCode.SUCCESS
    assert answer(attempt(state, b"wrong", client_id="lamp")) is BAD
    assert answer(attempt(state, b"right", client_id="lamp")) is None


def test_who_guesses_under_the_name_of_a_client_does_not_lock_it_out_of_a_long_password(
    new_state: NewState,
) -> None:
    password = "a password that is long"
    state = new_state(credentials={"u": password})
    assert answer(attempt(state, password.encode(), client_id="lamp")) is ReasonCode.SUCCESS
    for _ in range(30):
        attempt(state, client_id="lamp")
    assert answer(attempt(state, password.encode(), client_id="lamp")) is ReasonCode.SUCCESS
    assert answer(attempt(state, password.encode(), client_id="new")) is None


def test_a_waiting_attempt_whose_client_goes_is_forgotten(state: BrokerState, clock: ManualClock) -> None:
    for _ in range(5):
        attempt(state)
    client = attempt(state, b"right")
    client.lose()
    pass_time(state, clock, 20)
    assert state.stats.clients == 0


def test_nobody_waits_where_no_password_is_asked_for(new_state: NewState) -> None:
    state = new_state()
    assert [answer(attempt(state)) for _ in range(30)] == [ReasonCode.SUCCESS] * 30
    assert len(state.throttle) == 0


def test_wrong_passwords_are_forgotten_in_time_and_the_memory_for_them_is_bounded(clock: ManualClock) -> None:
    throttle = LoginThrottle(clock)
    lamp = Applicant("10.0.0.7", "u", "lamp")
    for _ in range(20):
        throttle.failed(lamp)
    clock.advance(601)
    assert throttle.failed(lamp) == (1, 0.0)
    for number in range(5000):
        throttle.failed(Applicant(f"host {number}", "u", "c"))
        throttle.succeeded(Applicant("host", "u", str(number)))
    assert len(throttle) == 1000
    assert len(throttle._known) == 2000


@pytest.mark.parametrize("version", [ProtocolVersion.V31, ProtocolVersion.V311])
def test_older_clients_wait_as_well(state: BrokerState, clock: ManualClock, version: ProtocolVersion) -> None:
    for _ in range(6):
        attempt(state)
        pass_time(state, clock, 1.1)
    client = MemoryClient(state, version)
    client.link.address = "10.0.0.66:1"
    client.send(Connect("old", version, username="u", password=b"right"))
    assert client.take() == []
    pass_time(state, clock, 8)
    assert answer(client) is ReasonCode.SUCCESS
