"""Sessions: found again, ended, taken over, pushed out; and wills."""

import pytest
from tests.mqtt.broker.conftest import Join, NewState, PassTime

from homebot.mqtt.packets import Disconnect, Properties, ProtocolVersion, Publish, ReasonCode, Will

V311 = ProtocolVersion.V311
FOREVER = 0xFFFF_FFFF


def will(delay: int | None = None, *, retain: bool = False, expiry: int | None = None) -> Will:
    properties = Properties(will_delay_interval=delay, message_expiry_interval=expiry)
    return Will("will", b"gone", 1, retain, properties)


def test_a_session_that_never_expires_is_still_there_after_years(join: Join, pass_time: PassTime) -> None:
    join(session_expiry_interval=FOREVER).lose()
    pass_time(1e9)
    join(clean=False, present=True)


def test_clean_start_forgets_the_session(join: Join) -> None:
    client = join(session_expiry_interval=FOREVER, to="t")
    client.lose()
    client = join(clean=True, session_expiry_interval=FOREVER)
    client.publish("t")
    assert client.messages() == []


def test_before_mqtt_5_a_session_that_is_not_clean_is_kept_for_ever(join: Join, pass_time: PassTime) -> None:
    client = join(version=V311, clean=False, to="t")
    client.leave()
    pass_time(1e6)
    client = join(version=V311, clean=False, present=True)
    client.publish("t")
    assert len(client.messages()) == 1


def test_disconnect_must_not_prolong_a_session_that_was_to_end(join: Join) -> None:
    client = join()
    client.send(Disconnect(properties=Properties(session_expiry_interval=5)))
    (goodbye,) = client.take_only(Disconnect)
    assert goodbye.reason is ReasonCode.PROTOCOL_ERROR


def test_a_second_connection_takes_the_session_over(join: Join) -> None:
    first = join(session_expiry_interval=9, to="t")
    second = join(clean=False, present=True)
    assert first.take() == [Disconnect(ReasonCode.SESSION_TAKEN_OVER)]
    assert first.link.closed
    first.peer.lost()
    second.publish("t")
    assert len(second.messages()) == 1
    assert second.state.stats.clients == 1


def test_the_session_left_longest_ago_makes_room(new_state: NewState, join: Join) -> None:
    state = new_state(max_sessions=2)
    join("old", at=state, session_expiry_interval=FOREVER).lose()
    join("new", at=state, session_expiry_interval=FOREVER).lose()
    join("third", at=state)
    assert state.stats.sessions == 2
    assert state.stats.sessions_evicted == 1
    join("new", at=state, clean=False, present=True)


@pytest.mark.parametrize("leave", [True, False])
def test_a_will_is_published_when_the_client_is_lost_but_not_when_it_leaves(join: Join, *, leave: bool) -> None:
    watcher, client = join("w", to="will"), join("c", will=will())
    if leave:
        client.leave()
    else:
        client.lose()
    assert watcher.messages() == [] if leave else [Publish("will", b"gone", 1, packet_id=1)]


def test_a_client_may_leave_and_have_its_will_published(join: Join) -> None:
    watcher, client = join("w", to="will"), join("c", will=will())
    client.leave(ReasonCode.DISCONNECT_WITH_WILL)
    assert len(watcher.messages()) == 1


def test_a_retained_will_stays(join: Join) -> None:
    join("c", will=will(retain=True)).lose()
    late = join("l", to="will")
    assert late.messages() == [Publish("will", b"gone", 1, retain=True, packet_id=1)]


def test_a_client_that_returns_in_time_cancels_its_will(join: Join, pass_time: PassTime) -> None:
    watcher = join("w", to="will")
    join("c", will=will(3), session_expiry_interval=9).lose()
    pass_time(2)
    join("c", clean=False, present=True)
    pass_time(9)
    assert watcher.messages() == []


def test_a_clean_start_publishes_the_will_that_waited(join: Join, pass_time: PassTime) -> None:
    watcher = join("w", to="will")
    join("c", will=will(3), session_expiry_interval=9).lose()
    join("c", clean=True)
    assert len(watcher.messages()) == 1
    pass_time(9)
    assert watcher.messages() == []


def test_a_take_over_publishes_a_will_without_delay(join: Join) -> None:
    watcher = join("w", to="will")
    join("c", will=will(), session_expiry_interval=9)
    join("c", clean=False, present=True)
    assert len(watcher.messages()) == 1


def test_a_will_expires_like_any_message(join: Join, pass_time: PassTime) -> None:
    watcher = join("w", session_expiry_interval=FOREVER, to="will")
    watcher.lose()
    join("c", will=will(expiry=5)).lose()
    pass_time(6)
    assert join("w", clean=False, present=True).messages() == []


def test_to_forget_publishes_no_will(join: Join) -> None:
    client = join("c", will=will(9), session_expiry_interval=99)
    client.lose()
    client.state.forget()
    assert client.state.stats.sessions == 0
    watcher = join("w", to="#")
    assert watcher.messages() == []
