from hypothesis import given
from hypothesis import strategies as st

from homebot.gateways.mqtt.timer_queue import TimerQueue


@given(st.lists(st.tuples(st.integers(0, 5), st.floats(0, 100)), max_size=300))
def test_the_last_plan_of_each_name_is_kept_in_the_order_of_time(plans: list[tuple[int, float]]) -> None:
    agenda, done = TimerQueue(), []
    for name, at in plans:
        agenda.plan(name, at, lambda at=at, name=name: done.append((at, name)))  # type: ignore[misc]
        assert len(agenda._heap) <= 2 * len(agenda) + 65
    while (deed := agenda.pop(100.0)) is not None:
        deed()
    wanted = dict(plans)
    assert sorted((at, name) for name, at in wanted.items()) == sorted(done)
    assert [at for at, _ in done] == sorted(at for at, _ in done)
    assert agenda.next() is None


def test_what_is_dropped_or_not_due_is_not_done() -> None:
    agenda = TimerQueue()
    agenda.plan("a", 1.0, lambda: None)
    agenda.plan("b", 2.0, lambda: None)
    agenda.drop("a")
    assert "a" not in agenda
    assert agenda.next() == 2.0
    assert agenda.pop(1.9) is None
    assert agenda.pop(2.0) is not None


def test_there_is_room_for_so_many_only_but_always_for_a_new_time() -> None:
    agenda = TimerQueue(max_deeds=1)
    assert agenda.plan("a", 1.0, lambda: None)
    assert not agenda.plan("b", 1.0, lambda: None)
    assert agenda.plan("a", 3.0, lambda: None)
    assert agenda.next() == 3.0
