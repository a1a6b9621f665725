"""What waits for clients of the door: never more than may, and what is lost is what the rule says."""

import gc
import weakref
from collections.abc import Callable
from typing import ClassVar

from hypothesis import given
from hypothesis import strategies as st

from homebot.bridges.rosbridge.backlog import Backlog, FeedQueue, TotalBacklog
from homebot.graph.subscription import key_of
from homebot.messages import String
from homebot.messages.message import Message

KIB = 1024


class State(Message):
    """The newest of each key counts."""

    ros_type: ClassVar[str] = "test_msgs/msg/State"
    key_field: ClassVar[str | None] = "key"

    key: str
    data: str = ""


def text(name: str, size: int = KIB) -> String:
    return String(data=name.ljust(size, "."))


def queue(backlog: Backlog, depth: int = 1000, message_type: type[Message] = String) -> FeedQueue:
    return FeedQueue(depth, key_of(message_type), backlog, lambda: None)


def names(waiting: FeedQueue) -> list[str]:
    got = []
    while len(waiting):
        message = waiting.popleft()
        assert isinstance(message, String)
        got.append(message.data.rstrip("."))
    return got


def test_a_topic_that_brings_too_much_loses_its_own_oldest_and_no_other_does() -> None:
    backlog = Backlog(10 * KIB, TotalBacklog(100 * KIB))
    quiet, flood = queue(backlog), queue(backlog)
    quiet.append(text("state"))
    for number in range(50):
        flood.append(text(f"{number}"))
    assert backlog.waiting <= 10 * KIB
    assert (quiet.lost, names(quiet)) == (0, ["state"])
    left = names(flood)
    assert left == [f"{number}" for number in range(50 - len(left), 50)]
    assert flood.lost == 50 - len(left)


def test_the_oldest_of_all_goes_where_each_topic_has_only_one() -> None:
    backlog = Backlog(10 * KIB, TotalBacklog(100 * KIB))
    queues = [queue(backlog) for _ in range(20)]
    for number, one in enumerate(queues):
        one.append(text(f"{number}"))
    left = [len(one) for one in queues]
    assert left == sorted(left)
    assert 5 < sum(left) < 10


def test_one_message_of_any_size_may_wait() -> None:
    backlog = Backlog(10, TotalBacklog(10))
    big = queue(backlog)
    big.append(text("first"))
    big.append(text("second"))
    assert names(big) == ["second"]


def test_a_topic_keeps_its_depth_and_a_keyed_one_that_of_each_key() -> None:
    backlog = Backlog(1000 * KIB, TotalBacklog(1000 * KIB))
    plain, keyed = queue(backlog, 3), queue(backlog, 1, State)
    for number in range(10):
        plain.append(text(f"{number}"))
        keyed.append(State(key=f"{number % 3}", data=f"{number}"))
    assert (names(plain), plain.lost) == (["7", "8", "9"], 7)
    assert [keyed.popleft() for _ in range(len(keyed))] == [State(key=f"{one % 3}", data=f"{one}") for one in (7, 8, 9)]
    assert keyed.lost == 7
    assert backlog.waiting == 0


def test_whoever_has_most_waiting_gives_up_where_too_much_waits_for_all() -> None:
    everybody = TotalBacklog(40 * KIB)
    modest = queue(Backlog(30 * KIB, everybody))
    modest.append(text("state"))
    greedy = [queue(Backlog(30 * KIB, everybody)) for _ in range(4)]
    for waiting in greedy:
        for number in range(100):
            waiting.append(text(f"{number}"))
    assert everybody.waiting <= 40 * KIB
    assert min(len(waiting) for waiting in greedy) >= 6
    assert names(modest) == ["state"]


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["put", "take", "close"]), st.integers(0, 3), st.integers(0, 3), st.integers(0, 4000)
        ),
        max_size=80,
    )
)
def test_the_count_is_that_of_the_waiting_bytes_and_within_the_limit(steps: list[tuple[str, int, int, int]]) -> None:
    """In whatever order messages of two clients with two topics each come, are taken and are given up."""
    everybody = TotalBacklog(8 * KIB)
    backlogs = [Backlog(6 * KIB, everybody) for _ in range(2)]
    queues = [queue(backlogs[number // 2], 5, State if number % 2 else String) for number in range(4)]
    put = taken = 0
    closed: dict[int, int] = {}
    for step, place, key, size in steps:
        if step == "put" and place not in closed:
            message: Message = State(key=f"{key}", data="x" * size) if place % 2 else String(data="x" * size)
            queues[place].append(message)
            put += 1
        elif step == "take" and len(queues[place]):
            queues[place].popleft()
            taken += 1
        elif step == "close" and place not in closed:
            closed[place] = len(queues[place])
            queues[place].close()
        waiting = sum(len(one) for one in queues)
        assert put == taken + sum(one.lost for one in queues) + sum(closed.values()) + waiting
        assert everybody.waiting == sum(backlog.waiting for backlog in backlogs)
        assert all(
            (backlog.waiting > 0) == any(len(one) for one in queues[2 * number : 2 * number + 2])
            for number, backlog in enumerate(backlogs)
        )
        for number, backlog in enumerate(backlogs):
            alone = sum(len(one) for one in queues[2 * number : 2 * number + 2]) == 1
            assert backlog.waiting <= 6 * KIB or alone
    assert everybody.lost == sum(one.lost for one in queues)


def _closings() -> list[Callable[[Backlog, FeedQueue], None]]:
    return [lambda backlog, _queue: backlog.close(), lambda _backlog, waiting: waiting.close()]


def test_waiting_messages_are_freed_with_their_client_or_topic() -> None:
    """At once, not when the garbage collector comes by."""
    gc.disable()
    try:
        for close in _closings():
            for message_type in (String, State):
                everybody = TotalBacklog(1000 * KIB)
                backlog = Backlog(1000 * KIB, everybody)
                waiting = queue(backlog, message_type=message_type)
                messages = [
                    String(data=f"{one}") if message_type is String else State(key=f"{one}") for one in range(9)
                ]
                for message in messages:
                    waiting.append(message)
                left = [weakref.ref(message) for message in messages]
                del messages, message
                close(backlog, waiting)
                assert [one() for one in left] == [None] * 9
                assert (backlog.waiting, everybody.waiting, everybody.lost) == (0, 0, 0)
                waiting.append(String(data="too late"))
                assert len(waiting) == 0
    finally:
        gc.enable()
